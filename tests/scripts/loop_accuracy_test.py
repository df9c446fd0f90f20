# SPDX-License-Identifier: Apache-2.0
"""Loop closures against a known path: there and back along a corridor, looking one way."""

import numpy as np

from folder_case import FolderTest
from nightmap_eval import loop_accuracy
from nightmap_eval.sealed_hdf5 import sealed
from nightmap_eval.trajectory import make_trajectory
from nightmap_site.script_errors import DataError

NUM_FRAMES = 41


def position_m(i):
    return np.array([0.25 * min(i, NUM_FRAMES - 1 - i), 0, 0])


TRUTH = make_trajectory([(i, position_m(i), (0, 0, 0, 1)) for i in range(NUM_FRAMES)], "truth")
FRAMES = np.arange(NUM_FRAMES)


def loop(a, b, status="accepted", error_m=0.0):
    row = {"frame_a": a, "frame_b": b, "status": status, "reason": "" if error_m == 0 else "why"}
    measured = np.eye(3), position_m(a) - position_m(b) + [error_m, 0, 0]
    return row, {(a, b): measured}


def metrics(*pairs):
    relative = {key: pose for _, poses in pairs for key, pose in poses.items()}
    return loop_accuracy.loop_metrics([row for row, _ in pairs], relative, FRAMES, TRUTH)


class LoopMetricsTest(FolderTest):
    def test_a_wrong_pose_is_a_false_loop_when_accepted(self):
        self.assertEqual(metrics(loop(5, 35), loop(6, 34))["num_false_accepted"], 0)
        self.assertEqual(metrics(loop(5, 35), loop(6, 34, error_m=1))["num_false_accepted"], 1)
        self.assertEqual(metrics(loop(6, 34, "rejected", 1))["num_false_accepted"], 0)

    def test_revisits_begin_where_the_way_back_is_long_enough(self):
        # 3 m of path lie between frame 20 - 6 and 20 + 6; within 0.5 m of it two frames earlier.
        figures = metrics()
        self.assertEqual(figures["num_revisiting_frames"], NUM_FRAMES - 26)
        self.assertEqual(figures["revisits_closed_percent"], 0)

    def test_a_revisit_is_closed_by_a_true_loop_nearby(self):
        self.assertEqual(metrics(loop(10, 30), loop(0, 40))["revisits_closed_percent"], 100)
        self.assertEqual(metrics(loop(10, 30, error_m=1))["revisits_closed_percent"], 0)
        partly = metrics(loop(0, 40))["revisits_closed_percent"]
        self.assertAlmostEqual(partly, 100 * 11 / 15)

    def test_revisits_are_those_of_all_pairs(self):
        rng = np.random.default_rng(2)
        turns_rad = rng.uniform(-0.4, 0.4, 300)
        truth = make_trajectory([(i, (*rng.uniform(0, 3, 2), 0), (0, 0, np.sin(turn / 2), np.cos(turn / 2)))
                                 for i, turn in enumerate(turns_rad)], "truth")  # fmt: skip
        path_m = np.r_[0, np.cumsum(np.linalg.norm(np.diff(truth.positions_m, axis=0), axis=1))]

        def sees_again(a, b):
            return (path_m[a] <= path_m[b] - loop_accuracy.REVISIT_PATH_M
                    and np.linalg.norm(truth.positions_m[a] - truth.positions_m[b]) < loop_accuracy.REVISIT_M
                    and abs(turns_rad[a] - turns_rad[b]) < np.radians(loop_accuracy.REVISIT_DEG))  # fmt: skip

        expected = [b for b in range(300) if any(sees_again(a, b) for a in range(b))]
        self.assertTrue(0 < len(expected) < 290)
        self.assertEqual(loop_accuracy.revisiting_frames(np.arange(300), truth), expected)

    def test_no_revisit_no_figure(self):
        half = FRAMES[:20]
        figures = loop_accuracy.loop_metrics([], {}, half, TRUTH.select(half))
        self.assertIsNone(figures["revisits_closed_percent"])

    def test_files_that_cannot_be_read_are_named(self):
        path = self.write("loops.h5", b"not HDF5")
        with self.assertRaisesRegex(DataError, "loops.h5"):
            loop_accuracy.read_relative_poses(path)
        with sealed(path) as file:
            file["frame"] = np.array([[3, 9]], dtype=np.int32)
            file["b_from_a"] = np.array([[1, 2, 3, 0, 0, 0, 1.0]])
        rotation, translation = loop_accuracy.read_relative_poses(path)[3, 9]
        np.testing.assert_array_equal(rotation, np.eye(3))
        np.testing.assert_array_equal(translation, [1, 2, 3])
        table = self.write("loops.csv", "frame_a,frame_b,status,reason\n1,x,accepted,\n")
        with self.assertRaisesRegex(DataError, "loops.csv:2"):
            loop_accuracy.read_loops(table)
