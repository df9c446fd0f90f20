#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Depth as recorders write it beside 16-bit PNG: the map is that of the same depth in 16 bits."""
import re
import unittest

import numpy as np
from PIL import Image

from workspace import RECORDING, SITE, Workspace

UNITS_PER_M = 5000


def positions_m(work):
    return np.loadtxt(work.path("map_frame/trajectory.tum"))[:, :4]


class FloatDepthTest(unittest.TestCase):
    def setUp(self):
        self.work = Workspace.made(RECORDING)
        self.addCleanup(self.work.remove)
        self.work.as_recorded()
        self.site = self.work.folder / f"configs/sites/{SITE}.toml"
        for path in sorted(self.work.data().glob("depth/*.png")):
            raw = np.array(Image.open(path)).astype(np.float32)
            depth_m = np.where(raw > 0, raw / np.float32(UNITS_PER_M), np.nan).astype(np.float32)
            Image.fromarray(depth_m).save(path, format="TIFF")  # the name stays: the content says what it is

    def made(self, *arguments):
        result = self.work.make(*arguments)
        self.assertEqual(result.returncode, 0, result.stdout)
        return result.stdout

    def test_floats_in_metres_make_the_map_of_integers(self):
        text = self.site.read_text()
        self.site.write_text(re.sub(r"(?m)^depth_units_per_m = .*\n", "", text))
        self.assertIn("depth_units_per_m", text)
        self.made("check", "map")
        integers = Workspace.made("map")
        self.addCleanup(integers.remove)
        ours, theirs = positions_m(self.work), positions_m(integers)
        np.testing.assert_array_equal(ours[:, 0], theirs[:, 0])
        self.assertLess(np.linalg.norm(ours[:, 1:] - theirs[:, 1:], axis=1).max(), 0.002)

        path = sorted(self.work.data().glob("depth/*.png"))[0]
        path.write_bytes(path.read_bytes()[:-1000])
        text = self.made("frames", f"maps/{SITE}/features/shard_0000.h5")
        self.assertRegex(text, f"depth/{path.name}: .*copy it again")

    def test_integers_need_their_units_and_floats_a_right_one(self):
        self.site.write_text(re.sub(r"(?m)^depth_units_per_m = .*", "depth_units_per_m = 1000", self.site.read_text()))
        text = self.made("check")
        self.assertIn("do not use", text)
        self.assertIn("depth_units_per_m = 1000 right?", text)


if __name__ == "__main__":
    unittest.main()
