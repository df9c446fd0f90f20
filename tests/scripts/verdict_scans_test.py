# SPDX-License-Identifier: Apache-2.0
"""Checks of the log of a laser and of wheels: what each notices and proposes, and what leaves it quiet."""

import json
import re
import unittest

import h5py
import numpy as np

from folder_case import FolderTest
from nightmap_eval.laser import verdict_scans
from nightmap_eval.sealed_hdf5 import sealed
from nightmap_eval.signals import RangeTable, Samples, of_one_place, range_table, sectors_text
from nightmap_eval.verdict.verdict import GOOD, LOOK, NOT_KNOWN, REFUSE, worst
from nightmap_site.script_errors import DataError
from nightmap_site.site import Site

CIRCLE = np.radians(np.arange(-180, 180, 2))
NOT_MEASURED = -1
WITHOUT_BODY = {"robot_body": {"laser": {"share": 0, "largest_range_m": 0, "sectors_deg": [], "remedy": "", "is_left_out": False}}}


def drive(num=200):
    """Poses x y heading of a robot that drives and turns about a room, wheels along its heading."""
    phase = np.linspace(0, 4 * np.pi, num)
    x, y = 1.5 * np.cos(phase), 2.5 * np.sin(2 * phase) / 2
    return np.column_stack([x, y, np.unwrap(np.arctan2(np.gradient(y), np.gradient(x)))])


def ranges_m(poses, angles, half_m=(3.0, 4.0), noise_m=0.01):
    """In a room without furniture."""
    direction = poses[:, 2, None] + angles
    with np.errstate(divide="ignore"):
        walls = [(np.copysign(1, component) * half - poses[:, axis, None]) / component
                 for axis, (component, half) in enumerate(zip((np.cos(direction), np.sin(direction)), half_m))]  # fmt: skip
    return np.minimum(*walls) + noise_m * np.random.default_rng(1).normal(size=direction.shape)


class Log:
    """A log at 5 Hz; a test changes its parts."""

    def __init__(self, angles=CIRCLE, poses=None):
        self.angles, self.poses = angles, drive() if poses is None else poses
        self.times_s = 100 + np.arange(len(self.poses)) / 5
        self.ranges_m = ranges_m(self.poses, angles)
        self.odometry_s, self.odometry = self.times_s.copy(), self.poses.copy()
        self.report, self.mounting = dict(WITHOUT_BODY), [0, 0, 0, 0, 0, 0, 1]

    def beams(self, first_deg, last_deg):
        degrees = np.degrees(self.angles)
        return (degrees > first_deg - 1e-6) & (degrees < last_deg + 1e-6)

    def write(self, folder):
        (folder / "frames").mkdir(parents=True, exist_ok=True)
        (folder / "config").mkdir(exist_ok=True)
        (folder / "config/profile.toml").write_text('profile = "laser"\nimports = []\n')
        (folder / "frames/report.json").write_text(json.dumps(self.report))
        values = np.tile([self.angles[0], self.angles[1] - self.angles[0], 10.0], (len(self.times_s), 1))
        _write_signals(folder / "frames/scans.h5", "laser", self.times_s, values, self.ranges_m, self.mounting)
        _write_signals(folder / "frames/odometry.h5", "wheels", self.odometry_s, self.odometry, np.zeros((len(self.odometry), 0)), [0, 0, 0, 0, 0, 0, 1])


def _write_signals(path, sensor, times_s, values, ranges, mounting):
    with sealed(path) as file:
        file.attrs["sensor_0"] = sensor
        file["robot_from_sensor"] = np.array([mounting], float)
        file["sample_offset"] = np.array([[0], [len(times_s)]])
        file["time_ns"] = np.round(1e9 * times_s).astype(np.int64)[:, None]
        file["value"] = values
        file["range_offset"] = (np.arange(len(times_s) + 1) * ranges.shape[1])[:, None]
        file["range_m"] = ranges.astype(np.float32).reshape(-1, 1)


class LogTest(FolderTest):
    def checks(self, log):
        log.write(self.folder)
        return {item.name: item for item in verdict_scans.checks(Site(self.folder))}

    def not_good(self, log):
        """name -> (verdict, advice)."""
        return {name: (item.verdict, item.advice) for name, item in self.checks(log).items() if item.verdict != GOOD}

    def assert_named(self, log, name, verdict, advice):
        found = self.not_good(log)
        self.assertEqual([(name, verdict)], [(key, value[0]) for key, value in found.items()], found)
        self.assertRegex(found[name][1], advice)

    def test_a_good_log_is_good(self):
        self.assertEqual(len(self.checks(Log())), 14)
        for angles in (CIRCLE, CIRCLE[::-1], np.radians(np.arange(-90, 91)), np.radians(np.arange(-135, 135.1, 0.5))):
            self.assertEqual(self.not_good(Log(angles)), {}, len(angles))
        silent = Log()
        silent.ranges_m[np.random.default_rng(2).random(silent.ranges_m.shape) < 0.3] = 0
        silent.odometry, silent.odometry_s = silent.odometry[:0], silent.odometry_s[:0]
        self.assertEqual(self.not_good(silent), {})

    def test_the_robot_in_its_scans(self):
        log = Log()
        body = {"share": 0.25, "largest_range_m": 0.25, "sectors_deg": [135, 225], "remedy": "min_range_m = 0.30", "is_left_out": True}
        log.report = {"robot_body": {"laser": body}}
        self.assert_named(log, "the robot in its scans", NOT_KNOWN, r"25\.0 % .* up to 0\.25 m.* left out.* Write min_range_m = 0\.30 in the")
        self.assertEqual(worst(self.checks(log).values()), GOOD)
        body["is_left_out"] = False
        self.assert_named(log, "the robot in its scans", LOOK, r"25\.0 % .* write min_range_m = 0\.30 in the \[\[sensor\]\]")
        for body["is_left_out"] in (False, True):
            body["share"] = 0.95
            self.assertEqual(self.not_good(log)["the robot in its scans"][0], REFUSE)
        log.report = {}
        self.assert_named(log, "the robot in its scans", NOT_KNOWN, "too few scans differ")
        log.report = {"robot_body": {"laser": {"share": 0.25}}}
        with self.assertRaisesRegex(DataError, r"report\.json: damaged .*largest_range_m"):
            self.checks(log)

    def test_directions_without_a_return_and_scans_without_one(self):
        log = Log()
        log.ranges_m[:, log.beams(20, 100)] = 0
        self.assert_named(log, "beams of scans that never return", LOOK, r"blind_deg = \[19, 101\]")
        log.ranges_m[:, log.beams(20, 100)] = NOT_MEASURED
        self.assertEqual(self.not_good(log), {})
        log.ranges_m[:, :] = NOT_MEASURED
        self.assertEqual(self.not_good(log)["beams of scans"][0], REFUSE)
        hall = Log()
        hall.ranges_m[::2, 3:] = 10
        self.assert_named(hall, "scans with hardly a return", LOOK, "max_range_m")
        units = Log()
        units.ranges_m /= 100
        self.assertRegex(self.not_good(units)["ranges of scans"][1], "range_unit")

    def test_a_limit_that_was_found_is_said_and_harmless(self):
        log = Log()
        log.report |= {"range_of_no_hit_m": {"laser": 10}, "num_times_in_line_order": {"wheels": 3}}
        self.assert_named(log, "max_range_m of scans", NOT_KNOWN, r"write max_range_m = 10 in the \[\[sensor\]\]")
        self.assertEqual(worst(self.checks(log).values()), GOOD)

    def test_batches_and_few_samples(self):
        log = Log()
        log.times_s = 100 + np.floor((log.times_s - 100)) + 0.001 * np.arange(len(log.times_s))
        log.report |= {"num_times_in_line_order": {"laser": 17}}
        self.assert_named(log, "times of scans", LOOK, "80 % of the times .* 17 went back")
        few = Log(poses=drive()[:5])
        self.assertRegex(self.not_good(few)["number of scans"][1], "only 5: .*message")
        rare = Log()
        rare.times_s, rare.odometry_s = 40 * rare.times_s, 40 * rare.odometry_s
        self.assertEqual(self.not_good(rare)["rate of scans"][0], LOOK)

    def test_a_gap_counts_where_the_robot_went_elsewhere_and_nothing_says_how(self):
        log = Log()
        log.times_s[60:] += 15  # it stood
        log.odometry_s[60:] += 15
        self.assertEqual(self.not_good(log), {})
        kept = np.r_[:61, 81:200]
        log = Log()
        log.times_s, log.ranges_m = log.times_s[kept], log.ranges_m[kept]
        self.assertEqual(self.not_good(log), {})
        log.odometry_s, log.odometry = log.odometry_s[kept], log.odometry[kept]
        log.times_s[61:] += 8
        log.odometry_s[61:] += 8
        self.assert_named(log, "gaps between scans", LOOK, r"1 gaps of up to 12\.2 s")
        loops = Site(self.folder).path("pose_graph", "loops_csv")
        loops.parent.mkdir(exist_ok=True)
        loops.touch()
        self.assert_named(log, "gaps between scans", NOT_KNOWN, "1 parts of the way begin after gaps")

    def test_odometry_of_other_units_and_frames(self):
        degrees, clockwise, millimetres, reversing = Log(), Log(), Log(), Log()
        degrees.odometry[:, 2] = np.degrees(degrees.odometry[:, 2])
        self.assertRegex(self.not_good(degrees)["heading of odometry"][1], "in degrees: write it in rad")
        clockwise.odometry[:, 2] *= -1
        self.assertRegex(self.not_good(clockwise)["heading of odometry"][1], "clockwise: negate it")
        millimetres.odometry[:, :2] *= 1000
        self.assert_named(millimetres, "steps of odometry", REFUSE, "x and y in metres")
        reversing.odometry[:, 2] += np.pi
        self.assertEqual(self.not_good(reversing), {})
        sideways = Log()
        sideways.odometry[:, 2] = np.random.default_rng(4).uniform(0, 0.3, len(sideways.odometry)).cumsum()
        self.assertEqual(self.not_good(sideways), {})

    def test_beams_that_do_not_point_as_the_config_says(self):
        half, clockwise, wider = Log(), Log(), Log(np.radians(np.arange(-90, 90)))
        half.angles = np.radians(-90 + np.arange(180))
        self.assertRegex(self.not_good(half)["turns of laser against odometry"][1], r"write start_angle_deg = -180 and angle_step_deg = 2, or")
        clockwise.angles = clockwise.angles[::-1]
        self.assertRegex(self.not_good(clockwise)["turns of laser against odometry"][1], r"write start_angle_deg = -178 and angle_step_deg = 2, or")
        wider.angles = np.radians(np.arange(-45, 45, 0.5))
        self.assertRegex(self.not_good(wider)["turns of laser against odometry"][1], r"write start_angle_deg = -(89|9\d)\S* and angle_step_deg = (0\.99|1|1\.0)")

    def test_a_scanner_upside_down_turns_with_the_robot(self):
        log = Log(CIRCLE[::-1])
        log.angles = CIRCLE
        log.mounting = [0, 0, 0, 1, 0, 0, 0]
        self.assertEqual(self.not_good(log), {})

    def test_odometry_that_is_late(self):
        for lag_s in (-0.4, 0.3):
            log = Log()
            log.odometry_s += lag_s
            found = self.not_good(log)
            self.assertEqual({name: item[0] for name, item in found.items()}, {"clocks of laser and odometry": LOOK})
            late = float(re.search(r"add (\S+) to the time_offset_s", found["clocks of laser and odometry"][1])[1])
            self.assertAlmostEqual(late, -lag_s, delta=0.05)

    def test_odometry_of_another_time(self):
        far, apart, broken = Log(), Log(), Log()
        far.odometry_s -= 100
        self.assert_named(far, "scans with odometry", REFUSE, r"two clocks\. Where both .* time_offset_s = 100\.000 in the")
        apart.odometry_s = apart.odometry_s / 2 - 1000
        self.assert_named(apart, "scans with odometry", REFUSE, "their difference as time_offset_s")
        broken.odometry_s[100:] += 40
        self.assert_named(broken, "scans with odometry", LOOK, "look for gaps in its file")

    def test_a_damaged_file_is_named(self):
        Log().write(self.folder)
        with h5py.File(self.folder / "frames/scans.h5", "r+") as file:
            del file["range_offset"]
        with self.assertRaisesRegex(DataError, r"scans\.h5: .*range_offset"):
            list(verdict_scans.checks(Site(self.folder)))


class TableTest(unittest.TestCase):
    def test_scans_of_different_numbers_of_beams_share_directions(self):
        counts = [4, 5, 4]
        values = np.array([[-np.pi, 2 * np.pi / count, 10] for count in counts])
        table = range_table(Samples("laser", np.arange(3), values, [np.arange(1, count + 1, dtype=np.float32) for count in counts]), 10)
        self.assertIsInstance(table, RangeTable)
        self.assertTrue(table.is_circle)
        np.testing.assert_array_equal(table.ranges_m, [[1, 2, 3, 4], [1, 2, 3, 5], [1, 2, 3, 4]])

    def test_a_sector_is_named_within_one_turn(self):
        angles = np.radians(np.arange(0, 360, 2))
        table = RangeTable(np.ones((1, 180)), np.ones((1, 180), bool), angles, True, np.array([0]))
        self.assertEqual(sectors_text(table, (angles < 0.3) | (angles > 2 * np.pi - 0.3)), "-17, 17")
        self.assertEqual(sectors_text(table, np.isin(np.arange(180), [20, 21, 23, 50])), "39, 47, 99, 101")

    def test_a_place_is_the_same_at_any_heading(self):
        poses = np.array([[0.5, 0.3, 0.2], [0.6, 0.3, 2.2], [-1.5, -2.0, 0.2]])
        here, turned, elsewhere = ranges_m(poses, CIRCLE)
        self.assertTrue(of_one_place(here, turned))
        self.assertFalse(of_one_place(here, elsewhere))
