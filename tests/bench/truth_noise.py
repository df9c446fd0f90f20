#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""truth_noise: how much of the difference between laser maps and their truth is noise of the truth.

Where the truth of a laser log is the result of another system, two witnesses tell whose error a difference is. Where the
wheels did not turn, the robot stood still, and every motion from scan to scan is an error. And the wheels' own motion from
scan to scan errs independently of both: of map and truth, the one that differs less from the wheels is right more often,
by the difference of the squares. Prints a Markdown table, which tests/bench/figures.py puts into the page.
Exit codes: 0 done; 1 a result is missing; 2 wrong command line.
"""

import argparse
from pathlib import Path

import checkout  # noqa: F401  first: it makes the packages of scripts/ importable
import numpy as np
from nightmap_eval.artifacts import read_hdf5
from nightmap_eval.planar_poses import to_rows
from nightmap_eval.trajectory import interpolated, read_tum
from nightmap_site.script_errors import DataError, run_main
from nightmap_site.site import Site

STILL_M, STILL_RAD = 1e-4, 1e-4  # of the wheels
MAX_GAP_NS = 500_000_000


def steps(poses):
    """Motion from each pose to the next one, as the former sees it: x, y, heading in [-pi, pi]."""
    cosine, sine = np.cos(poses[:-1, 2]), np.sin(poses[:-1, 2])
    x, y = np.diff(poses[:, 0]), np.diff(poses[:, 1])
    turn = np.diff(poses[:, 2])
    return np.column_stack([cosine * x + sine * y, cosine * y - sine * x, np.arctan2(np.sin(turn), np.cos(turn))])


def rms(values):
    return float(np.sqrt(np.mean(np.square(values)))) if len(values) else None


def noise(wheels, truth, estimate):
    """Figures of the poses (n, 3) of the same scans by the wheels, by the truth, and in the map."""
    by_wheels, by_truth, by_map = steps(wheels), steps(truth), steps(estimate)
    still = (np.abs(by_wheels) < [STILL_M, STILL_M, STILL_RAD]).all(axis=1)
    figures = {"num_still": int(still.sum())}
    for name, motion in (("truth", by_truth), ("map", by_map)):
        figures[f"still_{name}_cm"] = rms(100 * np.linalg.norm(motion[still, :2], axis=1))
        figures[f"still_{name}_deg"] = rms(np.degrees(motion[still, 2]))
    for name, a, b in (("wheels_truth", by_wheels, by_truth), ("wheels_map", by_wheels, by_map), ("map_truth", by_map, by_truth)):
        turn = a[:, 2] - b[:, 2]
        figures[f"{name}_deg"] = rms(np.degrees(np.arctan2(np.sin(turn), np.cos(turn))))
    return figures


def figures_of(site_dir):
    site = Site(site_dir)
    estimate = read_tum(site.needed("map_frame", "trajectory"))
    times_ns, values, offsets = read_hdf5(site.needed("frames", "odometry"), "time_ns", "value", "sample_offset")
    if len(np.ravel(offsets)) != 2 or not site.robot_truth.exists():
        raise DataError(f"{site_dir}: needs the odometry of one sensor and [robot_truth]")
    rows, truth = interpolated(read_tum(site.robot_truth), estimate.times_ns, MAX_GAP_NS)
    wheels_at = np.searchsorted(np.ravel(times_ns), estimate.times_ns[rows])
    known = wheels_at < len(np.ravel(times_ns))
    known[known] &= np.ravel(times_ns)[wheels_at[known]] == estimate.times_ns[rows][known]
    return noise(values[wheels_at[known]], to_rows(truth)[known], to_rows(estimate)[rows][known])


def show(value):
    return "n/a" if value is None else f"{value:.2f}"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("site_dirs", nargs="+", type=Path, help="maps/SITE of laser sites with wheels and truth")
    arguments = parser.parse_args()
    print("| | motions at rest | truth (cm) | map (cm) | truth (deg) | map (deg) | wheels to truth (deg) | wheels to map (deg) "
          "| map to truth (deg) |\n|---|" + "---:|" * 8)  # fmt: skip
    for site_dir in arguments.site_dirs:
        figures = figures_of(site_dir)
        keys = ("still_truth_cm", "still_map_cm", "still_truth_deg", "still_map_deg", "wheels_truth_deg", "wheels_map_deg", "map_truth_deg")
        print(f"| {site_dir.name} | {figures['num_still']} | {' | '.join(show(figures[key]) for key in keys)} |")


if __name__ == "__main__":
    run_main(main)
