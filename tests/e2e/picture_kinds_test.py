# SPDX-License-Identifier: Apache-2.0
"""Pictures as recorders write them: depth of floats, depth with its confidence, infrared of 10 bits. Each map is that of the usual kind."""
import re
import unittest

import numpy as np
from PIL import Image

from workspace import RECORDING, SITE, Workspace

UNITS_PER_M = 5000


def positions_m(work):
    return np.loadtxt(work.path("map_frame/trajectory.tum"))[:, :4]


class KindOfPictureTest(unittest.TestCase):
    def setUp(self):
        self.work = self.recording()

    def recording(self):
        work = Workspace.made(RECORDING).removed_after(self)
        work.as_recorded()
        return work

    def edit(self, work, pattern, by):
        site = work.folder / f"configs/sites/{SITE}.toml"
        before = site.read_text()
        site.write_text(re.sub(f"(?m){pattern}", by, before))
        self.assertNotEqual(site.read_text(), before)

    def made(self, work, *arguments):
        return work.output(*arguments)


class FloatDepthTest(KindOfPictureTest):
    def setUp(self):
        super().setUp()
        for path in sorted(self.work.data().glob("depth/*.png")):
            raw = np.array(Image.open(path)).astype(np.float32)
            depth_m = np.where(raw > 0, raw / np.float32(UNITS_PER_M), np.nan).astype(np.float32)
            Image.fromarray(depth_m).save(path, format="TIFF")  # the name stays: the content says what it is

    def test_floats_in_metres_make_the_map_of_integers(self):
        self.edit(self.work, r"^depth_units_per_m = .*\n", "")
        self.made(self.work, "check", "map")
        integers = Workspace.made("map").removed_after(self)
        ours, theirs = positions_m(self.work), positions_m(integers)
        np.testing.assert_array_equal(ours[:, 0], theirs[:, 0])
        self.assertLess(np.linalg.norm(ours[:, 1:] - theirs[:, 1:], axis=1).max(), 0.002)

        path = sorted(self.work.data().glob("depth/*.png"))[0]
        path.write_bytes(path.read_bytes()[:-1000])
        text = self.made(self.work, f"maps/{SITE}/features/shard_0000.h5")
        self.assertRegex(text, f"depth/{path.name}: .*copy it again")

    def test_a_stated_unit_holds(self):
        self.edit(self.work, "^depth_units_per_m = .*", "depth_units_per_m = 1000")
        text = self.made(self.work, "check")
        self.assertIn("do not use", text)
        self.assertIn("depth_units_per_m = 1000 right?", text)


class ConfidenceTest(KindOfPictureTest):
    def test_unsure_depth_is_not_measured(self):
        masked = self.recording()
        for work in (masked, self.work):
            (work.data() / "sure").mkdir()
            for path in sorted(work.data().glob("depth/*.png")):
                depth = np.array(Image.open(path)).astype(np.uint16)
                depth[:, :80] = 0 if work is masked else np.where(depth[:, :80] > 0, depth[:, :80] * 0.6, 0)
                Image.fromarray(depth).save(path)
                sure = np.full((depth.shape[0] // 2, depth.shape[1] // 2), 2, np.uint8)
                sure[:, :40] = 1
                Image.fromarray(sure).save(work.data() / "sure" / path.name)
        self.edit(self.work, r"^\[\[camera\]\]", "[[camera]]\nmin_confidence = 2")
        self.edit(self.work, r"^\[\[sequence\]\]", '[[sequence]]\nconfidence_folder = "sure"')
        for work in (masked, self.work):
            self.made(work, "map")
        ours, theirs = self.work.hashes(), masked.hashes()
        for name in ("features/shard_0000.h5", "map_frame/trajectory.tum", "point_cloud/cloud.ply", "octree/map.bt"):
            self.assertEqual(ours[name], theirs[name], name)


class InfraredTest(KindOfPictureTest):
    def test_ten_bits_are_as_bright_as_eight(self):
        of_8_bits = self.recording()
        for work in (of_8_bits, self.work):
            for path in sorted(work.data().glob("rgb/*.jpg")):  # the name stays: the content says what it is
                gray = np.array(Image.open(path).convert("L"))
                ten_bits = np.round(gray * (1023 / 255)).astype(np.uint16)
                Image.fromarray(gray if work is of_8_bits else ten_bits).save(path, format="PNG")
        features = "features/shard_0000.h5"
        self.made(of_8_bits, f"maps/{SITE}/{features}")
        self.assertRegex(self.made(self.work, "check"), r"dark frames 100(.|\n)*write their number as picture_bits in the \[\[camera\]\]")
        self.edit(self.work, r"^\[\[camera\]\]", "[[camera]]\npicture_bits = 10")
        self.assertNotIn("dark frames", self.made(self.work, "check", f"maps/{SITE}/{features}"))
        self.assertEqual(self.work.hashes()[features], of_8_bits.hashes()[features])
