# SPDX-License-Identifier: Apache-2.0
"""After a run that failed or was killed: what failed, what is out of date since, and the page that says so."""

import json
import os
import sys

from nightmap_make import why
from nightmap_make.journal import last_run
from nightmap_make.rules_file import RulesFile, Times

NUM_LINES = 20
NUM_STALE = 200


def tell_of_failure(run, code, outcome):
    """Says on the terminal what failed, and writes the page."""
    failed = outcome.failed()
    for name, exit_code in failed.items():
        ended = f"exit code {exit_code}" if exit_code is not None else "did not come to its end"
        print(f"nightmap: {name}: {ended}; its log: {run.folder}/logs/{name}.log", file=sys.stderr)
    write_page(run, code)
    print(f"nightmap: what was made, what failed and what is out of date: {run.folder}/report/index.html", file=sys.stderr)


def status_lines(outcome):
    """How the last run ended."""
    if not outcome.codes and outcome.code is None:
        yield "no run is known"
    elif outcome.code is None:
        yield f"the last run, make {' '.join(outcome.goals)}, was killed, or goes on"
    else:
        yield f"the last run, make {' '.join(outcome.goals)}, ended with exit code {outcome.code}"
    for name, code in outcome.failed().items():
        yield f"{name}: {'did not come to its end' if code is None else f'exit code {code}'}"


def write_page(run, code):
    """The report; before it, unless the run ended well, failure.json for it. Whether the report could be written."""
    path = f"{run.folder}/logs/failure.json"
    if code == 0 and os.path.exists(path):
        os.remove(path)
    elif code != 0:
        with open(f"{path}.tmp", "w", encoding="utf-8") as file:
            json.dump(describe(run, code), file, indent=1)
        os.replace(f"{path}.tmp", path)
    page = f"{run.folder}/report/index.html"
    command = [run.env["PYTHON"], "scripts/report.py", "--site-dir", run.folder, "--data", run.env["DATA"], "--out", page]
    _, status = os.waitpid(os.posix_spawnp(command[0], command, run.env), 0)
    return status == 0


def describe(run, code):
    """What the page says of the run: goals, jobs that failed with the end of their logs, what is out of date."""
    outcome = last_run(run.folder)
    staleness = why.Staleness(RulesFile(run.graph, Times()))
    out_of_date = list(why.lines(staleness, run.env["BUILD"]))
    return {"format": "nightmap failure", "version": 1, "goals": outcome.goals, "exit_code": code,
            "failed": [{"job": name, "exit_code": exit_code, "log": _end_of(f"{run.folder}/logs/{name}.log")}
                       for name, exit_code in outcome.failed().items()],
            "out_of_date": out_of_date[:NUM_STALE], "num_out_of_date": len(staleness.reasons)}  # fmt: skip


def _end_of(log):
    try:
        with open(log, encoding="utf-8", errors="replace") as file:
            return file.read().splitlines()[-NUM_LINES:]
    except OSError:
        return []
