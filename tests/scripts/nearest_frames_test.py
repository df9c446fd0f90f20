# SPDX-License-Identifier: Apache-2.0
"""Keyframes that are shown beside a located picture."""

from folder_case import FolderTest
from nightmap_eval.camera.report_queries import nearest_keyframes
from nightmap_site.site import Site

TURNED_180 = "0 1 0 0"  # about y: the camera looks back


class NearestFramesTest(FolderTest):
    def setUp(self):
        for name in ("frames", "map_frame", "localize"):
            (self.folder / name).mkdir()
        rows = "".join(f"{i},{1000 + i},0,color/{i}.png\n" for i in range(4))
        (self.folder / "frames" / "shards.txt").write_text("nightmap shards, version 1, 1 names\n0000\n")
        (self.folder / "frames" / "shard_0000.csv").write_text("frame_idx,time_ns,sequence_idx,color_path\n" + rows)
        # At x = 0 m, 1 m and 2 m; the last one looks back.
        poses = ("0 0 0 0 0 0 1", "1 0 0 0 0 0 1", f"2 0 0 {TURNED_180}")
        self.keyframes = "".join(f"0.00000100{i} {pose}\n" for i, pose in enumerate(poses))
        (self.folder / "map_frame" / "keyframes.tum").write_text(self.keyframes)

    def locate(self, *rows):
        header = "query_idx,time_ns,color_path,status,reason,tx_m,ty_m,tz_m,qx,qy,qz,qw\n"
        text = "".join(f"{i},{10 + i},q{i}.png,{row}\n" for i, row in enumerate(rows))
        (self.folder / "localize" / "queries.csv").write_text(header + text)
        nearest = nearest_keyframes(Site(self.folder))
        return {idx: nearest.near(*nearest.pose_of({"query_idx": idx}), 2) for idx in nearest.pose_of_query} if nearest else {}

    def test_place_and_view_both_count(self):
        found = self.locate("located,,0.9,0,0,0,0,0,1", "not_in_map,few inliers,,,,,,,", "located,,0.9,0,0,0,1,0,0")
        self.assertEqual(found[0], ["color/1.png", "color/0.png"])
        self.assertNotIn(1, found)
        self.assertEqual(found[2][0], "color/2.png")  # a metre away, but the view of the nearer ones is of the other side

    def test_keyframes_that_are_no_frames_are_left_out_and_without_a_map_there_are_none(self):
        (self.folder / "map_frame" / "keyframes.tum").write_text("0.000000500 0.9 0 0 0 0 0 1\n" + self.keyframes)
        self.assertEqual(self.locate("located,,0.9,0,0,0,0,0,1")[0], ["color/1.png", "color/0.png"])
        (self.folder / "map_frame" / "keyframes.tum").unlink()
        self.assertEqual(self.locate("located,,0.9,0,0,0,0,0,1"), {})
