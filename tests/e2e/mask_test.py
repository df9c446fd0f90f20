# SPDX-License-Identifier: Apache-2.0
"""A camera that sees a part of its robot: make check says so and writes a mask, and a map with the mask is made without it."""
import json
import shutil
import unittest

import numpy as np
from PIL import Image

from workspace import CAMERA, RECORDING, SITE, Workspace, write_black

PLATE_ROWS = 44  # lowest of 240
CHECK = "parts of the robot in the picture"


def add_plate(recording):
    """A textured plate 0.4 m before the camera, in every picture."""
    width, height = CAMERA["width"], CAMERA["height"]
    plate = np.kron(np.random.default_rng(1).integers(30, 230, (PLATE_ROWS // 4, width // 5)), np.ones((4, 5)))
    for path in sorted(recording.glob("rgb/*.jpg")):
        picture = np.array(Image.open(path))
        picture[-PLATE_ROWS:] = plate[..., None]
        Image.fromarray(picture).save(path, quality=95)
    for path in sorted(recording.glob("depth/*.png")):
        depth = np.array(Image.open(path)).astype(np.uint16)
        depth[-PLATE_ROWS:] = 2000
        Image.fromarray(depth).save(path)
    return height - PLATE_ROWS


class MaskTest(unittest.TestCase):
    def setUp(self):
        self.work = Workspace.made(RECORDING).removed_after(self)
        self.mask = self.work.data() / "mask.png"

    def set_mask(self):
        site = self.work.folder / f"configs/sites/{SITE}.toml"
        site.write_text(site.read_text().replace("[[camera]]", '[[camera]]\nmask = "mask.png"'))

    def made(self, *arguments):
        return self.work.output(*arguments)

    def runs_of(self, name):
        cameras = json.loads(self.work.path(name).read_text())["cameras"]
        return cameras[0].get("mask_runs")

    def test_the_proposed_mask_takes_the_robot_out(self):
        first_row = add_plate(self.work.data())
        text = self.made("check")
        self.assertRegex(text, f"(look at this|do not use): {CHECK} 1[789]")
        self.assertIn("survey/mask_0.png", text)
        proposed = self.work.path("survey/mask_0.png")
        mask = np.array(Image.open(proposed))
        self.assertEqual(mask.shape, (CAMERA["height"], CAMERA["width"]))
        self.assertTrue((mask[first_row + 1:] == 255).mean() > 0.99 and (mask[:first_row - 6] == 0).all())

        shutil.copy(proposed, self.mask)
        self.set_mask()
        text = self.made("check", "map")
        self.assertNotIn(CHECK, text)
        self.assertFalse(proposed.exists())
        runs = self.runs_of("frames/cameras.json")
        self.assertEqual(sum(runs[1::2]), int((mask == 255).sum()))
        for name in ("adjust/cameras.json", "tiles/cameras.json"):
            self.assertEqual(self.runs_of(name), runs)

        before = self.work.runs()
        mask[:, :10] = 255
        Image.fromarray(mask).save(self.mask)
        self.assertEqual(self.work.make("-q", "map").returncode, 1)
        self.made("map")
        after = self.work.runs()
        self.assertTrue(all(after[stage] != before[stage] for stage in ("frames", "features", "point_cloud", "octree")))
        self.assertNotEqual(self.runs_of("tiles/cameras.json"), runs)

    def test_a_mask_that_is_none_stops_before_the_map(self):
        self.set_mask()
        self.assertIn("mask.png does not exist", self.work.output("map", code=2))
        write_black(self.mask, 32, 24)
        result = self.work.make("map")
        self.assertIn("Error 1", result.stdout)
        self.assertRegex(result.stdout, r'small.toml:\d+: mask = "mask.png": .*mask.png: 32 x 24 pixels, its camera has 320 x 240')
