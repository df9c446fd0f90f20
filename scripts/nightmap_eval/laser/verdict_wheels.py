# SPDX-License-Identifier: Apache-2.0
"""Checks of the robot's motion on the map against its wheels, with the cause that its kind of error has.

Wheels err by percents. A wrong description of the scanner errs by far more, and each in its own way: mirrored beams turn the
map's robot the other way, a wrong angle between beams scales its turns, a scanner mounted backwards drives backwards, and a
corridor in which scans fit everywhere leaves it behind.
"""

import math
from dataclasses import dataclass

import numpy as np

from nightmap_eval.artifacts import read_hdf5
from nightmap_eval.planar_poses import compose, inverse, read_wheels, to_rows, wrapped_rad
from nightmap_eval.trajectory import associate
from nightmap_eval.verdict.verdict import check, unknown
from nightmap_site.checked_reading import using

GOOD, USABLE = (0.85, 1.15), (0.6, 1.6)  # ratios; nine real logs are within 0.91 to 1.04
GOOD_DEG, USABLE_DEG = (-15, 15), (-45, 45)
STEADY = 0.15  # spread of the ratios of a way whose scale is off throughout
WINDOW_NS = 2_000_000_000
MAX_WINDOW_NS = 3_000_000_000  # where scans are missing
SAME_NS = 1_000
# Motion that tells something, and what no robot indoors does.
MIN_TURN_RAD, MIN_WAY_M = 0.1, 0.1
MAX_SPEED_M_PER_S, MAX_SPEED_RAD_PER_S = 5.0, 6.0
MIN_STEP_S = 0.1  # stamps err by less
MIN_WINDOWS = 5


def wheel_checks(site, estimate):
    """Nothing without wheels."""
    found = agreement(site, estimate)
    if found is None:
        return
    turns, ways = "turns on the map against the wheels", "ways on the map against the wheels"
    reason = "of the map over those of the wheels, over 2 s: wheels err by some percent"
    if found.turn is None:
        yield unknown(turns, reason, "the robot hardly turned")
    else:
        yield check(turns, found.turn, "times", GOOD, reason, turn_advice(site, found), usable=USABLE)
    if found.way is None:
        yield unknown(ways, reason, "the robot hardly moved")
        return
    yield check(ways, found.way, "times", GOOD, reason, way_advice(found), usable=USABLE)
    yield check("direction of motion against the wheels", math.degrees(found.direction_rad), "deg", GOOD_DEG,
                "of the map's robot, from that of the wheels: it shows how the scanner is mounted", direction_advice(site, found),
                usable=USABLE_DEG)  # fmt: skip


def turn_advice(site, found):
    if found.turn < 0:
        return f"the map turns the other way than the wheels: the beams run the other way round: write {_mirrored(site, found)}"
    if found.way is not None and GOOD[0] < found.way < GOOD[1]:
        return ("the map turns {value:.2f} times as far as the wheels, on ways of the right length: are wheel_base_m and the unit of the "
                "heading right?")  # fmt: skip
    return f"the map turns {{value:.2f}} times as far as the wheels: the angle between beams is wrong: write {_scaled(site, found.turn)}"


def way_advice(found):
    if found.turn is not None and not GOOD[0] < found.turn < GOOD[1]:
        return "the map's ways are {value:.2f} times those of the wheels, and its turns are off too: see there"
    if found.way_spread < STEADY:
        return ("the map's ways are {value:.2f} times those of the wheels throughout: multiply the metres of the odometry by {value:.3g} "
                "(m_per_tick), unless the ranges of the scanner have another unit")  # fmt: skip
    return ("the map's ways are {value:.2f} times those of the wheels in some places and right in others: the scans do not tell the way "
            "there (bare corridors, the robot's own body in view), or the wheels slip")  # fmt: skip


def direction_advice(site, found):
    if found.turn is not None and found.turn < 0:
        return "see the turns: the beams run the other way round"
    turned_deg = math.degrees(found.direction_rad)
    yaw_deg = 180 - (180 - round(_scanner(site)["yaw_deg"] - turned_deg)) % 360
    half_rad = math.radians(yaw_deg) / 2
    quaternion = ", ".join(f"{round(value, 6):g}" for value in (0, 0, math.sin(half_rad), math.cos(half_rad)))
    side = "" if abs(round(turned_deg)) == 180 else " to the left" if turned_deg > 0 else " to the right"
    return (f"the map's robot moves turned by {abs(turned_deg):.0f} deg{side} against its wheels: the scanner is mounted turned; turn "
            f"robot_from_sensor of the scanner to a yaw of {yaw_deg} deg (the last four numbers: {quaternion})")  # fmt: skip


def _mirrored(site, found):
    scanner = _scanner(site)
    forward_deg = 0.0 if found.direction_rad is None else math.degrees(found.direction_rad)
    forward_deg = 90 * round(forward_deg / 90)  # a scanner is mounted along the robot or across it
    start = wrapped_deg(forward_deg - 2 * scanner["yaw_deg"] - scanner["start_deg"])
    return f"start_angle_deg = {start:.6g}, angle_step_deg = {-scanner['step_deg']:.6g}, unless the scanner hangs upside down (robot_from_sensor)"


def _scaled(site, ratio):
    """Angles whose beams are 1 / ratio as far apart, about the same middle; the full circle where they come near it."""
    scanner = _scanner(site)
    beams, step = scanner["beams"], scanner["step_deg"] / ratio
    is_circle = abs(abs(step) * beams / 360 - 1) < 0.06
    if is_circle:
        step = math.copysign(360 / beams, step)
    start = scanner["start_deg"] + (scanner["step_deg"] - step) * (beams - 1) / 2
    quarter = 90 * round(start / 90)  # a circle begins ahead, behind or to a side
    if is_circle and abs(start - quarter) <= abs(step):
        start = quarter
    return f"angle_step_deg = {step:.4g} and start_angle_deg = {wrapped_deg(start):.4g}, or as the scanner's maker says"


def _scanner(site):
    """The site's words on the scanner that the first scan is of: angles of its first beam and between beams, its yaw, in degrees."""
    path = site.path("frames", "scans")
    mountings, values, offsets = read_hdf5(path, "robot_from_sensor", "value", "range_offset")
    with using(path):
        (start, step), (qx, qy, qz, qw) = np.degrees(values[0, :2]), mountings[0, 3:]
        beams = int(np.ravel(offsets)[1] - np.ravel(offsets)[0])
    return {"start_deg": start, "step_deg": step, "beams": beams,
            "yaw_deg": math.degrees(math.atan2(2 * (qw * qz + qx * qy), 1 - 2 * (qy * qy + qz * qz)))}  # fmt: skip


def wrapped_deg(angle_deg):
    return (angle_deg + 180) % 360 - 180


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
