# SPDX-License-Identifier: Apache-2.0
"""Checks of the log of a laser scanner and of wheels, before a map is made of it."""

import math

import numpy as np

from nightmap_eval.laser.verdict_turns import turn_checks
from nightmap_eval.signals import of_one_place, range_table, read_sensors, sectors_text
from nightmap_eval.verdict.verdict import check, unknown
from nightmap_site.checked_reading import NUMBER, read_object, using

REPORT = {"?num_times_in_line_order": {}, "?range_of_no_hit_m": {}, "?robot_body": {}}
MAX_SCANS = 3000
HARDLY = 0.1  # of the beams of a scan
MAX_BODY = 90  # % of the directions: with more, the map is of nearly nothing
GAP_INTERVALS, GAP_S = 5, 3.0
FAR_SHORTER = 0.1
FEW = 10  # samples
SAME_DURATION = 0.1  # of two logs that began together
MAX_GAP_S = 10  # scan_match.max_gap_s
# Speeds that no robot reaches, as in wheel_motion.cc.
MAX_SPEED_M_PER_S = MAX_SPEED_RAD_PER_S = 10
LATE_M, LATE_RAD = 0.5, 1.0
TO_ORIGIN_M, TO_ORIGIN_RAD = 0.1, 0.2
MIN_STEP_M, MIN_STEPS = 0.01, 50
ALONG, SURELY_ALONG = 0.5, 0.9  # mean resultant length


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
    """Loops of a map that join what lies before and after a gap (verdict_laser.py) tell more."""

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


def intervals_s(times_ns):
    return np.diff(times_ns) / 1e9


def usual_interval_s(times_ns):
    """The mean of the intervals that are no gaps: of batches it is still that of measuring."""
    steps_s = intervals_s(times_ns)
    return float(np.mean(steps_s[steps_s <= max(GAP_S, GAP_INTERVALS * np.quantile(steps_s, 0.75))]))


def gap_steps(times_ns):
    """Indices of the samples after which a gap begins."""
    if len(times_ns) < FEW:
        return np.zeros(0, int)
    return np.flatnonzero(intervals_s(times_ns) > max(GAP_S, GAP_INTERVALS * usual_interval_s(times_ns)))


def time_checks(samples, what, report):
    if len(samples.times_ns) < FEW:
        yield check(f"number of {what}", len(samples.times_ns), "", (FEW, math.inf), "a map needs more", "only {value:.0f}: is `file` of the "
                    "[[signal]] the whole log, and `message` right?")  # fmt: skip
        return
    usual_s = usual_interval_s(samples.times_ns)
    yield check(f"rate of {what}", 1 / usual_s, "Hz", (0.2, 1e4), "in 5 s a robot drives out of one room and into another",
                "{value:.2g} samples per second are few: record more, or drive slower")  # fmt: skip
    short = 100 * float(np.mean(intervals_s(samples.times_ns) < FAR_SHORTER * usual_s))
    counted = report.get("num_times_in_line_order", {}).get(samples.sensor_id, 0)
    num_right = counted if isinstance(counted, NUMBER) else 0
    yield check(f"times of {what}", short, "% of the steps", (0, 30), "are below a tenth of the usual step: such times are not of measuring, "
                "but of writing batches, or went back and were put right",
                f"{{value:.0f}} % of the times lie close after the one before, and {num_right} went back: stamp samples when they are measured, "
                "not when they are written")  # fmt: skip


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
