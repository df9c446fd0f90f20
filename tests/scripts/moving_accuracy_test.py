# SPDX-License-Identifier: Apache-2.0
"""Figures of the masks of what moves, against pictures of the truth."""
import types
from unittest import mock

import numpy as np
from PIL import Image

from folder_case import FolderTest
from nightmap_eval.labels import moving_accuracy, report_masks
from nightmap_site.script_errors import DataError


class MovingAccuracyTest(FolderTest):
    def evaluate(self, *frames, may_move=None):
        """frames: (mask, truth, labels) as rows of pixels; None, or no labels: the frame has no picture of it. may_move: flags of
        the network's classes, in the labels of shard 0007."""
        rows = []
        for i, (mask, *truths) in enumerate(frames):
            row = dict.fromkeys(("moving_path", "label_path"), "")
            for column, truth in zip(row, truths):
                if truth is not None:
                    row[column] = f"{i}_{column}.png"
                    Image.fromarray(np.array([truth], np.uint8)).save(self.folder / row[column])
            rows.append((row, self.folder / "masks_0007.h5", np.array([mask], bool)))
        network = {} if may_move is None else {("labels", "labels", "0007"): "labels_0007.h5"}
        site = types.SimpleNamespace(data=self.folder, made=lambda *key: network.get(key))
        with mock.patch.object(moving_accuracy, "masked_frames", return_value=rows), \
             mock.patch.object(moving_accuracy, "read_hdf5", return_value=[np.array([may_move])]), \
             mock.patch.object(moving_accuracy, "mask_of", side_effect=lambda path, mask: mask):
            return moving_accuracy.evaluate(site)

    def shares(self, *frames, may_move=None):
        found = self.evaluate(*frames, may_move=may_move)
        return found["masked_of_moving_percent"], found["masked_of_pausing_percent"]

    def test_pixels_are_counted_over_the_frames_with_motion(self):
        found = self.evaluate(([1, 1, 0, 0], [255, 0, 1, 0]), ([0, 1, 0, 0], [0, 9, 0, 0]), ([1, 0, 0, 0], [0, 0, 0, 0]), ([1, 1, 1, 1], None))
        self.assertEqual((found["num_frames_with_truth"], found["num_frames_with_motion"]), (3, 2))
        self.assertAlmostEqual(found["recall_percent"], 100 * 2 / 3)
        self.assertAlmostEqual(found["precision_percent"], 100 * 2 / 3)
        self.assertEqual(found["masked_without_motion_percent"], 25)

    def test_without_truth_there_is_no_figure(self):
        found = self.evaluate(([1, 0], None))
        self.assertEqual((found["num_frames_with_truth"], found["recall_percent"], found["masked_without_motion_percent"]), (0, None, None))

    def test_of_a_larger_picture_every_so_many_pixels_count(self):
        found = self.evaluate(([1, 0], [0, 9, 0, 0, 0, 9]))
        self.assertEqual((found["recall_percent"], found["precision_percent"]), (100, 100))

    def test_a_picture_of_another_size_is_named(self):
        with self.assertRaisesRegex(DataError, r"0_moving_path\.png: its size"):
            self.evaluate(([1, 0, 0], [1, 0]))

    # Classes of the labels: 1 a wall, 2 a person, 3 a dog.
    MOVES = ([1, 0, 0, 1, 1], [9, 9, 0, 0, 0], [2, 2, 2, 1, 0])  # a person of whom a pixel pauses, before a masked wall
    PAUSES = ([1, 0, 1, 0, 1], [0, 0, 0, 0, 0], [2, 2, 2, 255, 3])

    def test_who_pauses_is_told_from_who_moves_and_from_what_cannot(self):
        self.assertEqual(self.shares(self.MOVES, self.PAUSES, may_move=[0, 0, 1, 0]), (50, 50))
        self.assertEqual(self.shares(self.MOVES, self.PAUSES, may_move=[0, 0, 1, 1]), (50, 60))
        self.assertEqual(self.shares(self.MOVES, self.PAUSES, may_move=[0, 1, 0, 0]), (None, 100))

    def test_without_a_network_what_moves_at_any_time_may_move(self):
        self.assertEqual(self.shares(self.PAUSES, self.MOVES), (50, 50))
        self.assertEqual(self.shares(self.PAUSES), (None, None))

    def test_nothing_is_said_of_what_has_no_label(self):
        self.assertEqual(self.shares(([1, 1], [9, 0], [0, 255]), ([1, 1], [9, 0]), may_move=[1, 1]), (None, None))

    def test_labels_of_another_size_are_named(self):
        with self.assertRaisesRegex(DataError, r"0_label_path\.png: its size"):
            self.evaluate(([1, 0], [1, 0], [1]))

    def test_the_page_shows_them_where_there_are_labels(self):
        frame = ({"time_ns": "5"}, np.array([[True, False]]))
        for options, is_there in (((self.MOVES, self.PAUSES), True), ((self.MOVES[:2],), False)):
            metrics = {"sections": {"moving": self.evaluate(*options, may_move=[0, 0, 1])}}
            site = types.SimpleNamespace(data=None, has=lambda job: True, made=lambda *key: None)
            with mock.patch.object(report_masks, "masked_frames", return_value=[frame]), \
                 mock.patch.object(report_masks, "mask_of", side_effect=lambda mask: mask):
                page = str(report_masks.sections(site, metrics))
            self.assertIn("Precision", page)
            self.assertEqual("while it pauses (%)" in page, is_there)
