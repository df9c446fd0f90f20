# SPDX-License-Identifier: Apache-2.0
"""How the robot moves on the map, over the same two seconds, against how its wheels say that it moved.

Wheels err by percents. A wrong description of the scanner errs by far more, and each in its own way: mirrored beams turn the
map's robot the other way, a wrong angle between beams scales its turns, a scanner mounted backwards drives backwards, and a
corridor in which scans fit everywhere leaves it behind."""

from dataclasses import dataclass

import numpy as np

from nightmap_eval.planar_poses import compose, inverse, to_rows, wrapped_rad
from nightmap_eval.trajectory import associate
from nightmap_eval.wheel_poses import read_wheels

WINDOW_NS = 2_000_000_000
MAX_WINDOW_NS = 3_000_000_000  # where scans are missing
SAME_NS = 1_000
# Motion that tells something, and what no robot indoors does.
MIN_TURN_RAD, MIN_WAY_M = 0.1, 0.1
MAX_SPEED_M_PER_S, MAX_SPEED_RAD_PER_S = 5.0, 6.0
MIN_STEP_S = 0.1  # stamps err by less
MIN_WINDOWS = 5


@dataclass(frozen=True)
class Agreement:
    """Motion on the map over that of the wheels. None where the wheels moved too little to tell."""

    turn: float | None  # ratio of the turns
    way: float | None  # ratio of the ways, without sign
    direction_rad: float | None  # of the map's motion, seen from the wheels'; counter-clockwise
    way_spread: float | None  # between the windows' own ratios of ways: half the range that holds the middle two thirds


def agreement(site, estimate):
    """The Agreement of a map's poses with the wheels that the odometry stage used. None without wheels."""
    wheels = read_wheels(site, estimate.times_ns)
    if wheels is None:
        return None
    pairs = associate(estimate.times_ns, wheels.times_ns, SAME_NS)
    return agreement_of(estimate.select(pairs[:, 0]), wheels.select(pairs[:, 1]))


def agreement_of(estimate, wheels):
    """Agreement of two trajectories with a pose at each of the same times."""
    first, last = windows(wheels.times_ns)
    by_map, by_wheels = (_motions(to_rows(way), first, last) for way in (estimate, wheels))
    jumps = np.cumsum(_is_jump(wheels))
    possible = jumps[last] == jumps[first]
    turned = possible & (abs(by_wheels[1]) > MIN_TURN_RAD)
    moved = possible & (abs(by_wheels[0]) > MIN_WAY_M)
    turn, way = _slope(by_map[1][turned], by_wheels[1][turned]), _slope(by_map[0][moved], by_wheels[0][moved])
    ratios = abs(by_map[0][moved] / by_wheels[0][moved])
    return Agreement(
        turn=None if turn is None else float(turn.real),
        way=None if way is None else float(abs(way)),
        direction_rad=None if way is None else float(np.angle(way)),
        way_spread=None if way is None else float(np.subtract(*np.quantile(ratios, [5 / 6, 1 / 6])) / 2),
    )


def _is_jump(wheels):
    """Whether no robot comes to each pose from the one before. Counters that begin anew, and a robot that is carried, jump."""
    steps = compose(inverse(to_rows(wheels)[:-1]), to_rows(wheels)[1:])
    seconds = np.maximum(np.diff(wheels.times_ns) / 1e9, MIN_STEP_S)
    is_fast = np.hypot(steps[:, 0], steps[:, 1]) > MAX_SPEED_M_PER_S * seconds
    return np.concatenate([[False], is_fast | (abs(wrapped_rad(steps[:, 2])) > MAX_SPEED_RAD_PER_S * seconds)])


def windows(times_ns):
    """(first, last) indices of windows side by side."""
    first, last, at = [], [], 0
    while at < len(times_ns):
        end = int(np.searchsorted(times_ns, times_ns[at] + WINDOW_NS))
        if end == len(times_ns):
            break
        if times_ns[end] - times_ns[at] <= MAX_WINDOW_NS:
            first.append(at)
            last.append(end)
        at = end
    return np.array(first, dtype=int), np.array(last, dtype=int)


def _motions(rows, first, last):
    """(ways as complex numbers, ahead and to the left of the mean heading of the window; turns in rad)"""
    steps = np.zeros(len(rows))
    steps[1:] = wrapped_rad(np.diff(rows[:, 2]))
    turns = np.cumsum(steps)[last] - np.cumsum(steps)[first]
    ahead = compose(inverse(rows[first]), rows[last])
    return (ahead[:, 0] + 1j * ahead[:, 1]) * np.exp(-0.5j * turns), turns


def _slope(values, by):
    """Least squares through the origin."""
    return np.vdot(by, values) / np.vdot(by, by).real if len(by) >= MIN_WINDOWS else None
