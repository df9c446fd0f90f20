# SPDX-License-Identifier: Apache-2.0
"""Trajectories, alignment and metrics."""

import unittest

import numpy as np

from fake_site import moved, rotation_about, walk, write_tum
from folder_case import FolderTest
from nightmap_eval.query_errors import query_summary, recall_percent
from nightmap_eval.trajectory import (
    Trajectory,
    angles_deg,
    associate,
    parse_time_ns,
    quaternion,
    read_tum,
    rotation_matrices,
    umeyama,
)
from nightmap_eval.trajectory_errors import (
    ate,
    distance_pairs,
    frame_pairs,
    relative_errors,
    rpe_per_frame,
    rpe_per_metre,
)
from nightmap_site.script_errors import DataError


def random_rotation(random):
    return rotation_about(random.normal(size=3), random.uniform(-np.pi, np.pi))


class RotationTest(unittest.TestCase):
    def test_quaternion_round_trip(self):
        random = np.random.default_rng(1)
        for _ in range(200):
            rotation = random_rotation(random)
            back = rotation_matrices(quaternion(rotation)[None])[0]
            np.testing.assert_allclose(back, rotation, atol=1e-12)

    def test_angle_of_known_rotation(self):
        for angle_deg in (0.0, 1e-6, 30.0, 179.9999):
            rotation = rotation_about([1, 2, 3], np.radians(angle_deg))
            self.assertAlmostEqual(angles_deg(rotation[None])[0], angle_deg, places=9)


class TumTest(FolderTest):
    def setUp(self):
        self.path = self.folder / "t.tum"

    def read(self, text):
        self.path.write_text(text)
        return read_tum(self.path)

    def test_time_is_exact_to_the_nanosecond(self):
        self.assertEqual(parse_time_ns("1305031102.175304001"), 1305031102175304001)
        self.assertEqual(parse_time_ns("0.3"), 300_000_000)
        self.assertEqual(parse_time_ns("-1.5"), -1_500_000_000)

    def test_write_read_equality(self):
        write_tum(self.path, walk())
        back = read_tum(self.path)
        np.testing.assert_array_equal(back.times_ns, walk().times_ns)
        np.testing.assert_allclose(back.positions_m, walk().positions_m, atol=1e-8)

    def test_sorts_by_time(self):
        back = self.read("2 2 0 0 0 0 0 1\n1 1 0 0 0 0 0 1\n")
        np.testing.assert_array_equal(back.positions_m[:, 0], [1, 2])

    def test_refuses_nan_with_file_and_line(self):
        with self.assertRaisesRegex(DataError, r"t\.tum:2: NaN"):
            self.read("# c\n1 nan 0 0 0 0 0 1\n")

    def test_refuses_wrong_columns_zero_quaternion_and_repeated_time(self):
        for text in ("1 2 3\n", "1 0 0 0 0 0 0 0\n", "1 0 0 0 0 0 0 1\n" * 2, "a 0 0 0 0 0 0 1\n"):
            with self.subTest(text), self.assertRaises(DataError):
                self.read(text)


class AssociateTest(unittest.TestCase):
    def test_nearest_within_gap_one_to_one(self):
        pairs = associate([10, 11, 52, 90], np.array([11, 50, 100]), 5)
        np.testing.assert_array_equal(pairs, [[1, 0], [2, 1]])

    def test_empty_lists(self):
        self.assertEqual(associate([1], np.array([], dtype=np.int64), 5).shape, (0, 2))
        self.assertEqual(associate([], np.array([1]), 5).shape, (0, 2))


class UmeyamaTest(unittest.TestCase):
    def test_recovers_known_similarity(self):
        random = np.random.default_rng(2)
        for _ in range(100):
            points = random.normal(size=(random.integers(4, 50), 3))
            rotation, shift = random_rotation(random), 10 * random.normal(size=3)
            scale = random.uniform(0.2, 5)
            found = umeyama(points, scale * points @ rotation.T + shift, with_scale=True)
            self.assertAlmostEqual(found.scale, scale, places=9)
            np.testing.assert_allclose(found.rotation, rotation, atol=1e-9)
            np.testing.assert_allclose(found.translation_m, shift, atol=1e-8)

    def test_planar_points_give_a_rotation_not_a_reflection(self):
        random = np.random.default_rng(3)
        for _ in range(50):
            points = random.normal(size=(20, 3)) * [1, 1, 0]
            rotation = random_rotation(random)
            found = umeyama(points, points @ rotation.T, with_scale=False)
            np.testing.assert_allclose(found.rotation, rotation, atol=1e-9)

    def test_is_a_minimum(self):
        random = np.random.default_rng(4)
        source, target = random.normal(size=(2, 30, 3))
        best = umeyama(source, target, with_scale=False)
        cost = np.sum((best.apply(source) - target) ** 2)
        for _ in range(50):
            turned = source @ (rotation_about(random.normal(size=3), 0.01) @ best.rotation).T
            self.assertGreaterEqual(np.sum((turned + best.translation_m - target) ** 2), cost)

    def test_refuses_nan_too_few_and_no_motion(self):
        points = np.random.default_rng(5).normal(size=(5, 3))
        bad = points.copy()
        bad[2, 1] = np.nan
        for source in (bad, points[:2], np.ones((5, 3))):
            with self.assertRaises(DataError):
                umeyama(source, points[: len(source)], with_scale=False)

    def test_says_when_points_lie_on_a_line(self):
        line = np.outer(np.arange(5.0), [1, 2, 3])
        self.assertFalse(umeyama(line, line, with_scale=False).is_unique)
        self.assertTrue(umeyama(np.eye(3), np.eye(3), with_scale=False).is_unique)


class AteTest(unittest.TestCase):
    def test_identical_is_zero(self):
        figures, _ = ate(walk(), walk(), with_scale=False)
        self.assertLess(figures["ate_max_m"], 1e-12)
        self.assertLess(figures["rotation_max_deg"], 1e-6)

    def test_moved_is_zero_after_alignment(self):
        estimate = moved(walk(), rotation_about([1, 1, 1], 2.0), np.array([5.0, 6.0, 7.0]))
        figures, _ = ate(estimate, walk(), with_scale=False)
        self.assertLess(figures["ate_max_m"], 1e-9)
        self.assertLess(figures["rotation_max_deg"], 1e-6)

    def test_scaled_is_zero_only_with_scale(self):
        true_walk = walk()
        estimate = Trajectory(true_walk.times_ns, true_walk.positions_m / 2, true_walk.quaternions)
        sim3, _ = ate(estimate, true_walk, with_scale=True)
        se3, _ = ate(estimate, true_walk, with_scale=False)
        self.assertAlmostEqual(sim3["scale"], 2.0, places=9)
        self.assertLess(sim3["ate_rmse_m"], 1e-9)
        self.assertGreater(se3["ate_rmse_m"], 0.3)

    def test_known_error(self):
        # Square with corners pushed outwards and inwards in turn by 0.1 m along z: no rigid
        # transform removes a saddle, so every error is 0.1 m.
        corners = np.array([[1.0, 1, 0], [-1, 1, 0], [-1, -1, 0], [1, -1, 0]])
        saddle = corners + [[0, 0, 0.1], [0, 0, -0.1], [0, 0, 0.1], [0, 0, -0.1]]
        still = np.tile([0.0, 0, 0, 1], (4, 1))
        times = np.arange(4)
        figures, _ = ate(Trajectory(times, saddle, still), Trajectory(times, corners, still), False)
        self.assertAlmostEqual(figures["ate_rmse_m"], 0.1, places=9)
        self.assertAlmostEqual(figures["ate_max_m"], 0.1, places=9)


def straight(step_m, num_poses=5):
    """Along x without turning."""
    positions = np.outer(np.arange(num_poses) * step_m, [1.0, 0, 0])
    return Trajectory(np.arange(num_poses), positions, np.tile([0.0, 0, 0, 1], (num_poses, 1)))


class RpeTest(unittest.TestCase):
    def test_hand_example(self):
        # Truth moves 1 m a frame, the estimate 1.1 m: 0.1 m a frame, and 0.1 m a metre.
        indices, one_sequence = np.arange(5), np.zeros(5, dtype=int)
        frame = rpe_per_frame(straight(1.1), straight(1.0), indices, one_sequence)
        self.assertEqual(frame["num_pairs"], 4)
        self.assertAlmostEqual(frame["translation_rmse_m"], 0.1)
        self.assertAlmostEqual(frame["rotation_rmse_deg"], 0.0)
        metre = rpe_per_metre(straight(1.1), straight(1.0), one_sequence)
        self.assertAlmostEqual(metre["translation_rmse_m_per_m"], 0.1)
        # Steps of 0.4 m: three steps are the first distance of a metre or more, with 0.12 m error.
        metre = rpe_per_metre(straight(0.44), straight(0.4), one_sequence)
        self.assertEqual(metre["num_pairs"], 2)
        self.assertAlmostEqual(metre["translation_rmse_m_per_m"], 0.1)

    def test_rotation_by_hand(self):
        turned = straight(1.0)
        turned.quaternions[3:] = quaternion(rotation_about([0, 0, 1], np.radians(10)))
        _, rotation_deg = relative_errors(turned, straight(1.0), [[1, 2], [2, 3], [3, 4]])
        np.testing.assert_allclose(rotation_deg, [0, 10, 0], atol=1e-9)

    def test_does_not_depend_on_the_frame_of_reference(self):
        estimate = moved(walk(), rotation_about([3, 1, 2], 1.0), np.array([9.0, 9, 9]))
        indices, sequences = np.arange(len(estimate)), np.zeros(len(estimate), dtype=int)
        figures = rpe_per_frame(estimate, walk(), indices, sequences)
        self.assertLess(figures["translation_rmse_m"], 1e-9)

    def test_pairs_skip_gaps_and_sequence_borders(self):
        pairs = frame_pairs(np.array([0, 1, 3, 4, 5]), np.array([0, 0, 0, 0, 1]))
        np.testing.assert_array_equal(pairs, [[0, 1], [2, 3]])

    def test_distance_pairs(self):
        pairs, lengths_m = distance_pairs(straight(0.4), np.zeros(5, dtype=int), 1.0)
        np.testing.assert_array_equal(pairs, [[0, 3], [1, 4]])
        np.testing.assert_allclose(lengths_m, 1.2)


class RecallTest(unittest.TestCase):
    def test_missing_poses_are_failures(self):
        self.assertEqual(recall_percent([0.01, 0.2], [1, 1], 4, 5, 5), 25.0)
        summary = query_summary(np.array([0.01, 0.02]), np.array([1.0, 1.0]), 8)
        self.assertEqual(summary["recall_5cm_5deg_percent"], 25.0)
        self.assertIsNone(summary["median_translation_error_cm"])
        self.assertAlmostEqual(summary["located_median_translation_error_cm"], 1.5)

    def test_both_thresholds_must_hold(self):
        self.assertEqual(recall_percent([0.01, 0.06, 0.04], [6, 1, 4], 3, 5, 5), 100 / 3)

    def test_no_queries_have_no_recall(self):
        summary = query_summary(np.zeros(0), np.zeros(0), 0)
        self.assertIsNone(summary["recall_5cm_5deg_percent"])
