# SPDX-License-Identifier: Apache-2.0
"""Query errors after one alignment of the map, and after one around each query."""

import unittest

import numpy as np

from fake_site import moved, rotation_about, walk
from nightmap_eval.query_errors import MIN_LOCAL_FRAMES, global_errors, local_errors, near_frames, query_summary
from nightmap_eval.trajectory import Trajectory, quaternion
from nightmap_site.script_errors import DataError

TURN, SHIFT_M = rotation_about([1, 2, 3], 0.7), np.array([4.0, -5.0, 6.0])


def line(num_poses=41, step_m=0.5):
    """Along x without turning, 20 m."""
    positions = np.outer(np.arange(num_poses) * step_m, [1.0, 0, 0])
    return Trajectory(np.arange(num_poses), positions, np.tile([0.0, 0, 0, 1], (num_poses, 1)))


def bent(trajectory, radius_m=50.0):
    """Rolled onto a circle: rigid nearby, bent as a whole."""
    angles = trajectory.positions_m[:, 0] / radius_m
    positions = trajectory.positions_m.copy()
    positions[:, 0], positions[:, 1] = radius_m * np.sin(angles), radius_m * (1 - np.cos(angles))
    turned = [quaternion(rotation_about([0, 0, 1], angle)) for angle in angles]
    return Trajectory(trajectory.times_ns, positions, np.array(turned))


class QueryErrorsTest(unittest.TestCase):
    def check_both(self, *arguments, expected_m, expected_deg):
        for errors in (global_errors, local_errors):
            translation_m, rotation_deg = errors(*arguments)
            np.testing.assert_allclose(translation_m, expected_m, atol=1e-9)
            np.testing.assert_allclose(rotation_deg, expected_deg, atol=1e-6)

    def test_a_moved_map_with_its_queries_has_no_error(self):
        queries = walk(40).select(range(0, 40, 7))
        estimate, located = (moved(t, TURN, SHIFT_M) for t in (walk(), queries))
        self.check_both(located, queries, estimate, walk(), expected_m=0, expected_deg=0)

    def test_an_error_of_the_query_itself_shows_in_both(self):
        queries = walk(40).select([3, 30])
        located = moved(queries, TURN, SHIFT_M)
        located.positions_m[1] += TURN @ [0, 0.3, 0.4]
        located.quaternions[0] = quaternion(located.rotations()[0] @ rotation_about([0, 1, 0], np.radians(5)))
        estimate = moved(walk(), TURN, SHIFT_M)
        self.check_both(located, queries, estimate, walk(), expected_m=[0, 0.5], expected_deg=[5, 0])

    def test_the_bend_of_the_map_is_a_global_error_only(self):
        queries = line().select([0, 20, 40])
        arguments = (bent(queries), queries, bent(line()), line())
        global_m, global_deg = global_errors(*arguments)
        local_m, local_deg = local_errors(*arguments)
        self.assertGreater(global_m[[0, 2]].min(), 0.3)
        self.assertGreater(global_deg[[0, 2]].min(), 5)
        self.assertLess(local_m.max(), 0.03)
        self.assertLess(local_deg.max(), 1.5)

    def test_neighbours_on_a_line_do_not_leave_the_map_free_to_turn(self):
        queries = line().select([20])
        queries.positions_m[0, 1] = 1.0
        estimate, located = (moved(t, TURN, SHIFT_M) for t in (line(), queries))
        translation_m, rotation_deg = local_errors(located, queries, estimate, line())
        np.testing.assert_allclose([translation_m[0], rotation_deg[0]], 0, atol=1e-6)

    def test_near_frames_are_those_within_the_radius_or_the_nearest(self):
        np.testing.assert_array_equal(near_frames([10.0, 0, 0], line(), 1.0), [18, 19, 20, 21, 22])
        far = near_frames([-30.0, 0, 0], line(), 1.0)
        np.testing.assert_array_equal(far, range(MIN_LOCAL_FRAMES))

    def test_no_queries_and_no_map(self):
        none = walk().select([])
        for errors in (global_errors, local_errors):
            self.assertEqual([len(values) for values in errors(none, none, walk(), walk())], [0, 0])
            with self.assertRaises(DataError):
                errors(walk(), walk(), none, none)


class SummaryTest(unittest.TestCase):
    def test_wrong_places_and_p90(self):
        errors_m = [0.01] * 8 + [0.04, 0.6]
        summary = query_summary(np.array(errors_m), np.ones(10), 10)
        self.assertEqual(summary["num_wrong"], 1)
        self.assertAlmostEqual(summary["p90_translation_error_cm"], 4.0)
        self.assertIsNone(query_summary(np.array(errors_m), np.ones(10), 12)["p90_translation_error_cm"])
        self.assertEqual(summary["recall_1cm_1deg_percent"], 80)
        self.assertEqual(summary["recall_3cm_3deg_percent"], 80)
