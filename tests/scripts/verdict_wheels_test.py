# SPDX-License-Identifier: Apache-2.0
"""verdict_wheels: of a map's motion and that of the wheels, the check that fails, the cause it names and the values to write, which are
those of the scanner as it is."""

import math
import re

import numpy as np

import laser_site
from map_against_wheels_test import driven, steps
from nightmap_eval.laser.verdict_wheels import wheel_checks
from nightmap_eval.planar_poses import to_rows
from nightmap_eval.sealed_hdf5 import sealed
from nightmap_eval.verdict.verdict import GOOD, NOT_KNOWN, REFUSE
from nightmap_site.site import Site

TURNS, WAYS, DIRECTION = "turns on the map against the wheels", "ways on the map against the wheels", "direction of motion against the wheels"
NUMBER = r"(-?[0-9.]+)"


def wrapped(angle_deg):
    return math.remainder(angle_deg, 360)


def write_scanner(path, start_deg, step_deg, beams, yaw_deg):
    half_rad = math.radians(yaw_deg) / 2
    path.unlink()
    with sealed(path) as file:
        file["robot_from_sensor"] = [[0.1, 0, 0.2, 0, 0, math.sin(half_rad), math.cos(half_rad)]]
        file["value"] = [[*np.radians([start_deg, step_deg]), 10.0]] * 2
        file["range_offset"] = np.array([[0], [beams], [2 * beams]])


def write_wheels(path, wheels):
    with sealed(path) as file:
        file["robot_from_sensor"] = [[0.0, 0, 0, 0, 0, 0, 1]]
        file["sample_offset"] = np.array([[0], [len(wheels)]])
        file["time_ns"], file["value"] = wheels.times_ns[:, None], to_rows(wheels)


class VerdictWheelsTest(laser_site.LaserFolderTest):
    def setUp(self):
        super().setUp()
        laser_site.write_site(self.site_dir)

    def checks(self, on_map, by_wheels=None, start_deg=-180, step_deg=1, beams=360, yaw_deg=0):
        """Checks of a map and of wheels as (ways, turns), and of a scanner as the site config describes it."""
        write_scanner(self.site_dir / "frames/scans.h5", start_deg, step_deg, beams, yaw_deg)
        write_wheels(self.site_dir / "frames/odometry.h5", driven(*(by_wheels or steps())))
        found = {item.name: item for item in wheel_checks(Site(self.site_dir), driven(*on_map))}
        (self.site_dir / "frames/odometry.h5").unlink()
        return found

    def advice(self, found, failed):
        """Advice of the one check that is not good, but for those that refer to it."""
        self.assertEqual(found[failed].verdict, REFUSE)
        for name, item in found.items():
            if name != failed:
                self.assertTrue(item.verdict == GOOD or "see" in item.advice, item)
        return found[failed].advice

    def angles(self, advice):
        return tuple(float(re.search(f"{key} = {NUMBER}", advice)[1]) for key in ("start_angle_deg", "angle_step_deg"))

    def test_a_map_that_moves_as_the_wheels_is_good(self):
        found = self.checks(steps())
        self.assertEqual({name: item.verdict for name, item in found.items()}, dict.fromkeys((TURNS, WAYS, DIRECTION), GOOD))

    def test_without_wheels_nothing_is_said(self):
        self.assertEqual(list(wheel_checks(Site(self.site_dir), driven(*steps()))), [])

    def test_a_robot_that_hardly_moved_is_not_known(self):
        rest = (np.zeros(200, complex), np.zeros(200))
        self.assertEqual({name: item.verdict for name, item in self.checks(rest, rest).items()}, {TURNS: NOT_KNOWN, WAYS: NOT_KNOWN})

    def test_mirrored_beams_are_given_their_own_angles(self):
        ways, turns = steps()
        # As the scanner is: start, step, yaw; and the start of the config, whose step has the other sign.
        for start, step, yaw, said in ((180, -1, 0, -180), (0, -1, 0, -180), (0, 1, 0, 0), (135, -0.25, 0, -135), (90, -0.5, 90, -90),
                                       (-45, 0.25, 180, 45), (40, -0.5, -20, 0)):  # fmt: skip
            with self.subTest(start=start, step=step, yaw=yaw):
                ahead_rad = math.radians(2 * yaw + start + said)  # where the config has the beam that looks ahead
                self.assertAlmostEqual(math.remainder(ahead_rad, math.pi / 2), 0)
                found = self.checks((np.exp(1j * ahead_rad) * np.conj(ways), -turns), start_deg=said, step_deg=-step, yaw_deg=yaw)
                advice = self.advice(found, TURNS)
                self.assertIn("the other way", advice)
                self.assertIn("upside down", advice)
                found_start, found_step = self.angles(advice)
                self.assertAlmostEqual(wrapped(found_start - start), 0)
                self.assertAlmostEqual(found_step, step)

    def test_a_step_that_is_off_is_said_with_the_angles_of_the_same_middle(self):
        ways, turns = steps()
        # Values of the config and of the scanner: start, step; beams; measured errors of turns, as a factor.
        for start, step, beams, true_start, true_step, factor in (
                (-89.75, 0.5, 360, -180, 1, 0.98), (-90, 180 / 359, 360, -180, 1, 1.02), (-45, 0.25, 361, -90, 0.5, 1),
                (-179.5, 1, 360, -89.75, 0.5, 1), (-35, 0.5, 181, -80, 1, 1), (89, -1, 180, 180, -2, 1)):  # fmt: skip
            with self.subTest(start=start, step=step, beams=beams):
                ratio = factor * step / true_step
                advice = self.advice(self.checks((0.5 * ways, ratio * turns), start_deg=start, step_deg=step, beams=beams), TURNS)
                self.assertIn("the angle between beams is wrong", advice)
                self.assertIn("the scanner's maker", advice)
                found_start, found_step = self.angles(advice)
                self.assertAlmostEqual(found_step, true_step, places=2)
                is_circle = beams * abs(true_step) == 360  # which begins at a whole quarter
                self.assertAlmostEqual(wrapped(found_start - true_start), 0, places=7 if is_circle else 1)

    def test_a_scanner_that_is_turned_is_given_its_yaw(self):
        ways, turns = steps()
        cases = ((0, 180, "180 deg ", "180 deg", "0, 0, 1, 0"), (0, -180.3, "180 deg ", "180 deg", "0, 0, 1, 0"),
                 (0, 90.2, "90 deg to the right", "90 deg", "0, 0, 0.707107, 0.707107"),
                 (0, -89.8, "90 deg to the left", "-90 deg", "0, 0, -0.707107, 0.707107"),
                 (90, 180.1, "90 deg to the right", "180 deg", "0, 0, 1, 0"), (170, -130, "60 deg to the right", "-130 deg", ""))  # fmt: skip
        for said, true, words, yaw, numbers in cases:
            with self.subTest(said=said, true=true):
                turned = ways * np.exp(1j * math.radians(said - true))
                advice = self.advice(self.checks((turned, turns), yaw_deg=said), DIRECTION)
                self.assertIn(f"turned by {words}", advice)
                self.assertIn(f"robot_from_sensor of the scanner to a yaw of {yaw} (the last four numbers: {numbers}", advice)
                quaternion = [float(value) for value in re.search(r"numbers: ([^)]*)\)", advice)[1].split(", ")]
                self.assertAlmostEqual(np.linalg.norm(quaternion), 1, places=5)
                self.assertAlmostEqual(wrapped(2 * math.degrees(math.atan2(quaternion[2], quaternion[3])) - true), 0, delta=0.6)

    def test_wheels_whose_metres_are_off_are_scaled(self):
        ways, turns = steps()
        found = self.checks((ways, turns), (0.5 * ways, turns))
        advice = self.advice(found, WAYS)
        self.assertIn("2.00 times those of the wheels throughout: multiply the metres of the odometry by 2 (m_per_tick)", advice)
        found = self.checks((ways, turns), (ways / 0.8, turns))
        self.assertIn("multiply the metres of the odometry by 0.8 ", found[WAYS].advice)
        self.assertEqual((found[TURNS].verdict, found[DIRECTION].verdict), (GOOD, GOOD))

    def test_a_base_that_is_off_turns_on_ways_of_the_right_length(self):
        ways, turns = steps()
        found = self.checks((ways, turns), (ways, 0.5 * turns))
        self.assertIn("turns 2.00 times as far as the wheels, on ways of the right length: are wheel_base_m", self.advice(found, TURNS))

    def test_a_corridor_that_is_left_behind_is_no_scale(self):
        ways, turns = steps()
        behind = np.where(turns == 0, 0.1 * ways, ways)
        found = self.checks((behind, turns))
        advice = self.advice(found, WAYS)
        self.assertIn("in some places and right in others", advice)
        self.assertIn("bare corridors", advice)
        self.assertNotIn("multiply", advice)
