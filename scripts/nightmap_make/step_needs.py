# SPDX-License-Identifier: Apache-2.0
"""Cores, memory and time of each job, for a cluster: lists/needs.txt, a line `JOB CORES MEMORY_MB MINUTES` per job.

They are what the job took last, by its newest receipts, with a margin; else what the pipeline declares. MINUTES 0: not known."""

import math
import os
import re

from nightmap_make.run_receipts import DAMAGED, read_receipt

MARGIN, LEAST_MB = 1.5, 500  # of memory: shards differ, and libraries take some
TIME_MARGIN, LEAST_MINUTES = 4, 10  # of time: a limit is there to end what hangs
NUM_RECEIPTS = 20  # of the units of a job that are looked at


def path_of(folder):
    return f"{folder}/lists/needs.txt"


def text(graph, threads):
    return "".join(_line(graph, job, threads) for job in graph.jobs.values() if not job.script)


def _line(graph, job, threads):
    memory_mb, minutes = job.memory_MB, 0
    taken = [(receipt["peak_memory_bytes"], receipt["wall_time_s"]) for receipt in _newest(graph, job)]
    if taken:
        memory_mb = max(LEAST_MB, math.ceil(MARGIN * max(peak for peak, _ in taken) / 1e6))
        minutes = max(LEAST_MINUTES, math.ceil(TIME_MARGIN * max(wall_s for _, wall_s in taken) / 60))
    return f"{job.name} {job.cores or threads} {memory_mb} {minutes}\n"


def _newest(graph, job):
    """The newest receipts of a job that can be read and say what was taken."""
    name = re.escape(job.run_files()["receipt"]).replace(re.escape("{unit}"), ".+")
    try:
        with os.scandir(graph.folder_of(job)) as entries:
            found = sorted((entry.stat().st_mtime_ns, entry.path) for entry in entries if re.fullmatch(name, entry.name))
    except OSError:
        return
    for _, path in found[-NUM_RECEIPTS:]:
        try:
            receipt, _, _ = read_receipt(path)
            if min(receipt["peak_memory_bytes"], receipt["wall_time_s"]) >= 0:
                yield receipt
        except DAMAGED:
            continue
