# SPDX-License-Identifier: Apache-2.0
"""A table of a run for the terminal: time, memory, counts and warnings per job."""

import json
import os
import re
from pathlib import Path

from nightmap_site.job_results import StageResult
from nightmap_site.script_errors import DataError

TITLES = ("job", "made", "time (s)", "CPU (s)", "memory (MB)", "skipped", "warnings", "counts")
WARNING = re.compile(rb"^\S+ (?:\x1b\[\S*)?warning", re.MULTILINE)
NUM_COUNTS = 3


def verdict_lines(site_dir, outcome):
    """Words of the last job that judged the recording or the map."""
    judged = [name for name in ("verdict", "check") if name in outcome.codes]
    if not judged:
        return []
    with open(f"{site_dir}/logs/{judged[0]}.log", encoding="utf-8", errors="replace") as log:
        return ["", *log.read().splitlines()]


def verdict_of(path):
    """The verdict in a verdict.json; empty if the file cannot be read, because an old one must not decide."""
    try:
        with open(path, encoding="utf-8") as file:
            return json.load(file)["verdict"]
    except (OSError, ValueError, KeyError, TypeError):
        return ""


def table(graph, site_dir, outcome):
    names = {rule.name: rule.job for rule in graph.rules}
    made = {}
    for name in outcome.codes:
        if name in names and not names[name].script:
            made.setdefault(names[name].folder, []).append(name)
    rows = [_row(graph, site_dir, folder, names_made) for folder, names_made in made.items()]
    if not rows:
        return []
    widths = [max(len(row[column]) for row in [TITLES, *rows]) for column in range(len(TITLES))]
    return ["", *(_line(row, widths) for row in [TITLES, *rows])]


def _line(row, widths):
    text = {0, len(TITLES) - 1}
    return "  ".join(cell.ljust(width) if column in text else cell.rjust(width)
                     for column, (cell, width) in enumerate(zip(row, widths))).rstrip()  # fmt: skip


def _row(graph, site_dir, folder, names):
    jobs = [job for job in graph.jobs.values() if job.folder == folder]
    num_units = sum(len(graph.units(job)) for job in jobs)
    logs = [path for path in (f"{site_dir}/logs/{name}.log" for name in names) if os.path.isfile(path)]
    warnings = str(sum(len(WARNING.findall(Path(path).read_bytes())) for path in logs))
    made = f"{len(names)} of {num_units}" if num_units > 1 else ""
    name = jobs[0].name
    try:
        result = StageResult(Path(graph.folder_of(jobs[0])), jobs[0].prefix)
        peak_bytes = result.peak_memory_bytes()
        return (name, made, _seconds(result.wall_time_s()), _seconds(result.cpu_time_s()),
                "" if peak_bytes is None else f"{peak_bytes / 1e6:.0f}", str(len(result.skipped())), warnings, _counts(result.figures()))  # fmt: skip
    except DataError as error:
        return (name, made, "", "", "", "", warnings, str(error))


def _seconds(value):
    return "" if value is None else f"{value:.1f}"


def _counts(figures):
    counts = [(name.removeprefix("num_").replace("_", " "), value) for name, value in figures.items()
              if name.startswith("num_") and isinstance(value, int)]  # fmt: skip
    return ", ".join(f"{value} {name}" for name, value in counts[:NUM_COUNTS])
