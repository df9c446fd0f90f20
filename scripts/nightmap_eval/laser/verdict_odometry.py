# SPDX-License-Identifier: Apache-2.0
"""Checks of the odometry of wheels: its steps, its heading, and its times against those of the scans."""

import numpy as np

from nightmap_eval.verdict.verdict import check

SAME_DURATION = 0.1  # of two logs that began together
MAX_GAP_S = 10  # scan_match.max_gap_s
# Speeds that no robot reaches, as in wheel_motion.cc.
MAX_SPEED_M_PER_S = MAX_SPEED_RAD_PER_S = 10
LATE_M, LATE_RAD = 0.5, 1.0
TO_ORIGIN_M, TO_ORIGIN_RAD = 0.1, 0.2
MIN_STEP_M, MIN_STEPS = 0.01, 50
ALONG, SURELY_ALONG = 0.5, 0.9  # mean resultant length


def covered(begin_ns, end_ns, odometry_ns):
    """Whether the odometry has no gap between two times."""
    first, last = np.searchsorted(odometry_ns, begin_ns, side="right") - 1, np.searchsorted(odometry_ns, end_ns)
    return bool(first >= 0 and last < len(odometry_ns) and (np.diff(odometry_ns[first : last + 1]) <= 1e9 * MAX_GAP_S).all())


def odometry_checks(odometry, what, scanners):
    if len(odometry.times_ns) < 2:
        return
    yield check(f"steps of {what}", 100 * float(np.mean(impossible_steps(odometry))), "%", (0, 1), f"are faster than {MAX_SPEED_M_PER_S} m/s "
                "or rad/s, which no robot makes; each counts as a gap",
                "{value:.1f} % of the steps are no motion of a robot: are x and y in metres and the heading in rad, and are columns and "
                "m_per_tick of the [[sensor]] and [[signal]] right?", usable=(0, 10))  # fmt: skip
    share, remedy = along_heading(odometry)
    yield check(f"heading of {what}", share, "", (ALONG if remedy else 0, 1), "wheels drive along their heading: the mean resultant length of "
                "twice the angle between the two", f"the robot drives in other directions than it heads, unless {remedy}", usable=(ALONG if remedy else 0, 1))  # fmt: skip
    for scans in scanners:
        yield check(f"scans with {what}", 100 * share_covered(scans.times_ns, odometry.times_ns), "%", (80, 100),
                    f"have samples of it around them, at most {MAX_GAP_S} s apart",
                    "only {value:.0f} % of the scans have odometry: " + _times_advice(scans.times_ns, odometry.times_ns),
                    usable=(5, 100))  # fmt: skip


def impossible_steps(odometry):
    steps_s = np.diff(odometry.times_ns) / 1e9
    moves_m = np.linalg.norm(np.diff(odometry.values[:, :2], axis=0), axis=1)
    turns_rad = np.abs(np.remainder(np.diff(odometry.values[:, 2]) + np.pi, 2 * np.pi) - np.pi)
    starts_again = (odometry.values[1:] == 0).all(axis=1) & ((moves_m > TO_ORIGIN_M) | (turns_rad > TO_ORIGIN_RAD))
    return starts_again | (moves_m > MAX_SPEED_M_PER_S * steps_s + LATE_M) | (turns_rad > MAX_SPEED_RAD_PER_S * steps_s + LATE_RAD)


def along_heading(odometry):
    """How much the robot moves along its heading, ahead or back (1: always), and what else it would: a remedy, where that is sure."""
    moves_m = np.diff(odometry.values[:, :2], axis=0)
    moved = np.linalg.norm(moves_m, axis=1) > MIN_STEP_M
    if np.count_nonzero(moved) < MIN_STEPS:
        return 1.0, None
    directions = np.arctan2(moves_m[moved, 1], moves_m[moved, 0])
    headings = (odometry.values[1:, 2] + odometry.values[:-1, 2])[moved] / 2

    def resultant(angles):
        return float(np.abs(np.mean(np.exp(2j * (directions - angles)))))

    others = {"its heading is in degrees: write it in rad": np.radians(headings), "its heading counts clockwise: negate it": -headings}
    share = resultant(headings)
    sure = [remedy for remedy, angles in others.items() if share < ALONG and resultant(angles) > SURELY_ALONG]
    return share, sure[0] if sure else None


def share_covered(scans_ns, odometry_ns):
    after = np.clip(np.searchsorted(odometry_ns, scans_ns), 1, len(odometry_ns) - 1)
    inside = (scans_ns >= odometry_ns[0]) & (scans_ns <= odometry_ns[-1])
    return float(np.mean(inside & (odometry_ns[after] - odometry_ns[after - 1] <= 1e9 * MAX_GAP_S)))


def _times_advice(scans_ns, odometry_ns):
    (first, last), (begin, end) = ((times_ns[0] / 1e9, times_ns[-1] / 1e9) for times_ns in (scans_ns, odometry_ns))
    if min(last, end) > max(first, begin):
        return "look for gaps in its file, and samples that were left out (make inspect)"
    apart = f"the scans are from {first:.0f} to {last:.0f} s and the odometry from {begin:.0f} to {end:.0f} s: two clocks. "
    if abs((last - first) - (end - begin)) <= SAME_DURATION * (last - first):
        return apart + f"Where both logs began together, write time_offset_s = {first - begin:.3f} in the [[signal]] of the odometry"
    return apart + "Write their difference as time_offset_s in the [[signal]] of the odometry"
