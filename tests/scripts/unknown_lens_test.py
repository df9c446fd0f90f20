# SPDX-License-Identifier: Apache-2.0
"""unknown_lens.py: what its cases leave of a camera, and the figures of a row."""

import unittest

import numpy as np
from PIL import Image

from folder_case import FolderTest

import unknown_lens as bench

COLOR = {"width": 640, "height": 480, "fx": 500.0, "fy": 501.0, "cx": 300.0, "cy": 230.0, "k1": 0.1, "k2": 0, "p1": 0, "p2": 0, "k3": 0}
CAMERA = {"camera_id": "color", "color": COLOR}


class CamerasTest(FolderTest):
    def test_a_calibrated_camera_stays(self):
        self.assertEqual(bench.as_known(CAMERA, bench.Case("", None)), CAMERA)

    def test_a_guess_is_off_and_knows_neither_axis_nor_distortion(self):
        camera = bench.as_known(CAMERA, bench.Case("", 0.15, 1.2))
        self.assertEqual(camera["focal_sigma_ratio"], 0.15)
        self.assertEqual([camera["color"][key] for key in ("fx", "fy", "cx", "cy", "k1")], [600, 600, 319.5, 239.5, 0])

    def test_a_usual_lens_has_its_field_of_view_on_the_longer_side(self):
        color = bench.as_known(CAMERA, bench.Case("", 0.35, None))["color"]
        self.assertAlmostEqual(np.degrees(2 * np.arctan(320 / color["fx"])), bench.USUAL_FOV_DEG)

    def test_a_crop_keeps_the_middle(self):
        data, cropped = self.folder / "data", self.folder / "cropped"
        data.mkdir()
        pixels = np.arange(200, dtype=np.uint8).reshape(10, 20)
        Image.fromarray(pixels).save(data / "a.png")
        bench.crop_pictures(["a.png"], data, cropped, 0.5)
        self.assertEqual(np.asarray(Image.open(cropped / "a.png")).tolist(), pixels[2:7, 5:15].tolist())
        color = bench.as_known(CAMERA, bench.Case("", 0.05, 1.0, 0.5))["color"]
        self.assertEqual((color["width"], color["height"], color["cx"]), (320, 240, 159.5))


class RowTest(unittest.TestCase):
    def test_what_is_not_located_is_not_recalled(self):
        metres, degrees = np.array([0.01, 0.02, 0.7]), np.array([0.1, 3.0, 0.1])
        cells = bench.row("case", metres, degrees, np.array([0.01, 0.01, 0.1]), 4, 5, 1)
        self.assertEqual(cells, ["case", "4", "75", "25", "2.0", "56.4", "1", "2.00", "6.00"])

    def test_no_picture_located(self):
        nothing = np.zeros(0)
        self.assertEqual(bench.row("case", nothing, nothing, nothing, 4, 5, 1)[:4], ["case", "4", "0", "0"])
