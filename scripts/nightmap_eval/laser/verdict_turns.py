# SPDX-License-Identifier: Apache-2.0
"""Checks of a scanner against wheels by the turns that both measure: the angles of the beams, and the clocks."""

import math

import numpy as np

from nightmap_eval.laser.scan_turns import compare_turns
from nightmap_eval.verdict.verdict import check

LIKELY = 0.25  # of a ratio of 1 or -1
CIRCLE = 0.9  # of a full circle: such beams span it
MAX_LAG_S = 0.15


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
