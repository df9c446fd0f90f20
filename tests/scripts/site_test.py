# SPDX-License-Identifier: Apache-2.0
"""Where the files of a site are, by the pipeline that its last make used."""
import pathlib
import tempfile
import unittest

import fake_site  # noqa: F401  (finds the scripts)
from nightmap_site.pipeline import PROFILE_FILE, profile_text
from nightmap_site.script_errors import DataError
from nightmap_site.site import Site


class SiteTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name) / "office"
        self.folder.mkdir()

    def test_outputs_are_where_the_pipeline_declares_them(self):
        site = Site(self.folder)
        self.assertEqual(site.path("join_clouds", "cloud"), self.folder / "point_cloud/cloud.ply")
        self.assertEqual(site.path("frames", "shard", "0001"), self.folder / "frames/shard_0001.csv")
        self.assertIsNone(site.path("nobody", "cloud"))
        self.assertIsNone(site.path("join_clouds", "nothing"))

    def test_a_missing_file_was_not_made(self):
        site, path = Site(self.folder), self.folder / "odometry/shard_0000.h5"
        self.assertIsNone(site.made("odometry", "odometry", "0000"))
        path.parent.mkdir()
        path.touch()
        self.assertEqual(site.made("odometry", "odometry", "0000"), path)

    def test_what_the_profile_lacks_is_told(self):
        (self.folder / PROFILE_FILE).parent.mkdir()
        (self.folder / PROFILE_FILE).write_text(profile_text("imported", ["trajectory"]))
        site = Site(self.folder)
        self.assertEqual(site.needed("pose_graph", "keyframes"), self.folder / "pose_graph/keyframes.tum")
        self.assertIsNone(site.path("pose_graph", "loops_csv"))
        with self.assertRaisesRegex(DataError, "office: its pipeline has no loops.loops.*run make map with a profile"):
            site.needed("loops", "loops")
