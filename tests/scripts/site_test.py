# SPDX-License-Identifier: Apache-2.0
"""Where the files of a site are, by the pipeline that its last make used."""
from folder_case import SiteFolderTest
from nightmap_site.pipeline import PROFILE_FILE, profile_text
from nightmap_site.script_errors import DataError
from nightmap_site.site import Site


class SiteTest(SiteFolderTest):
    def setUp(self):
        self.site_dir.mkdir(parents=True)

    def test_outputs_are_where_the_pipeline_declares_them(self):
        site = Site(self.site_dir)
        self.assertEqual(site.path("join_clouds", "cloud"), self.site_dir / "point_cloud/cloud.ply")
        self.assertEqual(site.path("frames", "shard", "0001"), self.site_dir / "frames/shard_0001.csv")
        self.assertIsNone(site.path("nobody", "cloud"))
        self.assertIsNone(site.path("join_clouds", "nothing"))

    def test_a_missing_file_was_not_made(self):
        site, path = Site(self.site_dir), self.site_dir / "odometry/shard_0000.h5"
        self.assertIsNone(site.made("odometry", "odometry", "0000"))
        path.parent.mkdir()
        path.touch()
        self.assertEqual(site.made("odometry", "odometry", "0000"), path)

    def test_what_the_profile_lacks_is_told(self):
        (self.site_dir / PROFILE_FILE).parent.mkdir()
        (self.site_dir / PROFILE_FILE).write_text(profile_text("imported", ["trajectory"]))
        site = Site(self.site_dir)
        self.assertEqual(site.needed("pose_graph", "keyframes"), self.site_dir / "pose_graph/keyframes.tum")
        self.assertIsNone(site.path("pose_graph", "loops_csv"))
        with self.assertRaisesRegex(DataError, "office: its pipeline has no loops.loops.*run make map with a profile"):
            site.needed("loops", "loops")
