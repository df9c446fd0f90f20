# SPDX-License-Identifier: Apache-2.0
"""Logs of laser scanners as people have them, made up: each map is right and good, or its verdict says what is wrong and what to do, or
reading it ends with the reason. The verdict's proposals make the map good."""
import re
import unittest
from typing import NamedTuple

from accuracy import metrics_of
from made_cases import MadeCases
from nightly import IS_NIGHT

NUMBER = r"-?[0-9.]+"


class Right(NamedTuple):
    max_ate_cm: float = 3


class Refused(NamedTuple):
    words: str  # of the message, a regular expression


class Named(NamedTuple):
    """A check that is not good, with words of its advice."""

    check: str
    word: str
    goals: tuple = ("check", "map")


TURNS, WAYS, DIRECTION = (f"{what} against the wheels" for what in ("turns on the map", "ways on the map", "direction of motion"))
CASES = {case: Right() for case in (
    "full", "full_nowheels", "half", "none_nan", "none_NaN", "none_zero", "none_minus", "none_neginf", "none_max", "none_max_default",
    "reversed", "upside_down", "backwards", "inclusive361", "hokuyo270", "sick181", "sick181_said", "varying", "rare_other_count", "yaw_wrap",
    "odo_reset", "odo_gap", "scan_gap", "backstamps", "ticks", "ticks_wrap", "deg_ccw_0", "crlf", "csv_spaces", "people", "revisit_moved",
    "pause_200")} | {  # fmt: skip
    "corridor": Right(10),
    "corr_20_8_10_0_5": Right(10),
    "short_max": Right(8),
    "short_max_default": Right(8),
    "corridor_nowheels": Named("ways that nothing tells", "nobody can know how far the robot went"),
    "reversed_wrong": Named(TURNS, "start_angle_deg = -180, angle_step_deg = -1"),
    "step_missing": Named(TURNS, "angle_step_deg = 1 and start_angle_deg = -180"),
    "backwards_wrong": Named(DIRECTION, "a yaw of 180 deg (the last four numbers: 0, 0, 1, 0)"),
    "half_backwards_wrong": Named(DIRECTION, "a yaw of 180 deg (the last four numbers: 0, 0, 1, 0)"),
    "body": Right(),
    "body_wide": Right(2),
    "clock_lag": Named("clocks of laser and odometry", "add -0.30 to the time_offset_s"),
    "clock_far": Refused("no moment .* time_offset_s = 1700000000"),
    "odo_mm": Refused('position_unit = "mm"'),
    "yaw_deg": Refused('heading_unit = "deg"'),
    "batch_ODOM": Named("times of scans", "stamp samples when they are measured"),
    "batch_none": Named("times of scans", "stamp samples when they are measured"),
    "intensities": Refused("more than a circle: .* intensities"),
    "mm": Refused('half of the ranges .* write range_unit = "mm"'),
    "mm_wrong": Refused('half of the ranges .* write range_unit = "mm"'),
}
# Nothing in these logs tells a building from its mirror image, or glass from a door.
LIMITS = ("reversed_wrong_nowheels", "glass")
BY_DAY = ("full", "corr_20_8_10_0_5", "step_missing", "backwards_wrong")
ANGLES = rf"start_angle_deg = {NUMBER}|angle_step_deg = {NUMBER}"
# The advice's proposal for a key of the site config, and how right the map is then: without robot_from_sensor's place, the way is
# that of the scanner, which is 20 cm behind.
PROPOSED = {
    "step_missing": (ANGLES, 3),
    "reversed_wrong": (ANGLES, 3),
    "backwards_wrong": (r"(?<=numbers: )[^)]*", 21),
    "clock_far": (rf"time_offset_s = {NUMBER}", 3),
    "odo_mm": ('position_unit = "mm"', 3),
    "yaw_deg": ('heading_unit = "deg"', 3),
}
# Where a key stands that is not of the scanner.
TABLES = {"time_offset_s": 'sensor = "wheels"', "position_unit": 'kind = "odometry"', "heading_unit": 'kind = "odometry"'}


class LaserCasesTest(MadeCases):
    tool = "laser_cases.py"

    def check_case(self, case):
        demanded = CASES[case]
        if isinstance(demanded, Refused):
            output = self.make(case, "map", code=2)
            self.assertRegex(output, demanded.words)
            self.assertNotIn("delete it", output)
        elif isinstance(demanded, Named):
            self.check_names_the_cause(self.made(case, *demanded.goals), demanded.check, demanded.word)
        else:
            self.check_is_right(case, demanded.max_ate_cm)

    def advice(self, demanded, case):
        if isinstance(demanded, Refused):
            return self.make(case, "map", code=2)
        return self.check_names_the_cause(self.made(case, *demanded.goals), demanded.check, demanded.word)

    def check_is_right(self, case, max_ate_cm):
        verdict = self.made(case, "check", "map", "evaluate")
        self.assertEqual(verdict["verdict"], "good", [item for item in verdict["checks"] if item["verdict"] != "good"])
        self.assertLessEqual(100 * metrics_of(self.folder / "maps" / case)["sections"]["grid"]["trajectory"]["se3"]["ate_rmse_m"], max_ate_cm)

    def write_keys(self, case, proposed):
        """Replaces keys of the site config, or adds them to their table."""
        text = self.site(case).read_text()
        for line in proposed:
            if line.startswith("0, 0"):
                line = f"robot_from_sensor = [0, 0, 0, {line}]"
            key = line.split(" = ")[0]
            table = TABLES.get(key, 'kind = "scan"')
            text = re.sub(rf"(?m)^{key} = .*\n", "", text).replace(table, f"{table}\n{line}")
        self.site(case).write_text(text)

    def test_by_day(self):
        for case in BY_DAY:
            with self.subTest(case):
                self.check_case(case)

    @unittest.skipUnless(IS_NIGHT, "takes a quarter of an hour: set NIGHTMAP_NIGHTLY=1")
    def test_all(self):
        for case in CASES:
            with self.subTest(case):
                self.check_case(case)

    def test_every_case_is_in_the_table(self):
        listed = self.write_case("list").partition("(")[0].split()
        self.assertEqual(set(listed) - {"list"}, CASES.keys() | set(LIMITS))

    @unittest.skipUnless(IS_NIGHT, "takes minutes: set NIGHTMAP_NIGHTLY=1")
    def test_what_the_verdict_proposes_makes_the_map_good(self):
        for case, (proposed, max_ate_cm) in PROPOSED.items():
            with self.subTest(case):
                advice = self.advice(CASES[case], case)
                self.write_keys(case, [found.rstrip(".") for found in re.findall(proposed, advice)])
                self.check_is_right(case, max_ate_cm)
