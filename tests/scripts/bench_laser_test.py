# SPDX-License-Identifier: Apache-2.0
"""bench_laser.py: the repeated log is that of a robot that drives the same round again and again."""

import h5py
import numpy as np


from folder_case import FolderTest  # first: it makes scripts and benchmarks importable

import bench_laser
from nightmap_eval.planar_poses import compose, inverse
from nightmap_eval.sealed_hdf5 import sealed
from nightmap_site.script_errors import DataError

SCANS_NS = np.array([5, 105, 205, 305], dtype=np.int64) * 10**6
WHEELS_NS = np.array([0, 50, 100, 150, 200, 250, 330], dtype=np.int64) * 10**6
BEAMS = (3, 2, 0, 4)  # of each scan
RANGES_M = np.arange(1, 10, dtype=np.float32)
LAP_NS = 330 * 10**6 + bench_laser.PAUSE_NS


def wheels():
    """Begins anywhere, and ends elsewhere."""
    phase = np.linspace(0, 2.5, len(WHEELS_NS))
    return np.stack([3 + np.cos(phase), -2 + 2 * phase, 0.7 + phase], axis=1)


def write_log(path, kind, times_ns, value, beams, ranges_m, num_sensors=1):
    with sealed(path) as file:
        file.attrs["format"] = "nightmap signals"
        file["kind"] = kind
        file["robot_from_sensor"] = np.array([[0.1, 0, 0.2, 0, 0, 0, 1.0]])
        file["sample_offset"] = np.linspace(0, len(times_ns), num_sensors + 1).astype(np.int64)[:, None]
        file["time_ns"], file["value"] = times_ns[:, None], value
        file["range_offset"] = np.cumsum([0, *beams]).astype(np.int64)[:, None]
        file["range_m"] = ranges_m[:, None]


def motions(poses):
    """From each pose to the next, seen from the former."""
    return compose(inverse(poses[:-1]), poses[1:])


class RepeatTest(FolderTest):
    def setUp(self):
        self.frames = self.folder / "frames"
        self.frames.mkdir()
        self.value = np.tile([-1.5, 0.5, 30.0], (4, 1)) + np.arange(4)[:, None]
        write_log(self.frames / "scans.h5", "scan", SCANS_NS, self.value, BEAMS, RANGES_M)
        write_log(self.frames / "odometry.h5", "odometry", WHEELS_NS, wheels(), [0] * 7, np.zeros(0, np.float32))

    def repeat(self, num_scans):
        bench_laser.repeat(self.frames, num_scans, self.folder)
        return h5py.File(self.folder / "scans.h5"), h5py.File(self.folder / "odometry.h5")

    def test_laps_follow_each_other_in_time(self):
        with self.repeat(11)[0] as scans, h5py.File(self.folder / "odometry.h5") as odometry:
            times_ns, wheels_ns = scans["time_ns"][:, 0], odometry["time_ns"][:, 0]
        self.assertEqual(len(times_ns), 11)
        self.assertEqual(len(wheels_ns), 3 * len(WHEELS_NS))
        for times in (times_ns, wheels_ns):
            self.assertTrue(np.all(np.diff(times) > 0))
        np.testing.assert_array_equal(times_ns[:4], SCANS_NS)
        np.testing.assert_array_equal(times_ns[8:], SCANS_NS[:3] + 2 * LAP_NS)
        np.testing.assert_array_equal(wheels_ns[7:14], WHEELS_NS + LAP_NS)

    def test_each_lap_has_the_ranges_and_angles_of_the_first(self):
        with self.repeat(10)[0] as scans:
            offsets, ranges_m, value = scans["range_offset"][:, 0], scans["range_m"][:, 0], scans["value"][:]
            np.testing.assert_array_equal(scans["sample_offset"][:, 0], [0, 10])
        self.assertEqual((offsets[0], offsets[-1], len(offsets)), (0, len(ranges_m), 11))
        first = np.cumsum([0, *BEAMS])
        for i in range(10):
            expected = RANGES_M[first[i % 4] : first[i % 4 + 1]]
            np.testing.assert_array_equal(ranges_m[offsets[i] : offsets[i + 1]], expected)
            np.testing.assert_array_equal(value[i], self.value[i % 4])

    def test_odometry_goes_on_where_it_ended(self):
        with self.repeat(12)[1] as odometry:
            poses = odometry["value"][:]
            self.assertEqual(len(odometry["range_m"]), 0)
        expected = motions(wheels())
        for lap in range(3):
            np.testing.assert_allclose(motions(poses[7 * lap : 7 * lap + 7]), expected, atol=1e-12)
        for lap in (1, 2):
            np.testing.assert_allclose(poses[7 * lap], poses[7 * lap - 1], atol=1e-12)
        self.assertGreater(poses[-1, 2], 7)  # turns are counted on

    def test_the_rest_of_the_file_stays(self):
        for file in self.repeat(5):
            with file:
                self.assertEqual(file.attrs["format"], "nightmap signals")
                np.testing.assert_array_equal(file["robot_from_sensor"][:], [[0.1, 0, 0.2, 0, 0, 0, 1]])
        with h5py.File(self.folder / "scans.h5") as scans, h5py.File(self.frames / "scans.h5") as original:
            self.assertEqual(set(scans), set(original))
            for name in original:
                self.assertEqual(scans[name].dtype, original[name].dtype, name)
                self.assertEqual(scans[name].ndim, original[name].ndim, name)

    def test_fewer_scans_than_a_lap_are_its_beginning(self):
        with self.repeat(2)[0] as scans:
            np.testing.assert_array_equal(scans["time_ns"][:, 0], SCANS_NS[:2])
            np.testing.assert_array_equal(scans["range_m"][:, 0], RANGES_M[:5])

    def test_a_log_of_two_sensors_is_refused(self):
        write_log(self.frames / "scans.h5", "scan", SCANS_NS, self.value, BEAMS, RANGES_M, num_sensors=2)
        with self.assertRaisesRegex(DataError, "scans.h5: the log of one sensor is repeated, this file has 2"):
            self.repeat(5)
