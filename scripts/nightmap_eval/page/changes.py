# SPDX-License-Identifier: Apache-2.0
"""Changes since the run before: options, figures and times. The page keeps them in a file beside it, from one run to the next."""

import json
import tomllib

from nightmap_eval import html
from nightmap_eval.artifacts import write_atomic
from nightmap_site.checked_reading import read_object, read_text, using
from nightmap_site.script_errors import DataError

NAME = "runs.json"
FORM = {"format": str, "version": int, "now": {"options": dict, "figures": dict, "times_s": dict}, "?before": {"options": dict, "figures": dict, "times_s": dict}}
MIN_S, MIN_SHARE = 1.0, 0.2  # a job's time changed by at least this


def state_of(site, metrics, stages, verdict):
    """Options, figures and times of the map as it is. Paths and queries change without it."""
    jobs, options = [job for job in site.pipeline.jobs.values() if job.goal == "map"], {}
    for path in sorted({site.config / f"{job.options}.toml" for job in jobs if job.options}):
        if path.exists():
            with using(path):
                options[path.stem] = {key: str(value) for key, value in tomllib.loads(read_text(path)).items()}
    figures = {name: value for table in ("coverage", "trajectory", "loops") for name, value in _flat(table, metrics.get(table, {}))}
    for job, table in metrics.get("sections", {}).items():
        figures |= dict(_flat(job, table))
    if verdict:
        figures["verdict"] = verdict["verdict"]
        figures |= {item["name"]: item["value"] for item in verdict["checks"] if "value" in item}
    folders = {job.folder for job in jobs}
    times_s = {stage.name: stage.wall_time_s() for stage in stages if stage.name in folders and stage.wall_time_s() is not None}
    return {"options": options, "figures": figures, "times_s": times_s}


def _flat(prefix, value):
    """(name, number or text) of all figures of a table; lists are no figures."""
    for key, item in value.items() if isinstance(value, dict) else ():
        name = f"{prefix} {key}"
        if isinstance(item, dict):
            yield from _flat(name, item)
        elif isinstance(item, (int, float, str)):
            yield name, item


def read_runs(folder):
    """The file of the page before; nothing where there is none. One that is damaged is begun anew: it is no result."""
    path = folder / NAME
    try:
        runs = read_object(path, FORM) if path.exists() else {}
    except DataError:
        return {}
    tables = [table for state in ("now", "before") for table in runs.get(state, {}).get("options", {}).values()]
    return runs if all(isinstance(table, dict) for table in tables) else {}


def next_runs(runs, state):
    """The file's next content. The same results twice are one run."""
    before = runs.get("before") if runs.get("now") == state else runs.get("now")
    return {"format": "nightmap runs", "version": 1, "now": state} | ({"before": before} if before else {})


def write_runs(folder, runs):
    write_atomic(folder / NAME, json.dumps(runs, indent=1, sort_keys=True) + "\n")


def changes_section(runs):
    """None before a second run."""
    if "before" not in runs:
        return None
    before, now = runs["before"], runs["now"]
    options = [(f"{job}.{key}", old, new) for job in sorted({*before["options"], *now["options"]})
               for key, old, new in _differences(before["options"].get(job, {}), now["options"].get(job, {}))]  # fmt: skip
    figures = list(_differences(before["figures"], now["figures"]))
    times = [row for row in _differences(before["times_s"], now["times_s"]) if _is_slower_or_faster(*row[1:])]
    parts = [part for title, names, rows in (("Options", ("option", "before", "now"), options), ("Figures", ("figure", "before", "now"), figures),
                                             ("Time of jobs (s)", ("job", "before", "now"), times))
             for part in ((html.Raw(f"<h3>{title}</h3>"), html.table(names, rows)) if rows else ())]  # fmt: skip
    return html.section("What changed since the run before", *(parts or [html.paragraph("No option and no figure.", "note")]))


def _differences(before, now):
    for key in sorted({*before, *now}):
        if before.get(key) != now.get(key):
            yield key, *("-" if value is None else value for value in (before.get(key), now.get(key)))


def _is_slower_or_faster(before, now):
    numbers = isinstance(before, (int, float)) and isinstance(now, (int, float))
    return not numbers or abs(now - before) > max(MIN_S, MIN_SHARE * before)
