# SPDX-License-Identifier: Apache-2.0
"""Finds what a laser scanner sees of its own robot: directions in which the range stays while everything else changes.

Scans count that differ from each other: from all that were chosen before, a fifth of the directions or more. So a robot that stands, or
drives along a corridor, whose walls stay at one distance, gives few of them; and one that turns, to which all walls move, gives many."""

import math
from dataclasses import dataclass

import numpy as np

CHANGED_M, MIN_CHANGED = 0.1, 0.2  # of a range; of the directions of two scans that differ
MAX_CHOSEN, MIN_CHOSEN, MAX_COMPARED = 200, 20, 360  # scans; scans; directions
SAME_M, MIN_SAME, MIN_HITS = 0.03, 0.8, 0.5  # of a range that stays; of the hits of a direction; of its scans
LARGEST_BODY_M = 3.0
MOVED_M, MAX_MOVED = 0.3, 0.5  # of a range; of the directions of two scans of about one place
MAX_HOLE_DEG = 2.0  # between directions of one sector
MARGIN_M, MARGIN_SIGMAS, STEP_M, MAX_MIN_RANGE_M = 0.03, 4, 0.05, 1.0
MAX_LOST = 1e-3  # of the other hits, that a min_range_m takes away


@dataclass(frozen=True)
class RobotBody:
    """share: of the directions. remedy: the lines to write; None where no direction shows the robot."""

    share: float
    largest_range_m: float
    remedy: str | None


def differs(ranges_m, others_m):
    """Whether a scan shows another place, or another heading, than each of the others (rows)."""
    both = ~np.isnan(ranges_m) & ~np.isnan(others_m)
    with np.errstate(invalid="ignore"):
        changed = both & (np.abs(others_m - ranges_m) > CHANGED_M)
    return changed.sum(axis=-1) > MIN_CHANGED * np.maximum(1, both.sum(axis=-1))


def of_one_place(ranges_m, other_m):
    """Whether two scans agree about, at one of the headings that the robot may have turned to."""
    shifts = np.arange(len(other_m))[:, None] + np.arange(len(other_m))
    turned_m = np.concatenate([other_m, other_m])[shifts[:: -(-len(other_m) // MAX_COMPARED)]]
    with np.errstate(invalid="ignore"):
        moved = np.count_nonzero(np.abs(turned_m - ranges_m) > MOVED_M, axis=1)
    both = np.count_nonzero(~np.isnan(turned_m) & ~np.isnan(ranges_m), axis=1)
    return bool((moved <= MAX_MOVED * both)[both >= len(other_m) // 4].any())


def different_scans(ranges_m):
    """Rows of scans that hit something and all differ from each other."""
    few_m, chosen = ranges_m[:, :: -(-ranges_m.shape[1] // MAX_COMPARED)], []
    for row in np.flatnonzero((~np.isnan(ranges_m)).any(axis=1)).tolist():
        if len(chosen) < MAX_CHOSEN and differs(few_m[row], few_m[chosen]).all():
            chosen.append(row)
    return chosen


def find_body(table):
    """None where too few scans differ to tell."""
    chosen = different_scans(table.ranges_m)
    if len(chosen) < MIN_CHOSEN:
        return None
    ranges_m = table.ranges_m[chosen]
    num_hits = np.count_nonzero(~np.isnan(ranges_m), axis=0)
    middle_m = np.full(ranges_m.shape[1], np.inf)
    middle_m[num_hits > 0] = np.nanmedian(ranges_m[:, num_hits > 0], axis=0)
    same = np.count_nonzero(np.abs(ranges_m - middle_m) <= SAME_M, axis=0)
    is_body = (num_hits >= MIN_HITS * len(chosen)) & (same >= MIN_SAME * num_hits) & (middle_m < LARGEST_BODY_M)
    if not is_body.any():
        return RobotBody(0.0, 0.0, None)
    largest_m = float(middle_m[is_body].max())
    sigma_m = 1.48 * float(np.nanmedian(np.abs(ranges_m - middle_m)[:, is_body]))
    farthest_m = largest_m + max(MARGIN_M, MARGIN_SIGMAS * sigma_m)
    return RobotBody(float(np.mean(is_body)), largest_m, _remedy(table, ranges_m[:, ~is_body], farthest_m, is_body))


def _remedy(table, others_m, farthest_m, is_body):
    """A least range, where nothing else is nearer; else the sectors."""
    min_range_m = STEP_M * math.ceil(round(farthest_m / STEP_M, 6))
    num_lost = np.count_nonzero(others_m < min_range_m)
    if min_range_m <= MAX_MIN_RANGE_M and num_lost <= MAX_LOST * max(1, np.count_nonzero(~np.isnan(others_m))):
        return f"min_range_m = {min_range_m:.2f}"
    return f"blind_deg = [{sectors_text(table, is_body)}]"


def sectors_text(table, is_inside):
    return ", ".join(f"{first:d}, {last:d}" for first, last in sectors_deg(table, is_inside))


def sectors_deg(table, is_inside):
    """(from, to), counter-clockwise, of the sectors that hold directions, with half a beam or more on each side."""
    order = np.argsort(table.angles_rad)
    angles_deg, inside = np.degrees(table.angles_rad[order]), is_inside[order]
    step_deg = abs(angles_deg[1] - angles_deg[0]) if len(angles_deg) > 1 else 1.0
    found = angles_deg[inside]
    starts = np.flatnonzero(np.diff(found, prepend=-np.inf) > step_deg + MAX_HOLE_DEG)
    sectors = [(part[0], part[-1]) for part in np.split(found, starts[1:])] if len(found) else []
    if table.is_circle and len(sectors) > 1 and sectors[0][0] + 360 - sectors[-1][1] <= step_deg + MAX_HOLE_DEG:
        sectors = [*sectors[1:-1], (sectors[-1][0], sectors[0][1] + 360)]
    return [(math.floor(round(first - step_deg / 2, 6)), math.ceil(round(last + step_deg / 2, 6))) for first, last in sectors]
