#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""mrpt_localization: locates scans in a grid with the particle filter of MRPT, a peer of our localization.

Locates each query alone. The particles begin on the free cells of the map, or of the disc that the query names. The robot
stands still and sees its scans again at each step of the filter; the noise of the motion shrinks from step to step.
Needs MRPT 2.5 (Debian: apt-get install libmrpt-slam-dev) and g++: compiles mrpt_localization.cc into a temporary folder.
Prints JSON: figures per seed and their median, and the pose of each query and seed. A query counts as converged if the
particles' standard deviation is below --converged-m; as a wrong place if it converged more than 0.5 m from the truth.
Exit codes: 0 done; 1 a file is damaged or the run failed; 2 wrong command line, or MRPT is missing.
"""

import argparse
import glob
import json
import shutil
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
import checkout  # noqa: E402, F401  first: it makes the packages of scripts/ importable
from nightmap_eval.artifacts import read_hdf5  # noqa: E402
from nightmap_eval.grid import FREE, OCCUPIED, UNKNOWN, read_grid  # noqa: E402
from nightmap_eval.planar_poses import to_rows, wrapped_rad  # noqa: E402
from nightmap_eval.trajectory import read_tum  # noqa: E402
from nightmap_site.checked_reading import using  # noqa: E402
from nightmap_site.script_errors import DataError, run_main  # noqa: E402

PACKAGE = "libmrpt-slam-dev"
HEADERS = "/usr/include/mrpt/*/include"
LIBRARIES = "slam maps obs poses bayes math random serialization rtti containers config system core".split()
# MRPT's names. Values are those of its share/mrpt/config_files/pf-localization/localization_demo.ini, except where a comment
# says that we measured better ones: its demo sees a scan at many places, we see one scan many times.
SETTINGS = {
    "particles_count": 100000, "KLD_maxSampleSize": 100000,  # demo: 40000
    "KLD_minSampleSize": 150, "KLD_binSize_XY": 0.10, "KLD_binSize_PHI_deg": 10, "KLD_delta": 0.01,
    "KLD_epsilon": 0.02,  # demo: 0.01; 0.02 is MRPT's default
    "PF_algorithm": 0, "resamplingMethod": 0, "adaptiveSampleSize": 1, "BETA": 0.5,
    "powFactor": 0.3,  # demo: 1; keeps more than one place in the first steps
    "pfAuxFilterOptimal_MaximumSearchSamples": 10,
    "likelihoodMethod": 4, "LF_zHit": 0.95, "LF_zRandom": 0.05, "LF_maxRange": 80, "LF_alternateAverageMethod": 0,
    "LF_decimation": 5, "LF_stdHit": 0.20, "LF_maxCorrsDistance": 0.60,  # demo: 10, 0.40, 0.30
    "consensus_takeEachRange": 30, "consensus_pow": 1, "rayTracing_decimation": 10, "rayTracing_stdHit": 0.30,
    # Ours: how often the filter sees the scans, and the standard deviations of the motion at the first and the last step.
    "steps": 20, "first_noise_m": 0.10, "last_noise_m": 0.01, "first_noise_deg": 2.0, "last_noise_deg": 0.2,
}  # fmt: skip
WRONG_M = 0.5
LIMITS = ((0.05, 0.5), (0.10, 1.0), (0.50, 5.0))  # m, degrees
# Seconds are those of the processor; the filter has one thread.
FIELDS = ("query", "seed", "x_m", "y_m", "heading_rad", "variance_x_m2", "variance_y_m2", "variance_heading_rad2",
          "num_particles", "cpu_s")  # fmt: skip


def parse_arguments(words=None):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--map", type=Path, required=True, help="map.yaml of the grid, in the format of map_server")
    parser.add_argument("--queries", type=Path, required=True, help="queries.h5 of hold_out_scans")
    parser.add_argument("--truth", type=Path, required=True, help="truth.tum: map_from_robot at the times of the queries")
    parser.add_argument("--seeds", type=int, default=5, help="runs per query")
    parser.add_argument("--max-queries", type=int, default=0, help="locates this many, evenly spread; 0: all")
    parser.add_argument("--ignore-rough", action="store_true", help="searches everywhere, whatever the queries name")
    parser.add_argument("--converged-m", type=float, default=0.3, help="largest standard deviation of a converged filter")
    parser.add_argument("--set", action="append", default=[], metavar="NAME=VALUE", help=f"one of {', '.join(SETTINGS)}")
    arguments = parser.parse_args(words)
    if arguments.seeds < 1 or arguments.max_queries < 0 or not arguments.converged_m > 0:
        parser.error("--seeds and --converged-m must be positive, --max-queries not negative")
    arguments.settings = dict(SETTINGS)
    for word in arguments.set:
        name, _, value = word.partition("=")
        try:
            arguments.settings[name] = float(value) if name in SETTINGS else parser.error(f"--set {name}: no such setting")
        except ValueError:
            parser.error(f"--set {word}: not a number")
    return arguments


@dataclass
class Scan:
    query_from_laser: np.ndarray  # heading (rad), x, y (m)
    beams: np.ndarray  # first angle, step (rad), range limit (m)
    ranges_m: np.ndarray  # 0 where the beam hit nothing


@dataclass
class Query:
    time_ns: int
    scans: list
    rough: np.ndarray  # x, y and radius in the map; radius 0: anywhere


def read_queries(path):
    names = ("time_ns", "scan_offset", "query_from_laser", "beams", "range_offset", "range_m", "rough_position")
    times_ns, scan_offset, poses, beams, range_offset, ranges_m, rough = read_hdf5(path, *names)
    times_ns, scan_offset, range_offset, ranges_m = (a.ravel() for a in (times_ns, scan_offset, range_offset, ranges_m))
    sizes = (len(scan_offset) == len(times_ns) + 1 == len(rough) + 1 and len(range_offset) == len(poses) + 1 == len(beams) + 1)
    if not sizes or scan_offset[-1] != len(poses) or range_offset[-1] != len(ranges_m):
        raise DataError(f"{path}: sizes do not add up")
    for offset in (scan_offset, range_offset):
        if offset[0] != 0 or np.any(np.diff(offset) < 0):
            raise DataError(f"{path}: offsets do not increase from 0")
    scans = []
    for i, (pose, beam) in enumerate(zip(poses, beams)):
        ranges = ranges_m[range_offset[i] : range_offset[i + 1]].astype(float)
        scans.append(Scan(pose, beam, np.where((ranges > 0) & (ranges < beam[2]), ranges, 0)))  # NaN is not below
    starts = zip(scan_offset[:-1], scan_offset[1:])
    return [Query(int(t), scans[a:b], r) for t, (a, b), r in zip(times_ns, starts, rough)]


def spread(items, num):
    """`num` of the items, evenly spread; 0: all."""
    if not 0 < num < len(items):
        return items
    return [items[i] for i in np.linspace(0, len(items) - 1, num).round().astype(int)]


def true_poses(path, queries):
    """x, y, heading (n, 3)."""
    truth = read_tum(path)
    row = {int(time_ns): i for i, time_ns in enumerate(truth.times_ns)}
    missing = [query.time_ns for query in queries if query.time_ns not in row]
    if missing:
        raise DataError(f"{path}: no pose at {missing[0]} ns, the time of a query; give the truth of the same queries")
    return to_rows(truth.select([row[query.time_ns] for query in queries]))


def input_text(grid, queries, ignore_rough):
    """The input of mrpt_localization.cc, in the frame of the grid: its first cell begins at (0, 0)."""
    rows, columns = grid.cells.shape
    digits = np.zeros(3, dtype=np.uint8)
    digits[[UNKNOWN, FREE, OCCUPIED]] = [ord("0"), ord("1"), ord("2")]
    lines = [f"grid {columns} {rows} {grid.resolution_m}", *(digits[row].tobytes().decode() for row in grid.cells)]
    cosine, sine = np.cos(grid.origin_yaw_rad), np.sin(grid.origin_yaw_rad)
    for query in queries:
        x, y = query.rough[0] - grid.origin_x_m, query.rough[1] - grid.origin_y_m
        radius_m = 0 if ignore_rough else query.rough[2]
        lines.append(f"query {len(query.scans)} {cosine * x + sine * y} {-sine * x + cosine * y} {radius_m}")
        for scan in query.scans:
            numbers = [*scan.query_from_laser, *scan.beams, len(scan.ranges_m), *scan.ranges_m]
            lines.append("scan " + " ".join(f"{number:.9g}" for number in numbers))
    return "\n".join(lines) + "\n"


def results(text, grid, truth, converged_m):
    """The runs of mrpt_localization.cc as dictionaries, in the map frame and with errors."""
    rows = []
    for line in text.splitlines():
        row = dict(zip(FIELDS, (float(word) for word in line.split()), strict=True))
        for name in ("query", "seed", "num_particles"):
            row[name] = int(row[name])
        cell = row["x_m"] / grid.resolution_m, row["y_m"] / grid.resolution_m
        row["x_m"], row["y_m"] = (float(value) for value in grid.from_cells(*cell))
        row["heading_rad"] = float(wrapped_rad(row["heading_rad"] + grid.origin_yaw_rad))
        x, y, heading_rad = truth[row["query"]]
        row["error_m"] = float(np.hypot(row["x_m"] - x, row["y_m"] - y))
        row["error_deg"] = float(np.degrees(abs(wrapped_rad(row["heading_rad"] - heading_rad))))
        row["deviation_m"] = float(np.sqrt(row["variance_x_m2"] + row["variance_y_m2"]))
        row["converged"] = row["deviation_m"] < converged_m
        rows.append(row)
    return rows


def summary(rows, num_queries):
    """Figures of one seed. A query without a converged result has an infinite error, and none counts as within a limit."""
    good = [row for row in rows if row["converged"]]
    errors = np.full((num_queries, 2), np.inf)
    errors[: len(good)] = np.array([(row["error_m"], row["error_deg"]) for row in good]).reshape(-1, 2)
    figures = {"converged_percent": 100 * len(good) / num_queries}
    for limit_m, limit_deg in LIMITS:
        within = np.mean((errors[:, 0] <= limit_m) & (errors[:, 1] <= limit_deg))
        figures[f"within_{100 * limit_m:.0f}cm_{limit_deg:g}deg_percent"] = 100 * float(within)
    figures["wrong_place_percent"] = 100 * sum(row["error_m"] > WRONG_M for row in good) / num_queries
    figures["median_error_m"], figures["median_error_deg"] = (median(column) for column in errors.T)
    figures["cpu_s_per_query"] = sum(row["cpu_s"] for row in rows) / num_queries
    return figures


def median(values):
    """The upper one of the two in the middle: half infinite is infinite, and no NaN arises."""
    return float(np.sort(values)[len(values) // 2])


def median_of_seeds(figures):
    return {name: median([each[name] for each in figures]) for name in figures[0]}


def printable(value):
    """JSON has no infinity: null is a failure."""
    if isinstance(value, dict):
        return {key: printable(item) for key, item in value.items()}
    if isinstance(value, list):
        return [printable(item) for item in value]
    return None if isinstance(value, float) and not np.isfinite(value) else value


def compile_filter(folder):
    folders = glob.glob(HEADERS)
    if not any(Path(folder).joinpath("mrpt/slam/CMonteCarloLocalization2D.h").exists() for folder in folders):
        print(f"error: MRPT is missing: apt-get install {PACKAGE} (2.5 of Debian 12)", file=sys.stderr)
        sys.exit(2)
    if not shutil.which("g++"):
        print("error: g++ is missing: apt-get install g++", file=sys.stderr)
        sys.exit(2)
    program = Path(folder) / "mrpt_localization"
    command = ["g++", "-std=c++17", "-O2", Path(__file__).with_suffix(".cc"), "-o", program, "-isystem", "/usr/include/eigen3"]
    command += [word for folder in folders for word in ("-isystem", folder)] + [f"-lmrpt-{name}" for name in LIBRARIES]
    if subprocess.run(command, check=False).returncode:
        raise DataError("mrpt_localization.cc does not compile, see above")
    return program


def locate(arguments, grid, queries):
    with tempfile.TemporaryDirectory() as folder:
        command = [compile_filter(folder), *(f"{name}={value}" for name, value in arguments.settings.items())]
        text = input_text(grid, queries, arguments.ignore_rough)
        run = subprocess.run([*command, f"seeds={arguments.seeds}"], input=text, stdout=subprocess.PIPE, text=True, check=False)
    if run.returncode:
        raise DataError("the filter failed, see above")
    return run.stdout


def main():
    arguments = parse_arguments()
    grid = read_grid(arguments.map)
    with using(arguments.queries):
        queries = spread(read_queries(arguments.queries), arguments.max_queries)
    if not queries:
        raise DataError(f"{arguments.queries}: no queries")
    truth = true_poses(arguments.truth, queries)
    rows = results(locate(arguments, grid, queries), grid, truth, arguments.converged_m)
    per_seed = [summary([r for r in rows if r["seed"] == seed], len(queries)) for seed in range(1, arguments.seeds + 1)]
    for row in rows:
        row["time_ns"] = queries[row["query"]].time_ns
    content = {"settings": arguments.settings, "num_queries": len(queries), "num_seeds": arguments.seeds,
               "summary": median_of_seeds(per_seed), "seeds": per_seed, "queries": rows}  # fmt: skip
    print(json.dumps(printable(content), indent=1))


if __name__ == "__main__":
    run_main(main)
