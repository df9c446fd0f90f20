# SPDX-License-Identifier: Apache-2.0
"""The profile moving on the small building: a board that is pasted into the recording and passes before the camera is masked
and seen by no later job; the evaluation compares with its truth; the report shows the masks."""
import csv
import json
import unittest

import h5py
import numpy as np
from labels_test import unpacked
from PIL import Image
from workspace import SITE, Workspace

BOARD_M = 0.8  # depth
UNITS_PER_M = 5000


class BoardTest(unittest.TestCase):
    """Others inherit from it. The small building in the profile moving, with a board that passes before the camera. keys: of its
    [[sequence]]; tables: at the end of its site config."""

    keys, tables = 'moving_folder = "moving"\n', ""

    @classmethod
    def record(cls):
        cls.work = Workspace.made("map").removed_after(cls)
        cls.work.as_recorded()
        site = cls.work.folder / f"configs/sites/{SITE}.toml"
        text = site.read_text().replace("root =", 'profile = "moving"\nroot =', 1)
        site.write_text(text.replace("[[sequence]]\n", f"[[sequence]]\n{cls.keys}") + cls.tables)
        cls.paste_board()

    @classmethod
    def make(cls, *goals):
        cls.work.output(*goals)

    @classmethod
    def paste_board(cls):
        """A board of a quarter of the picture's width that crosses it within 8 frames, again and again."""
        texture = np.random.default_rng(1).integers(0, 256, (60, 60, 3), np.uint8).repeat(8, 0).repeat(8, 1)
        for path in sorted(cls.work.path("frames").glob("shard_*.csv")):
            for row in csv.DictReader(path.read_text().splitlines()):
                color_path, depth_path = (cls.work.folder / "data" / row[f"{channel}_path"] for channel in ("color", "depth"))
                color, depth = np.array(Image.open(color_path)), np.array(Image.open(depth_path))
                height, width = depth.shape
                left = int(row["frame_idx"]) % 8 * width // 8
                board = np.s_[height // 4:, left:left + width // 4]
                truth = np.zeros(depth.shape, np.uint8)
                truth[board] = 255
                color[board] = texture[:truth[board].shape[0], :truth[board].shape[1]]
                depth[board] = BOARD_M * UNITS_PER_M
                Image.fromarray(color).save(color_path, quality=95)
                Image.fromarray(depth).save(depth_path)
                folder = color_path.parent.parent / "moving"
                folder.mkdir(exist_ok=True)
                Image.fromarray(truth).save(folder / f"{color_path.stem}.png")


class MovingTest(BoardTest):
    @classmethod
    def setUpClass(cls):
        cls.record()
        cls.make("map", "evaluate", "report")

    def test_the_board_is_masked_and_has_no_features(self):
        num_frames = num_on_board = 0
        for path in sorted(self.work.path("moving").glob("shard_*.csv")):
            rows = list(csv.DictReader(path.read_text().splitlines()))
            with h5py.File(self.work.path(f"moving/masks_{path.stem[6:]}.h5")) as masks, \
                 h5py.File(self.work.path(f"features/{path.stem}.h5")) as features:
                first, pixels = np.ravel(features["first_feature"]), np.rint(features["raw_keypoint_px"][:]).astype(int)
                for i, row in enumerate(rows):
                    self.assertTrue(row["mask_path"] and row["mask_hash"], row)
                    x, y = pixels[first[i]:first[i + 1]].T
                    num_on_board += unpacked(masks, i)[y, x].sum()
                    num_frames += 1
        self.assertGreater(num_frames, 10)
        self.assertEqual(num_on_board, 0)

    def test_the_evaluation_compares_with_the_truth(self):
        found = json.loads(self.work.path("evaluate/metrics.json").read_text())["sections"]["moving"]
        self.assertGreater(found["num_frames_with_motion"], 10)
        self.assertGreater(found["recall_percent"], 60, found)

    def test_the_report_shows_the_masks(self):
        self.assertIn("What moves", self.work.path("report/index.html").read_text())
