# SPDX-License-Identifier: Apache-2.0
"""max_depth_m bounds the map: the camera's motion is found with all depth that is measured."""
import re
import unittest

from workspace import SITE, Workspace


class DepthRangeTest(unittest.TestCase):
    def test_a_short_range_makes_a_smaller_map_of_the_same_motion(self):
        work = Workspace.made("map").removed_after(self)
        before, points = work.hashes(), work.path("point_cloud/cloud.ply")
        num_bytes = points.stat().st_size
        site = work.folder / f"configs/sites/{SITE}.toml"
        text = site.read_text()
        site.write_text(re.sub(r"(?m)^max_depth_m = .*", "max_depth_m = 1.8", text))
        self.assertNotEqual(site.read_text(), text)
        work.output("map")
        after = work.hashes()
        self.assertNotEqual(after["frames/cameras.json"], before["frames/cameras.json"])
        for name in ("features/shard_0000.h5", "adjust/trajectory.tum"):
            self.assertEqual(after[name], before[name], name)
        self.assertLess(points.stat().st_size, 0.8 * num_bytes)
