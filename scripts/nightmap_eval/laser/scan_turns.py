# SPDX-License-Identifier: Apache-2.0
"""How far a robot turned from scan to scan, by its scans alone and by its wheels: each scan is the one before, shifted by the turn."""

import numpy as np

MAX_PAIRS, MAX_DIRECTIONS = 1000, 360
MAX_SHIFT_RAD, MAX_TURN_RAD, MIN_TURN_RAD = 0.6, 0.4, 0.04
CUT_M = 0.5  # of the difference of two ranges
LAGS_S = np.arange(-1, 1.01, 0.02)
MIN_TURNS, MAX_SPREAD = 30, 0.2  # turns to judge by; their median deviation
CLEARLY = 0.5  # of the squared differences at no lag, that are left at the best one


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
