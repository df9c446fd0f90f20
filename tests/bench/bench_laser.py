#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""bench_laser: time and memory of the laser's programs as a function of the number of scans.

Repeats the log of a mapped laser site, lap after lap, as a robot that drives the same round again and again: the
same scans at later times, and the wheels' odometry goes on where it ended. Then runs scan_match, scan_loops, pose_graph,
scan_adjust, carry_scans and laser_grid, one after the other, with their default configs.
Prints a Markdown table of CPU milliseconds per scan and peak memory; with --page it goes between
`<!-- bench_laser:begin -->` and `<!-- bench_laser:end -->`.
Exit codes: 0 done; 1 a run failed; 2 wrong command line.
"""

import shutil
from pathlib import Path

from command_line import output_of, parser_of, put_into_page  # first: it makes the packages of scripts/ importable
import h5py
import numpy as np
from nightmap_eval.planar_poses import compose, inverse
from nightmap_eval.sealed_hdf5 import sealed
from nightmap_site.checked_reading import using
from nightmap_site.job_results import StageResult
from nightmap_site.script_errors import DataError, run_main

PAUSE_NS = 10**9  # between two laps
# Each program with its inputs and outputs; files are of the bench's folder.
PROGRAMS = {
    "scan_match": ({"scans": "scans.h5", "odometry": "odometry.h5"},
                   {"edges": "odometry_edges.h5", "trajectory": "matched.tum", "keyframes": "matched_keyframes.tum"}),
    "scan_loops": ({"scans": "scans.h5", "keyframes": "matched_keyframes.tum", "odometry": "odometry_edges.h5"},
                   {"edges": "loop_edges.h5"}),
    "pose_graph": ({"edges": ["odometry_edges.h5", "loop_edges.h5"]},
                   {"graph": "graph.h5", "trajectory": "graph.tum", "keyframes": "keyframes.tum"}),
    "scan_adjust": ({"scans": "scans.h5", "keyframes": "keyframes.tum", "odometry": "odometry_edges.h5"},
                    {"keyframes": "adjusted.tum"}),
    "carry_scans": ({"scans": "matched.tum", "keyframes": "adjusted.tum"},
                    {"trajectory": "trajectory.tum", "keyframes": "map_keyframes.tum"}),
    "laser_grid": ({"scans": "scans.h5", "trajectory": "trajectory.tum"},
                   {"floors": "floors.json", "pgm": "map.pgm", "yaml": "map.yaml", "png": "map.png"}),
}  # fmt: skip


class Log:
    """The samples of one signals file of a single sensor, to be written again lap after lap."""

    def __init__(self, path):
        with using(path), h5py.File(path) as file:
            self.attributes = dict(file.attrs)
            self.others = {name: file[name][()] for name in file if name not in ("time_ns", "value", "range_offset",
                                                                                     "range_m", "sample_offset")}  # fmt: skip
            self.time_ns, self.value = file["time_ns"][:].ravel(), file["value"][:]
            self.range_offset, self.range_m = file["range_offset"][:].ravel(), file["range_m"][:].ravel()
            if len(file["sample_offset"]) != 2:
                raise DataError(f"{path}: the log of one sensor is repeated, this file has {len(file['sample_offset']) - 1}")

    def write(self, path, time_ns, value, sample):
        """`sample`: of which sample the ranges are."""
        lengths = np.diff(self.range_offset)[sample]
        ranges = [self.range_m[self.range_offset[i] : self.range_offset[i + 1]] for i in sample]
        with sealed(path) as file:
            file.attrs.update(self.attributes)
            for name, data in self.others.items():
                file[name] = data
            file["sample_offset"] = np.array([[0], [len(time_ns)]], dtype=np.int64)
            file["time_ns"], file["value"] = time_ns[:, None], value
            file["range_offset"] = np.concatenate([[0], np.cumsum(lengths)]).astype(np.int64)[:, None]
            file["range_m"] = np.concatenate([*ranges, np.zeros(0)]).astype(np.float32)[:, None]


def repeat(frames, num_scans, folder):
    """scans.h5 and odometry.h5 of the first `num_scans` scans of as many laps as that takes."""
    scans, wheels = Log(frames / "scans.h5"), Log(frames / "odometry.h5")
    start_ns = min(scans.time_ns[0], wheels.time_ns[0])
    lap_ns = max(scans.time_ns[-1], wheels.time_ns[-1]) - start_ns + PAUSE_NS
    num_laps = -(-num_scans // len(scans.time_ns))
    laps = np.arange(num_laps)[:, None]
    times = (scans.time_ns[None] + laps * lap_ns).ravel()[:num_scans]
    sample = np.tile(np.arange(len(scans.time_ns)), num_laps)[:num_scans]
    scans.write(folder / "scans.h5", times, scans.value[sample], sample)
    poses, end = [], np.zeros(3)
    from_start = compose(inverse(wheels.value[0]), wheels.value)
    for _ in range(num_laps):
        poses.append(compose(end, from_start))
        end = poses[-1][-1]
    times = (wheels.time_ns[None] + laps * lap_ns).ravel()
    sample = np.tile(np.arange(len(wheels.time_ns)), num_laps)
    wheels.write(folder / "odometry.h5", times, np.concatenate(poses), sample)


def run(arguments, program, folder):
    inputs, outputs = PROGRAMS[program]
    command = [arguments.build / "run" / program, "--threads", arguments.threads, "--log-level", "warn"]
    for port, names in inputs.items():
        for name in [names] if isinstance(names, str) else names:
            command += ["--in", f"{port}={folder / name}"]
    (folder / program).mkdir()
    for port, name in (outputs | {kind: f"{program}/{kind}.json" for kind in ("report", "receipt")}).items():
        command += ["--out", f"{port}={folder / name}"]
    output_of(command)
    return StageResult(folder / program)


def row(arguments, num_scans):
    folder = arguments.build / "bench_laser" / str(num_scans)
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    repeat(arguments.site_dir / "frames", num_scans, folder)
    results = [run(arguments, program, folder) for program in PROGRAMS]
    return [result.cpu_time_s() for result in results], [result.peak_memory_bytes() / 2**20 for result in results]


def table(arguments):
    lines = [f"| scans | {' | '.join(f'{name} (ms)' for name in PROGRAMS)} | CPU ms per scan | largest memory (MiB) |",
             "|" + " ---: |" * (len(PROGRAMS) + 3)]  # fmt: skip
    for num_scans in arguments.scans:
        cpu_s, memory_mb = row(arguments, num_scans)
        each = " | ".join(f"{1000 * seconds / num_scans:.2f}" for seconds in cpu_s)
        lines.append(f"| {num_scans:,} | {each} | {1000 * sum(cpu_s) / num_scans:.2f} | {max(memory_mb):.0f} |")
        print(lines[-1], flush=True)
    return "".join(f"{line}\n" for line in lines)


def main():
    parser = parser_of(__doc__, "build", "threads", "page")
    parser.add_argument("site_dir", type=Path, help="maps/SITE with frames, of a laser site with wheels")
    parser.add_argument("--scans", type=int, nargs="+", default=[1000, 5000, 20000])
    arguments = parser.parse_args()
    text = table(arguments)
    put_into_page(arguments, "bench_laser", text)


if __name__ == "__main__":
    run_main(main)
