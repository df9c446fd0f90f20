# SPDX-License-Identifier: Apache-2.0
"""Check of the parts of a laser's way, between which nothing is known of the motion: loops must join them."""

import numpy as np

from nightmap_eval.artifacts import read_hdf5
from nightmap_eval.loop_accuracy import read_loops
from nightmap_eval.verdict.verdict import check
from nightmap_site.checked_reading import using

UNKNOWN_RAD = 1.0  # sigma of a heading of which nothing is known
HEADING = 2 * 6 + 2  # in a row of a covariance


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
