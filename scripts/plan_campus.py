#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""plan_campus: how long many buildings take on a cluster of several sizes, from what one site took here.

Every job of SITE_DIR (maps/SITE after make map) is scaled to the frames of a building by its receipts: jobs of a shard or a tile come
as often as there are frames for them, time and memory of jobs of the whole site grow with the frames. The schedule is simulated: a task starts when all that it
reads is made and a node has its cores and memory free, those of the building that has the most left first; each task adds the start of
a step. Prints a Markdown table per number of nodes: time, use of the cores, the longest chain of one building (no cluster is
faster), what most of the time goes to, and the rate at which files are read and written.
Exit codes: 0 done; 1 a result is missing or damaged; 2 wrong command line.
"""

import argparse
import heapq
import math
from collections import defaultdict
from dataclasses import dataclass, field
from pathlib import Path

from nightmap_site.checked_reading import read_object, using
from nightmap_site.job_results import StageResult
from nightmap_site.pipeline import closure
from nightmap_site.script_errors import DataError, run_main
from nightmap_site.site import Site


@dataclass
class JobCost:
    """A task of a job takes wall_s at `cores`, and reads and writes num_bytes, for so many frames (0: all)."""

    name: str
    unit: str
    frames: float
    wall_s: float
    cores: int
    memory_mb: float
    num_bytes: float
    before: list = field(default_factory=list)


def read_costs(site_dir, threads):
    """The costs of each job of `make map` that ran, in the order of the pipeline, and the number of frames. Raises DataError."""
    site = Site(site_dir)
    num_frames = read_object(site.needed("frames", "report"), {"num_frames": int})["num_frames"]
    costs = {}
    needed = closure(site.pipeline, ("map",))
    for name, job in site.pipeline.jobs.items():
        if name not in needed or job.script or job.when == "synthetic":
            continue
        result = StageResult(site_dir / job.folder, job.prefix)
        runs = [receipt for receipt in result.receipts if receipt.get("stage", job.program) == job.program]
        if not runs:
            continue  # of a part that the site lacks
        count = len(runs)
        with using(f"{site_dir / job.folder}: receipts"):
            costs[name] = JobCost(name, job.unit, num_frames / count if job.unit != "site" else 0,
                                  sum(run["wall_time_s"] for run in runs) / count, job.cores or threads,
                                  max(run["peak_memory_bytes"] for run in runs) / 1e6,
                                  sum(entry.get("size_bytes", 0) for run in runs for entry in run["inputs"] + run["outputs"]) / count,
                                  job.jobs_before())  # fmt: skip
    if not costs:
        raise DataError(f"{site_dir}: no receipts of a map; run make map")
    return costs, num_frames


@dataclass
class Task:
    cost: JobCost
    building: int
    scale: float  # of a task of the whole site
    missing: int = 0
    after: list = field(default_factory=list)
    rank_s: float = 0  # the longest chain from here on

    def memory_mb(self):
        return self.cost.memory_mb * self.scale

    def wall_s(self, start_s):
        return self.cost.wall_s * self.scale + start_s


def building_tasks(costs, num_frames, frames, building):
    """The tasks of a building with `frames` frames, each after all tasks of the jobs before it."""
    tasks = {}
    for name, cost in costs.items():
        count = max(1, math.ceil(frames / cost.frames)) if cost.frames else 1
        scale = frames / num_frames if not cost.frames else 1
        tasks[name] = [Task(cost, building, scale) for _ in range(count)]
        for before in filter(tasks.__contains__, cost.before):
            pairs = zip(tasks[before], tasks[name]) if len(tasks[before]) == count > 1 else None
            if pairs:  # shard by shard
                for first, then in pairs:
                    first.after.append(then)
                    then.missing += 1
            else:
                join = Task(JobCost("", "", 0, 0, 0, 0, 0), building, 0)  # so that n x m tasks need n + m arrows
                for first in tasks[before]:
                    first.after.append(join)
                join.missing, join.after = len(tasks[before]), list(tasks[name])
                tasks.setdefault("", []).append(join)
                for then in tasks[name]:
                    then.missing += 1
    return [task for group in tasks.values() for task in group]


def rank(tasks, start_s):
    """Sets the longest chain from each task on; returns the longest of all."""
    order, seen = [], set()
    for root in tasks:
        stack = [(root, False)]
        while stack:
            task, done = stack.pop()
            if done:
                order.append(task)
            elif id(task) not in seen:
                seen.add(id(task))
                stack += [(task, True), *((then, False) for then in task.after)]
    for task in order:
        own_s = task.wall_s(start_s) if task.cost.name else 0
        task.rank_s = own_s + max((then.rank_s for then in task.after), default=0)
    return max(task.rank_s for task in tasks)


def simulate(tasks, num_nodes, cores, memory_mb, start_s):
    """Seconds until all is done, and core seconds by job."""
    free = [[cores, memory_mb] for _ in range(num_nodes)]
    ready, running, now_s, serial, used = [], [], 0.0, 0, defaultdict(float)

    def release(task):
        nonlocal serial
        serial += 1
        heapq.heappush(ready, (-task.rank_s, serial, task))

    def done(task):
        for then in task.after:
            then.missing -= 1
            if then.missing == 0:
                release(then) if then.cost.name else done(then)

    for task in [task for task in tasks if task.missing == 0]:
        release(task) if task.cost.name else done(task)
    while ready or running:
        left = []
        while ready:
            entry = heapq.heappop(ready)
            cost = entry[2].cost
            need = min(cost.cores, cores), min(entry[2].memory_mb(), memory_mb)
            node = next((i for i, room in enumerate(free) if room[0] >= need[0] and room[1] >= need[1]), None)
            if node is None:
                left.append(entry)
                if len(left) > 4:  # the cluster is full
                    break
                continue
            free[node][0] -= need[0]
            free[node][1] -= need[1]
            wall_s = entry[2].wall_s(start_s)
            used[cost.name] += wall_s * need[0]
            serial += 1
            heapq.heappush(running, (now_s + wall_s, serial, node, need, entry[2]))
        for entry in left:
            heapq.heappush(ready, entry)
        now_s, _, node, need, task = heapq.heappop(running)
        free[node][0] += need[0]
        free[node][1] += need[1]
        done(task)
    return now_s, used


def row(costs, num_frames, arguments, num_nodes):
    """Cells of one size of the cluster."""
    frames = arguments.frames / arguments.buildings
    tasks, longest_s = [], 0
    for building in range(arguments.buildings):
        of_building = building_tasks(costs, num_frames, frames, building)
        longest_s = max(longest_s, rank(of_building, arguments.step_s))
        tasks += of_building
    num_tasks = sum(bool(task.cost.name) for task in tasks)
    starts_s = arguments.step_s * sum(min(task.cost.cores, arguments.cores) for task in tasks)  # of cores, which wait meanwhile
    num_bytes = sum(task.cost.num_bytes * (task.scale if task.cost.unit == "site" else 1) for task in tasks)
    wall_s, used = simulate(tasks, num_nodes, arguments.cores, arguments.memory_gb * 1000, arguments.step_s)
    most = max(used, key=used.get)
    return [str(num_nodes), f"{num_tasks:,}", f"{wall_s / 3600:.1f}", f"{100 * sum(used.values()) / (wall_s * num_nodes * arguments.cores):.0f}",
            f"{longest_s / 3600:.1f}", f"{most} ({100 * used[most] / sum(used.values()):.0f} %)",
            f"{100 * starts_s / sum(used.values()):.1f}", f"{num_bytes / 1e6 / wall_s:.0f}"]  # fmt: skip


TITLES = ("nodes", "tasks", "time (h)", "cores in use (%)", "longest chain of a building (h)", "most core time", "start of steps (%)",
          "files (MB/s)")  # fmt: skip


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("site_dir", type=Path, help="maps/SITE whose receipts say what a job takes")
    parser.add_argument("--buildings", type=int, default=100)
    parser.add_argument("--frames", type=int, default=10_000_000, help="of all buildings")
    parser.add_argument("--nodes", type=int, nargs="+", default=[1, 8, 64])
    parser.add_argument("--cores", type=int, default=16, help="of a node")
    parser.add_argument("--memory-gb", type=float, default=64, help="of a node")
    parser.add_argument("--threads", type=int, default=2, help="THREADS of the make that wrote the receipts; a task gets as many")
    parser.add_argument("--step-s", type=float, default=0.1, help="that the start of a step takes")
    arguments = parser.parse_args()
    if min(arguments.buildings, arguments.frames, arguments.cores, arguments.threads, *arguments.nodes) < 1 or arguments.frames < arguments.buildings:
        parser.error("all numbers must be 1 or more, and a building needs a frame")
    costs, num_frames = read_costs(arguments.site_dir, min(arguments.threads, arguments.cores))
    print(f"| {' | '.join(TITLES)} |\n|{'---:|' * len(TITLES)}")
    for num_nodes in arguments.nodes:
        print(f"| {' | '.join(row(costs, num_frames, arguments, num_nodes))} |", flush=True)


if __name__ == "__main__":
    run_main(main)
