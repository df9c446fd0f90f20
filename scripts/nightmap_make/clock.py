# SPDX-License-Identifier: Apache-2.0
"""Files with times in the future, after the clock was set back: Make would take what changes now for older than they are.

They get times just before this run, in the same order; what Make says of them stays true. A program or a config may have changed
since the clock was set back, and its time would not tell: jobs whose receipts name another one run again.
"""

import os
import time
import tomllib

from nightmap_make.run_receipts import DAMAGED, read_receipt
from nightmap_make.slots import LazyHashes, slot_path

STEP_NS = 1_000
# The times of files lag behind the clock by a tick of the kernel.
TICK_NS = 50_000_000


def in_future(rules):
    """Whether a file of the rules has a time in the future. Knows the outputs of all rules, which are examined anyway."""
    for rule in {rule.job.name: rule for rule in rules.graph.rules}.values():  # what the rules of each job share
        for path in [*rules.prerequisites(rule), *rule.output_paths()]:
            if not path.startswith("$("):
                rules.times.of(path)
    now_ns = time.time_ns()
    return any(time_ns > now_ns for time_ns in rules.times.known().values())


def moved_times(rules, began_ns):
    """(path -> new time in ns, seconds by which the newest file is ahead). began_ns: when this run began, before it wrote a file."""
    graph, now_ns = rules.graph, time.time_ns()
    times = {**_below(graph.site.folder), **rules.times.known()}
    future_ns = sorted({time_ns for time_ns in times.values() if time_ns > now_ns})
    first_ns = began_ns - TICK_NS - STEP_NS * len(future_ns)
    new_ns = {time_ns: first_ns + STEP_NS * number for number, time_ns in enumerate(future_ns)}
    moved = {path: new_ns[time_ns] for path, time_ns in times.items() if time_ns > now_ns}
    return moved | dict.fromkeys(_to_renew(graph), now_ns), (future_ns[-1] - now_ns) / 1e9


def warning(moved, ahead_s, folder):
    days = f"{ahead_s / 86400:.0f} days" if ahead_s > 172800 else f"{ahead_s:.0f} s"
    return (f"nightmap: warning: files of {folder} have times in the future, up to {days} ahead, as after a clock was set back: "
            f"check the date of this machine. {len(moved)} files get times of now in the same order, and jobs run again whose "
            "receipts do not name the present program and options")  # fmt: skip


def _below(folder):
    """Times of the files below a folder, without hidden ones: those of runs that write, and of previews."""
    times = {}
    for place, folders, names in os.walk(folder):
        folders[:] = [name for name in folders if not name.startswith(".")]
        for name in names:
            path = os.path.join(place, name)
            if not name.startswith(".") and os.path.isfile(path):
                times[path] = os.stat(path).st_mtime_ns
    return times


def _to_renew(graph):
    """Configs of the programs, and slots of the scripts, whose jobs must run again."""
    hashes = LazyHashes()
    for job in graph.jobs.values():
        if job.script:
            yield slot_path(graph.site, job)
        elif not all(_is_made_by(graph, job, unit, hashes) for unit in graph.units(job)):
            yield graph.site.config_of(job)


def _is_made_by(graph, job, unit, hashes):
    """Whether the receipt of a run names the present program and config. (A run without one is made anyway.)"""
    path = graph.path_of(job, "receipt", unit)
    if not os.path.exists(path):
        return True
    try:
        receipt, whole, _ = read_receipt(path)
        with open(graph.site.config_of(job), "rb") as file:
            config = tomllib.load(file)
        program = {"path": f"{graph.site.build}/run/{job.program}", "xxh3": receipt["program"]["xxh3"]}
        return whole and tomllib.loads(receipt["config"]) == config and hashes.is_same(program)
    except DAMAGED:
        return False
