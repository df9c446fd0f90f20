# SPDX-License-Identifier: Apache-2.0
"""Pictures larger than the working size of their camera: the map is as good, and what leaves the house has the size of the pictures."""
import json
import unittest

from accuracy import metrics_of
from workspace import SITE, Workspace

WORKING_MPX = 0.0607  # 284 x 213 of 320 x 240
MAX_ATE_M = 0.005  # half a pixel at 2.3 m


class WorkingSizeTest(unittest.TestCase):
    def test_the_map_is_as_good_and_names_the_pictures_as_stored(self):
        work = Workspace.made("map", "localize").removed_after(self)
        site = work.folder / f"configs/sites/{SITE}.toml"
        site.write_text(site.read_text().replace("[[camera]]", f"[[camera]]\nworking_mpx = {WORKING_MPX}"))
        work.output("map", "localize", "evaluate")
        metrics = metrics_of(work.path(""))
        [camera] = json.loads(work.path("frames/cameras.json").read_text())["cameras"]
        self.assertEqual([camera["color"]["width"], camera["color"]["height"], camera["picture_width"], camera["picture_height"]],
                         [284, 213, 320, 240])  # fmt: skip
        lines = work.path("landmarks/colmap/cameras.txt").read_text().splitlines()
        self.assertEqual(lines[-1].split()[2:4], ["320", "240"])
        self.assertLess(metrics["trajectory"]["se3"]["ate_rmse_m"], MAX_ATE_M)
        self.assertEqual(metrics["queries"]["num_located"], metrics["queries"]["num_queries"])
