# SPDX-License-Identifier: Apache-2.0
"""After a failed or killed run: finds the failed jobs and the stale results, and writes the report that shows them."""

import contextlib
import json
import os
import sys

from nightmap_make import why
from nightmap_make.changed_files import write
from nightmap_make.journal import last_run
from nightmap_make.rules_file import RulesFile, Times

NUM_LINES = 20
NUM_STALE = 200


def tell_of_failure(run, code, outcome):
    failed = outcome.failed()
    for name, exit_code in failed.items():
        ended = f"exit code {exit_code}" if exit_code is not None else "did not come to its end"
        print(f"nightmap: {name}: {ended}; its log: {run.folder}/logs/{name}.log", file=sys.stderr)
    if write_page(run, code):
        print(f"nightmap: the report shows what was made, what failed and what is out of date: {run.folder}/report/index.html", file=sys.stderr)


def status_lines(outcome):
    if not outcome.codes and outcome.code is None:
        yield "no run is known"
    elif outcome.code is None:
        yield f"the last run, make {' '.join(outcome.goals)}, was killed, or goes on"
    else:
        yield f"the last run, make {' '.join(outcome.goals)}, ended with exit code {outcome.code}"
    for name, code in outcome.failed().items():
        yield f"{name}: {'did not come to its end' if code is None else f'exit code {code}'}"


def write_page(run, code):
    """Writes the report and, before it, unless the run ended well, failure.json for it. Returns whether the report was written."""
    path = f"{run.folder}/logs/failure.json"
    if code == 0 and os.path.exists(path):
        os.remove(path)
    elif code != 0:
        write(path, json.dumps(describe(run, code), indent=1))
    page = f"{run.folder}/report/index.html"
    command = [run.env["PYTHON"], "scripts/report.py", "--site-dir", run.folder, "--data", run.env["DATA"], "--out", page,
               "--of-what-is-whole"]
    _, status = os.waitpid(os.posix_spawnp(command[0], command, run.env), 0)
    return status == 0


def _end_of(log):
    with contextlib.suppress(OSError), open(log, encoding="utf-8", errors="replace") as file:
        return file.read().splitlines()[-NUM_LINES:]
    return []


def describe(run, code):
    """Content of failure.json: goals, failed jobs with the end of their logs, stale results."""
    outcome = last_run(run.folder)
    staleness = why.Staleness(RulesFile(run.graph, Times()))
    out_of_date = list(why.lines(staleness, run.env["BUILD"], run.asked.programs))
    return {"format": "nightmap failure", "version": 1, "goals": outcome.goals, "exit_code": code,
            "failed": [{"job": name, "exit_code": exit_code, "log": _end_of(f"{run.folder}/logs/{name}.log")}
                       for name, exit_code in outcome.failed().items()],
            "out_of_date": out_of_date[:NUM_STALE], "num_out_of_date": len(staleness.reasons)}  # fmt: skip
