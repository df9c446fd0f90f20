# SPDX-License-Identifier: Apache-2.0
"""Errors by known relations between poses: exact by hand, and what a file of relations must not hold."""

import unittest

import numpy as np

from fake_site import moved, rotation_about
from folder_case import FolderTest
from laser_site import drive
from nightmap_eval.laser.laser_accuracy import Relations, euler_rotations, read_relations, relation_errors, relation_metrics
from nightmap_eval.trajectory import Trajectory, quaternion
from nightmap_site.script_errors import DataError


def poses(*x_y_yaw):
    """A pose a second."""
    quaternions = [quaternion(rotation_about([0, 0, 1], yaw)) for _, _, yaw in x_y_yaw]
    positions = np.array([[x, y, 0] for x, y, _ in x_y_yaw], dtype=float)
    return Trajectory(np.arange(len(x_y_yaw)) * 10**9, positions, np.array(quaternions))


def relations(*rows):
    """Rows: first and second time (s), x, y, yaw of first_from_second."""
    rows = np.array(rows, dtype=float)
    zeros = np.zeros(len(rows))
    return Relations((rows[:, :2] * 1e9).astype(np.int64), euler_rotations(zeros, zeros, rows[:, 4]),
                     np.column_stack([rows[:, 2:4], zeros]))  # fmt: skip


class ErrorTest(unittest.TestCase):
    def test_known_errors(self):
        # The robot looks along y at 0 s; seen from there, its pose at 1 s is 2 m ahead and 1 m to the left, turned by 90 degrees.
        estimate = poses((5, 5, np.pi / 2), (4, 7, np.pi))
        for x, y, yaw, translation_m, rotation_deg in (
            (2, 1, np.pi / 2, 0, 0),
            (2, 1.3, np.pi / 2, 0.3, 0),
            (2.3, 0.6, np.pi / 2, 0.5, 0),
            (2, 1, np.pi / 2 + 0.1, 0, np.degrees(0.1)),
            (2, 1, np.pi / 2 - 0.1, 0, np.degrees(0.1)),
            (2, 1, -3 * np.pi / 2, 0, 0),  # the same angle
        ):
            found_m, found_deg, num_missing = relation_errors(relations((0, 1, x, y, yaw)), estimate)
            self.assertAlmostEqual(found_m[0], translation_m)
            self.assertAlmostEqual(found_deg[0], rotation_deg, places=6)
            self.assertEqual(num_missing, 0)

    def test_a_relation_backwards_in_time(self):
        estimate = poses((5, 5, np.pi / 2), (4, 7, np.pi))
        found_m, found_deg, _ = relation_errors(relations((1, 0, -1, 2, -np.pi / 2)), estimate)
        self.assertAlmostEqual(found_m[0], 0)
        self.assertAlmostEqual(found_deg[0], 0, places=6)

    def test_the_frame_of_the_map_does_not_matter(self):
        estimate, some = drive(), relations((1, 9, 0.3, 0.2, 1.0), (3, 20, 1, 2, 3), (7, 7.5, 0, 0, 0))
        turned = moved(estimate, rotation_about([0, 0, 1], 2.2), np.array([7.0, -3, 0]))
        for one, other in zip(relation_errors(some, estimate)[:2], relation_errors(some, turned)[:2]):
            np.testing.assert_allclose(one, other, atol=1e-5)

    def test_mean_and_deviation_of_errors_and_squares(self):
        estimate = poses((0, 0, 0), (1, 0, 0), (2, 0, 0))
        figures = relation_metrics(relations((0, 1, 1.1, 0, 0), (1, 2, 1, 0.3, 0), (0, 2, 2, 0, 0.2)), estimate)
        self.assertEqual((figures["num_relations"], figures["num_missing"]), (3, 0))
        errors_m = np.array([0.1, 0.3, 0])
        self.assertAlmostEqual(figures["translation_mean_m"], 0.4 / 3)
        self.assertAlmostEqual(figures["translation_std_m"], np.sqrt(np.sum((errors_m - 0.4 / 3) ** 2) / 2))
        self.assertAlmostEqual(figures["translation_squared_mean_m2"], 0.1 / 3)
        self.assertAlmostEqual(figures["translation_squared_std_m2"], np.std(errors_m**2, ddof=1))
        self.assertAlmostEqual(figures["rotation_mean_deg"], np.degrees(0.2) / 3)
        self.assertAlmostEqual(figures["rotation_squared_mean_deg2"], np.degrees(0.2) ** 2 / 3)
        self.assertAlmostEqual(figures["translation_max_m"], 0.3)

    def test_relations_without_poses_are_missing(self):
        estimate = poses((0, 0, 0), (1, 0, 0), (2, 0, 0))
        # A second between poses is too far to say where the robot was at 0.5 s.
        some = relations((0, 1, 1.2, 0, 0), (0.5, 2, 0, 0, 0), (0, 7, 0, 0, 0))
        figures = relation_metrics(some, estimate)
        self.assertEqual((figures["num_relations"], figures["num_missing"]), (3, 2))
        self.assertAlmostEqual(figures["translation_mean_m"], 0.2)
        self.assertEqual(relation_metrics(some, estimate, max_gap_ns=10**9)["num_missing"], 1)
        alone = relation_metrics(relations((5, 6, 0, 0, 0)), estimate)
        self.assertEqual(alone, {"num_relations": 1, "num_missing": 1})

    def test_euler_angles_turn_about_x_then_y_then_z(self):
        random = np.random.default_rng(1)
        for roll, pitch, yaw in random.uniform(-3, 3, (20, 3)):
            expected = rotation_about([0, 0, 1], yaw) @ rotation_about([0, 1, 0], pitch) @ rotation_about([1, 0, 0], roll)
            np.testing.assert_allclose(euler_rotations([roll], [pitch], [yaw])[0], expected, atol=1e-12)


class FileTest(FolderTest):
    def read(self, text):
        path = self.write("relations.txt", text)
        return read_relations(path)

    def test_comments_and_empty_lines(self):
        found = self.read("# made by hand\n\n976052857.306123 976052890.5 1 2 0 0 0 0.5  # a corner\n   \n1 2 0 0 3 0 0 0\n")
        self.assertEqual(len(found), 2)
        np.testing.assert_array_equal(found.times_ns[0], [976052857306123000, 976052890500000000])
        np.testing.assert_allclose(found.translations_m, [[1, 2, 0], [0, 0, 3]])
        np.testing.assert_allclose(found.rotations[0], rotation_about([0, 0, 1], 0.5), atol=1e-12)

    def test_malformed_lines_are_named(self):
        good = "1 2 0 0 0 0 0 0\n"
        for line, reason in (("1 2 0 0 0 0 0", "7 columns"), ("1 2 0 0 0 0 0 0 0", "9 columns"), ("1 b 0 0 0 0 0 0", "not a number"),
                             ("1 2 0 0 0 0 0 x", "not a number"), ("1 2 nan 0 0 0 0 0", "NaN"), ("1 2 0 inf 0 0 0 0", "NaN or infinity"),
                             ("1 1e30 0 0 0 0 0 0", "out of range"), ("1 2 1e30 0 0 0 0 0", "out of range")):  # fmt: skip
            with self.subTest(line), self.assertRaisesRegex(DataError, rf"relations\.txt:3: .*{reason}.*; correct the relations"):
                self.read(f"# c\n{good}{line}\n{good}")

    def test_a_file_without_relations_is_refused(self):
        for text in ("", "# nothing\n"):
            with self.assertRaisesRegex(DataError, r"relations\.txt: no relation"):
                self.read(text)
