#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Figures of the masks of what moves, against pictures of the truth."""
import pathlib
import tempfile
import types
import unittest
from unittest import mock

import numpy as np
from PIL import Image

import fake_site  # noqa: F401  (it makes scripts/ importable)
from nightmap_eval import moving_accuracy
from nightmap_site.script_errors import DataError


class MovingAccuracyTest(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))

    def evaluate(self, *frames):
        """frames: (mask, truth) as rows of pixels; truth None: the frame has no picture of it."""
        rows = []
        for i, (mask, truth) in enumerate(frames):
            if truth is not None:
                Image.fromarray(np.array([truth], np.uint8)).save(self.folder / f"{i}.png")
            rows.append(({"moving_path": f"{i}.png" if truth is not None else ""}, np.array([mask], bool)))
        site = types.SimpleNamespace(data=self.folder)
        with mock.patch.object(moving_accuracy, "masked_frames", return_value=rows), \
             mock.patch.object(moving_accuracy, "mask_of", side_effect=lambda mask: mask):
            return moving_accuracy.evaluate(site)

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
        with self.assertRaisesRegex(DataError, r"0\.png: its size"):
            self.evaluate(([1, 0, 0], [1, 0]))


if __name__ == "__main__":
    unittest.main()
