# SPDX-License-Identifier: Apache-2.0
"""Checks of the log of a laser scanner and of wheels, before a map is made of it."""

import math

import numpy as np

from nightmap_eval.laser.verdict_odometry import covered, odometry_checks
from nightmap_eval.laser.verdict_times import gap_steps, time_checks
from nightmap_eval.laser.verdict_turns import turn_checks
from nightmap_eval.signals import of_one_place, range_table, read_sensors, sectors_text
from nightmap_eval.verdict.verdict import check, unknown
from nightmap_site.checked_reading import NUMBER, read_object, using

REPORT = {"?num_times_in_line_order": {}, "?range_of_no_hit_m": {}, "?robot_body": {}}
MAX_SCANS = 3000
HARDLY = 0.1  # of the beams of a scan
MAX_BODY = 90  # % of the directions: with more, the map is of nearly nothing


def checks(site):
    path = site.path("frames", "report")
    report = read_object(path, REPORT)
    scanners, odometries = (read_sensors(site.made("frames", kind)) for kind in ("scans", "odometry"))
    tables = {}
    for scans in scanners:
        what = "scans" if len(scanners) == 1 else f"scans of {scans.sensor_id}"
        table = tables[scans.sensor_id] = range_table(scans, MAX_SCANS)
        yield from time_checks(scans, what, report)
        yield _gaps_check(scans, what, odometries, bool(site.made("pose_graph", "loops_csv")))
        found_m = report.get("range_of_no_hit_m", {}).get(scans.sensor_id)
        if isinstance(found_m, NUMBER):
            yield unknown(f"max_range_m of {what}", "the range that the scanner writes where it hit nothing",
                          f"it is {found_m:g} by the scans, which holds for the map: write max_range_m = {found_m:g} in the [[sensor]]")  # fmt: skip
        yield from _return_checks(table, what)
        with using(path):
            body_check = _body_check(report.get("robot_body", {}).get(scans.sensor_id), what)
        yield body_check
    for odometry in odometries:
        what = "odometry" if len(odometries) == 1 else f"odometry of {odometry.sensor_id}"
        yield from time_checks(odometry, what, report)
        yield from odometry_checks(odometry, what, scanners)
        for scans in scanners:
            yield from turn_checks(tables[scans.sensor_id], scans, odometry, what)


def _gaps_check(scans, what, odometries, has_map):
    """Loops of a map that join what lies before and after a gap (verdict_parts.py) tell more."""

    lost = [step for step in gap_steps(scans.times_ns).tolist() if _moved(scans, step)
            and not any(covered(*scans.times_ns[step : step + 2], odometry.times_ns) for odometry in odometries)]  # fmt: skip
    if lost and has_map:
        return unknown(f"gaps between {what}", "after which the scans show another place", f"{len(lost)} parts of the way begin after gaps")
    longest_s = max(((scans.times_ns[step + 1] - scans.times_ns[step]) / 1e9 for step in lost), default=0)
    return check(f"gaps between {what}", len(lost), "", (0, 0), "of more than 3 s and five usual intervals, after which the scans show "
                 "another place; no odometry says how the robot came there",
                 f"{{value:.0f}} gaps of up to {longest_s:.1f} s: look for scans that were lost in recording or copying, or add the odometry "
                 "of the wheels")  # fmt: skip


def _moved(scans, step):
    before, after = (range_table(scans.only([scan]), 1) for scan in (step, step + 1))
    return before.ranges_m.shape != after.ranges_m.shape or not of_one_place(before.ranges_m[0], after.ranges_m[0])


def _return_checks(table, what):
    is_hit = ~np.isnan(table.ranges_m)
    num_measured = table.is_measured.sum(axis=1)
    known = num_measured > 0
    if not known.any():
        yield check(f"beams of {what}", 0.0, "%", (1, 100), "of the beams measure", "no beam is left: correct blind_deg and min_range_m of the "
                    "[[sensor]]", usable=(1, 100))  # fmt: skip
        return
    never = table.is_measured.any(axis=0) & ~is_hit.any(axis=0)
    yield check(f"beams of {what} that never return", 100 * float(np.mean(never)), "% of the directions", (0, 20), "everywhere in a building "
                "is a wall; a beam that never returns looks at the robot, or beyond the scanner's reach",
                "{value:.0f} % of the directions show nothing in any scan: is max_range_m too small? Where the robot is in the way, write "
                f"blind_deg = [{sectors_text(table, never)}] in the [[sensor]]")  # fmt: skip
    few = is_hit.sum(axis=1)[known] < HARDLY * num_measured[known]
    yield check(f"{what} with hardly a return", 100 * float(np.mean(few)), "%", (0, 20), f"less than {100 * HARDLY:.0f} % of the beams of "
                "such a scan hit something, and it says little of where the robot is",
                "{value:.0f} % of the scans hit nearly nothing: is max_range_m too small, or range_unit wrong? A scanner of short reach in a "
                "large hall needs the odometry of wheels", usable=(0, 80))  # fmt: skip
    if is_hit.any():
        yield check(f"ranges of {what}", float(np.nanmedian(table.ranges_m)), "m", (0.2, 40), "half of what a scanner hits in a building is "
                    "nearer than a large hall is wide, and farther than the robot is",
                    "half of the ranges are below {value:.3g} m: is range_unit of the [[sensor]] right?", usable=(0.02, 200))  # fmt: skip


def _body_check(body, what):
    """body: what `frames` reports of it; None where it cannot tell."""
    name, reason = f"the robot in its {what}", "a range that stays in scans that all differ is of the robot: the map would have walls all along its way"
    if body is None:
        return unknown(name, reason, "too few scans differ from each other: it hardly moved, or is nearly all that the scanner sees")
    share = 100 * body["share"]
    seen = f"{share:.1f} % of the directions show something that stays at one distance, up to {body['largest_range_m']:.2f} m, wherever the robot is"
    if body["is_left_out"] and share <= MAX_BODY:
        return unknown(name, reason, f"{seen}: its own body, which is left out of the map. Write {body['remedy']} in the [[sensor]], which holds for "
                       "scans to locate too")  # fmt: skip
    return check(name, share, "% of the directions", (-math.inf, 0), reason, f"{seen}: its own body, or a wall that it always followed. Where it is "
                 f"the robot, write {body['remedy']} in the [[sensor]]", usable=(-math.inf, MAX_BODY))  # fmt: skip
