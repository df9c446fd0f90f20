# SPDX-License-Identifier: Apache-2.0
"""Checks of a map of laser scans: poses of all scans, and walls that are drawn once."""

import numpy as np

from nightmap_eval.artifacts import read_hdf5
from nightmap_eval.laser.laser_accuracy import floors_walls, scan_counts, scan_times_ns
from nightmap_eval.laser.verdict_wheels import wheel_checks
from nightmap_eval.loop_accuracy import read_loops
from nightmap_eval.trajectory import read_tum
from nightmap_eval.verdict.verdict import check
from nightmap_site.checked_reading import read_object, using

MATCHED = {"num_scans": int, "num_scans_unclear": int, "odometry_sensor": str}
UNKNOWN_RAD = 1.0  # sigma of a heading of which nothing is known
HEADING = 2 * 6 + 2  # in a row of a covariance


def checks(site):
    estimate = read_tum(site.path("map_frame", "trajectory"))
    counts = scan_counts(scan_times_ns(site, estimate), estimate)
    mapped = 100 * counts["num_scans_with_pose"] / max(1, counts["num_scans"])
    yield check("scans mapped", mapped, "%", (95, 100), "scans with a pose",
                "only {value:.0f} % of the scans have a pose: look for gaps in their times and in the odometry", usable=(50, 100))  # fmt: skip
    yield from unclear_checks(site)
    yield from part_checks(site)
    yield from wheel_checks(site, estimate)
    walls = floors_walls(site)
    if walls.get("doubled_percent") is not None:
        yield check("doubled walls", walls["doubled_percent"], "%", (0, 8), "of the cells of walls: a second drawing beside a wall is a way "
                    "that did not meet itself again",
                    "{value:.0f} % of the walls are drawn twice: look at the loops, at the laser's pose on the robot, and at the scale of "
                    "the wheels", usable=(0, 25))  # fmt: skip
    if walls.get("thickness_mean_cells") is not None:
        yield check("thickness of walls", walls["thickness_mean_cells"], "cells", (0, 2.5), "a laser draws a wall one or two cells thick",
                    "walls are {value:.1f} cells thick: the scans of one place do not agree; check max_range_m and the times")  # fmt: skip


def unclear_checks(site):
    """Nothing of a way that another system made. Wheels tell what walls do not, where there are any."""
    report = site.made("odometry", "report")
    matched = read_object(report, MATCHED) if report else None
    if matched is None or matched["odometry_sensor"]:
        return
    unclear = 100 * matched["num_scans_unclear"] / max(1, matched["num_scans"])
    yield check("ways that nothing tells", unclear, "%", (0, 5), "of the scans: their walls tell the way in one direction only, as in a bare "
                "corridor, and there are no wheels",
                "in {value:.0f} % of the scans walls tell the way in one direction only, and there are no wheels: nobody can know how far "
                "the robot went there; record the odometry of wheels, or take a scanner that reaches the ends", usable=(0, 30))  # fmt: skip


def part_checks(site):
    """Nothing where another system made the way."""
    edges, loops = site.made("odometry", "edges"), site.made("pose_graph", "loops_csv")
    if not (edges and loops):
        return
    (covariances,) = read_hdf5(edges, "covariance")
    with using(edges):
        begins = 1 + np.flatnonzero(covariances[:, HEADING] > UNKNOWN_RAD**2)
    ends = [(row["frame_a"], row["frame_b"]) for row in read_loops(loops) if row["status"] == "accepted"]
    apart = parts_apart(begins, ends)
    yield check("parts of the way that no loop joins", apart, "", (0, 0), "after a pause the robot was elsewhere, where only a place that it "
                "saw before tells where",
                "{value:.0f} parts of the way lie where they were guessed to: drive through a place that both parts see, or make a map of each "
                "log", usable=(0, 0))  # fmt: skip


def parts_apart(begins, loops):
    """How many parts no chain of loops joins to the first. begins: the first keyscan of each part but the first."""
    parts = list(range(len(begins) + 1))
    for ends in loops:
        a, b = (parts[int(np.searchsorted(begins, end, side="right"))] for end in ends)
        parts = [min(a, b) if part in (a, b) else part for part in parts]
    return sum(part != parts[0] for part in parts)
