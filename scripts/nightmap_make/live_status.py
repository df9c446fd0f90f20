# SPDX-License-Identifier: Apache-2.0
"""Says how far a make is that goes on: jobs done, those that run and where, and the time left by the receipts of earlier runs."""

import glob
import json
import os
import time

from nightmap_make import why
from nightmap_make.journal import last_run
from nightmap_make.run_receipts import receipts_in
from nightmap_site.script_errors import printable

SHOWN = 30  # running jobs


def tell(run):
    """Prints the status of the make that holds the site's lock; run: the MakeRun of this call, a preview."""
    outcome = last_run(run.folder)
    if "make" not in outcome.begun_s or outcome.code is not None:
        print(f"process {holder(run.folder)} holds the site, and has begun no job yet")
        return 0
    needed = run.asked.needed_jobs(outcome.goals)
    stale = [rule for rule in why.Staleness(run.rules).reasons if rule.job.name in needed]
    print(printable("\n".join(lines(run.folder, outcome, stale, time.time()))))
    return 0


def lines(folder, outcome, stale, now_s):
    """outcome: of journal.last_run; stale: rules that are still to be made, those that run among them."""
    running = [name for name, code in outcome.codes.items() if code is None]
    done = sum(code == 0 for code in outcome.codes.values())
    waiting = [rule for rule in stale if rule.name not in outcome.codes]
    times = _Times(stale)
    since = time.strftime("%H:%M:%S", time.localtime(outcome.begun_s["make"]))
    yield (f"make {' '.join(outcome.goals)} goes on since {since}, by process {holder(folder)}: "
           f"{done} jobs done, {len(running)} run, {len(waiting)} wait")  # fmt: skip
    of_name = {rule.name: rule for rule in stale}
    left_s = sum(time_s for rule in waiting if (time_s := times.of(rule)) is not None)
    for name in running:
        ran_s, usual_s = now_s - outcome.begun_s[name], times.of(of_name[name]) if name in of_name else None
        left_s += max(0, (usual_s or 0) - ran_s)
        if running.index(name) < SHOWN:
            yield f"  {name:<24} {_node(folder, name):<8} {duration(ran_s)}{'' if usual_s is None else f' of about {duration(usual_s)}'}"
    if len(running) > SHOWN:
        yield f"  and {len(running) - SHOWN} more"
    for name, code in outcome.codes.items():
        if code:
            yield f"  {name}: failed, exit code {code}; its log: {folder}/logs/{name}.log"
    unknown = sorted({rule.job.name for rule in stale if times.of(rule) is None})
    if len(unknown) < len({rule.job.name for rule in stale}):
        more = f", without {', '.join(unknown)}, of which no time is known" if unknown else ""
        yield f"left: about {duration(left_s / max(1, len(running)))}, by earlier runs with {max(1, len(running))} jobs at a time{more}"


def holder(folder):
    try:
        with open(f"{folder}/.lock", encoding="utf-8", errors="replace") as file:
            return file.read().split(" since ")[0].strip() or "(unknown)"
    except OSError:
        return "(unknown)"


def duration(seconds):
    minutes, hours = seconds / 60, seconds / 3600
    return f"{seconds:.0f} s" if seconds < 100 else f"{minutes:.0f} min" if minutes < 100 else f"{hours:.1f} h"


class _Times:
    """Seconds that rules took last, or other rules of the same job in the mean; None where nothing is known."""

    def __init__(self, rules):
        self._own, self._of_job = {}, {}
        folders = {os.path.dirname(dict(rule.outputs)["receipt"]) for rule in rules if not rule.job.script}
        for path in receipts_in(folders):
            try:
                with open(path, encoding="utf-8") as file:
                    receipt = json.load(file)
                self._own[path] = float(receipt["wall_time_s"])
                self._of_job.setdefault((os.path.dirname(path), receipt["stage"]), []).append(self._own[path])
            except (OSError, ValueError, KeyError, TypeError):
                continue

    def of(self, rule):
        path = dict(rule.outputs).get("receipt")
        if path is None:
            return None
        known = self._of_job.get((os.path.dirname(path), rule.job.program))
        return self._own.get(path, known and sum(known) / len(known))


def _node(folder, name):
    """The node that a job runs on, if on_slurm.sh started it."""
    for path in sorted(glob.glob(f"{glob.escape(folder)}/logs/{glob.escape(name)}.ended.*"), reverse=True):
        try:
            with open(path, encoding="utf-8") as file:
                return file.readline().removeprefix("on ").strip()
        except OSError:
            continue
    return ""
