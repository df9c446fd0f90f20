# SPDX-License-Identifier: Apache-2.0
"""Pictures of loops and of located queries: the points that are joined are the same in both."""

import base64
import io
import json
import re
import unittest

import numpy as np
from PIL import Image

import fake_site
from folder_case import SiteFolderTest
from nightmap_eval.camera.picture_pairs import DOT, GAP_PX, WIDTH_PX, pair_picture
from nightmap_eval.camera.query_pictures import project
from nightmap_eval.camera.report_loops import loop_pictures_section
from nightmap_eval.sealed_hdf5 import sealed
from nightmap_eval.trajectory import quaternion
from nightmap_site.script_errors import DataError
from nightmap_site.site import Site

CAMERA = {"width": 640, "height": 480, "fx": 500.0, "fy": 510.0, "cx": 320.0, "cy": 240.0}
STILL = np.array([0.0, 0, 0, 1])


def picture_of(section):
    [encoded] = re.findall(r'src="data:image/jpeg;base64,([^"]+)"', section)
    return np.asarray(Image.open(io.BytesIO(base64.b64decode(encoded)))).astype(int)


class ProjectTest(unittest.TestCase):
    def test_a_point_on_the_axis_is_in_the_middle(self):
        shares, inside = project(CAMERA, np.array([[0, 0, 2.0], [0, 0, -2], [5, 0, 2]]), np.zeros(3), STILL)
        np.testing.assert_allclose(shares[0] * [640, 480] - 0.5, (320, 240))
        self.assertEqual(inside.tolist(), [True, False, False])

    def test_pose_and_point_moved_together_change_nothing(self):
        random = np.random.default_rng(5)
        points = random.uniform(-1, 1, (50, 3)) + [0, 0, 3]
        turn, moved = fake_site.rotation_about([0.3, 1, 0.2], 0.8), random.uniform(-2, 2, 3)
        lens = CAMERA | {"k1": -0.2, "k2": 0.05, "p1": 0.001, "p2": -0.002, "k3": 0.0}
        for one, other in zip(project(lens, points, np.zeros(3), STILL), project(lens, points @ turn.T + moved, moved, quaternion(turn))):
            np.testing.assert_allclose(one, other, atol=1e-9)

    def test_other_lenses_are_not_drawn(self):
        self.assertIsNone(project(CAMERA | {"lens": "fisheye"}, np.ones((1, 3)), np.zeros(3), STILL))
        self.assertIsNone(project(CAMERA | {"k4": 0.1}, np.ones((1, 3)), np.zeros(3), STILL))


class LoopPicturesTest(SiteFolderTest):
    def setUp(self):
        fake_site.write_site(self.site_dir)
        (self.folder / "rgb").mkdir()
        for i in range(40):
            Image.new("RGB", (640, 480), (0, 0, 100)).save(self.folder / "rgb" / f"{i}.png")
        self.write("frames/cameras.json", json.dumps({"cameras": [{"color": CAMERA}]}))
        self.write("pose_graph/loops.csv", "frame_a,frame_b,status,reason,num_putative,num_inliers\n3,39,accepted,,80,2\n5,30,rejected,too <few>,9,0\n")
        for shard, frame_idx in (("0000", 3), ("0001", 39)):
            (self.site_dir / "features").mkdir(exist_ok=True)
            with sealed(self.site_dir / f"features/shard_{shard}.h5") as file:
                file["frame_idx"] = np.array([[frame_idx]], np.int32)
                file["first_feature"] = np.array([[0], [3]], np.int32)
                file["raw_keypoint_px"] = np.array([[64, 48], [320, 240], [576, 432]], np.float32)
        self.write_matches([[0, 2], [1, 1]])

    def write_matches(self, matches):
        (self.site_dir / "loops").mkdir(exist_ok=True)
        with sealed(self.site_dir / "loops/loops.h5") as file:
            file["frame"], file["first_match"] = np.array([[3, 39]], np.int32), np.array([[0], [len(matches)]], np.int32)
            file["match"] = np.array(matches, np.int32)

    def section(self):
        return str(loop_pictures_section(Site(self.site_dir, self.folder), self.folder))

    def test_matches_are_joined_where_they_are(self):
        section = self.section()
        accepted, rejected = section.split("rejected: too &lt;few&gt;, frames 5 and 30 (9 matches of descriptors, 0 agree with one motion)")
        self.assertIn("accepted, frames 3 and 39 (80 matches of descriptors, 2 agree with one motion)", accepted)
        pixels = picture_of(accepted)
        for x, y in ((0.1, 0.1), (0.5, 0.5)):  # of frame 3
            self.assertLess(np.abs(pixels[round(y * 315), round(x * WIDTH_PX)] - DOT).max(), 90)
        for x, y in ((0.9, 0.9), (0.5, 0.5)):  # of frame 39
            self.assertLess(np.abs(pixels[round(y * 315), WIDTH_PX + GAP_PX + round(x * WIDTH_PX)] - DOT).max(), 90)
        self.assertLess(np.abs(picture_of(rejected)[:, : WIDTH_PX - 4] - [0, 0, 100]).max(), 12)  # without a line

    def test_matches_of_features_that_are_not_there_draw_nothing(self):
        self.write_matches([[0, 7]])
        self.assertLess(np.abs(picture_of(self.section().split("rejected: too")[0])[:, : WIDTH_PX - 4] - [0, 0, 100]).max(), 12)

    def test_a_damaged_file_is_named(self):
        self.write("loops/loops.h5", b"no HDF5")
        with self.assertRaisesRegex(DataError, "loops.h5"):
            self.section()

    def test_a_missing_picture_leaves_a_note(self):
        self.assertIn("no picture", pair_picture(self.folder, ("rgb/0.png", "rgb/none.png"), None, "x"))


if __name__ == "__main__":
    unittest.main()
