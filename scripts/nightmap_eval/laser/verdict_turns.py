# SPDX-License-Identifier: Apache-2.0
"""Checks of a scanner against wheels by the turns that both measure: the angles of the beams, and the clocks."""

import math

import numpy as np

from nightmap_eval.verdict.verdict import check

LIKELY = 0.25  # of a ratio of 1 or -1
CIRCLE = 0.9  # of a full circle: such beams span it
MAX_LAG_S = 0.15
MAX_PAIRS, MAX_DIRECTIONS = 1000, 360
MAX_SHIFT_RAD, MAX_TURN_RAD, MIN_TURN_RAD = 0.6, 0.4, 0.04
CUT_M = 0.5  # of the difference of two ranges
LAGS_S = np.arange(-1, 1.01, 0.02)
MIN_TURNS, MAX_SPREAD = 30, 0.2  # turns to judge by; their median deviation
CLEARLY = 0.5  # of the squared differences at no lag, that are left at the best one


def turn_checks(table, scans, odometry, what):
    """Without any where the robot turns too little to tell."""
    found = compare_turns(table, scans, odometry)
    if found is None:
        return
    ratio, lag_s = found
    yield check(f"turns of {scans.sensor_id} against {what}", ratio, "", (0.75, 1.33), "by how much each scan is the one before, turned, "
                "as a multiple of the wheels' turn: wheels err by some percent, and so does this figure where the robot drives as it turns",
                "where the wheels turn the robot by 1 deg, scans turn by {value:.2f}: " + _angles_advice(table, ratio),
                usable=(0.6, 1.6))  # fmt: skip
    yield check(f"clocks of {scans.sensor_id} and {what}", lag_s, "s", (-MAX_LAG_S, MAX_LAG_S), "by which the wheels turn later than the scans; "
                "a robot that turns by 40 deg in a second has turned by 6 until then",
                f"the times of the odometry are {{value:.2f}} s late: add {-lag_s:.2f} to the time_offset_s of its [[signal]]")  # fmt: skip


def _angles_advice(table, ratio):
    start_deg, step_deg = (math.degrees(angle) for angle in (table.angles_rad[0], np.median(np.diff(table.angles_rad))))
    if abs(ratio + 1) < LIKELY:
        return (f"the beams run the other way: write start_angle_deg = {-start_deg:.6g} and angle_step_deg = {-step_deg:.6g}, or, for a scanner "
                "that is upside down, its robot_from_sensor; or the heading of the wheels counts clockwise")  # fmt: skip
    if ratio < 0.1:
        return "is the heading of the wheels in rad, and are both of one drive and one clock?"
    true_deg = step_deg / ratio
    if len(table.angles_rad) * abs(true_deg) / 360 > CIRCLE:
        start_deg, true_deg = math.copysign(180, -step_deg), math.copysign(360 / len(table.angles_rad), step_deg)
    else:
        start_deg *= true_deg / step_deg
    return (f"the beams are {step_deg:.4g} deg apart in the config, and by the wheels {true_deg:.4g}: write start_angle_deg = {start_deg:.4g} and "
            f"angle_step_deg = {true_deg:.4g}, or correct the heading, or wheel_base_m, of the wheels")  # fmt: skip


def compare_turns(table, scans, odometry):
    """(ratio of the turns by scans to those of the wheels, seconds by which the odometry's times are late; 0 where no lag is clear). None
    where the robot turns too little, or scans and wheels have nothing to do with each other. `table` has scans of the log, all or some:
    those are compared that follow each other in the log."""
    first = np.flatnonzero(np.diff(table.scan_idxs) == 1)
    first = first[np.unique(np.linspace(0, len(first) - 1, min(MAX_PAIRS, len(first))).astype(int))] if len(first) else first
    scans_ns = scans.times_ns
    if len(first) < MIN_TURNS or len(odometry.times_ns) < 2:
        return None
    begins_s, ends_s = ((scans_ns[table.scan_idxs[first + k]] - scans_ns[0]) / 1e9 for k in (0, 1))
    odometry_s, headings = (odometry.times_ns - scans_ns[0]) / 1e9, np.unwrap(odometry.values[:, 2])

    def wheels(lag_s):
        return np.interp(ends_s + lag_s, odometry_s, headings) - np.interp(begins_s + lag_s, odometry_s, headings)

    by_scans = turns_rad(table, first) * (-1 if scans.is_upside_down else 1)
    left = [_left(by_scans, wheels(lag_s)) for lag_s in LAGS_S]
    lag_s = float(LAGS_S[int(np.argmin(left))]) if min(left) < CLEARLY * _left(by_scans, wheels(0)) else 0.0
    ratio = _ratio(by_scans, wheels(lag_s))
    return None if ratio is None else (ratio, lag_s)


def _ratio(by_scans, by_wheels):
    size = np.abs(by_wheels)
    turned = (size > MIN_TURN_RAD) & (size < MAX_TURN_RAD) & (np.abs(by_scans) < MAX_SHIFT_RAD)
    if np.count_nonzero(turned) < MIN_TURNS:
        return None
    ratios = by_scans[turned] / by_wheels[turned]
    ratio = float(np.median(ratios))
    return ratio if np.median(np.abs(ratios - ratio)) < MAX_SPREAD else None


def _left(by_scans, by_wheels):
    """The rest of the turns of the scans when a multiple of those of the wheels is taken away; robust against single wrong ones."""
    usable = np.abs(by_wheels) < MAX_TURN_RAD
    x, y = by_wheels[usable], by_scans[usable]
    slope = np.dot(x, y) / max(np.dot(x, x), 1e-12)
    return float(np.mean(np.minimum((y - slope * x) ** 2, MIN_TURN_RAD**2)))


def turns_rad(table, first):
    """From each of these rows to the next, counter-clockwise as the scanner counts."""
    stride = -(-len(table.angles_rad) // MAX_DIRECTIONS)
    ranges_m, angles_rad = table.ranges_m[:, ::stride], table.angles_rad[::stride]
    step_rad = angles_rad[1] - angles_rad[0] if len(angles_rad) > 1 else MAX_SHIFT_RAD
    most = min(int(MAX_SHIFT_RAD / abs(step_rad)), len(angles_rad) // 3)
    shifts = np.arange(-most, most + 1)
    costs = np.stack([_cost(ranges_m[first], ranges_m[first + 1], shift, table.is_circle) for shift in shifts.tolist()], axis=1)
    best = np.argmin(costs, axis=1)
    inner = np.clip(best, 1, max(1, len(shifts) - 2))
    if len(shifts) < 3:
        return np.zeros(len(first))
    before, at, after = (np.take_along_axis(costs, (inner + k)[:, None], axis=1)[:, 0] for k in (-1, 0, 1))
    curvature = np.maximum(before - 2 * at + after, 1e-9)
    part = np.where(inner == best, np.clip((before - after) / (2 * curvature), -0.5, 0.5), 0)
    return (shifts[best] + part) * step_rad


def _cost(before_m, after_m, shift, is_circle):
    """Mean difference when beam i looks where beam i + shift of the scan before did."""
    shifted = np.roll(before_m, -shift, axis=1)
    if not is_circle and shift:
        shifted[:, slice(-shift, None) if shift > 0 else slice(None, -shift)] = np.nan
    off = np.minimum(np.abs(shifted - after_m), CUT_M)
    known = ~np.isnan(off)
    return np.where(known, off, 0).sum(axis=1) / np.maximum(1, known.sum(axis=1))
