# SPDX-License-Identifier: Apache-2.0
"""Layers that the 3-D view of the report has of the results of a site with a camera, and of one with a laser."""

import json
import re
from types import SimpleNamespace

import numpy as np
from PIL import Image

import fake_site
import laser_site
from folder_case import SiteFolderTest
from nightmap_eval.page.scene import scene_section
from nightmap_eval.page.scene_layers import query_layers
from nightmap_eval.trajectory import rotation_matrices
from nightmap_site.site import Site

DATA = re.compile(r'<script type="application/json" id="scene-data">(.*?)</script>')
ROUNDED_M = 6e-5


def scene_of(test):
    site = Site(test.site_dir, test.folder)
    scene = json.loads(DATA.search(scene_section(site, {}, site.data))[1])
    return scene, {layer["name"]: layer for layer in scene["layers"]}


class CameraTest(SiteFolderTest):
    def setUp(self):
        self.estimate = fake_site.write_site(self.site_dir)
        self.write("pose_graph/loops.csv", "frame_a,frame_b,status,reason\n0,39,accepted,\n3,20,rejected,inconsistent\n3,400,accepted,\n")

    def test_the_way_and_its_loops_are_at_their_places(self):
        scene, layers = scene_of(self)
        np.testing.assert_allclose(np.reshape(layers["trajectory"]["points"], (-1, 3)), self.estimate.positions_m, atol=ROUNDED_M)
        for name, ends in (("accepted", [0, 39]), ("rejected", [3, 20])):  # none of a frame that there is not
            [segment] = layers[f"loops_{name}"]["segments"]
            np.testing.assert_allclose(np.reshape(segment, (2, 3)), self.estimate.positions_m[ends], atol=ROUNDED_M)
        low, high = np.reshape(scene["bounds"], (2, 3))
        self.assertTrue((low < self.estimate.positions_m).all() and (self.estimate.positions_m < high).all())

    def test_the_robot_sees_along_its_camera(self):
        views = np.reshape(scene_of(self)[0]["views"], (-1, 6))
        np.testing.assert_allclose(views[0, :3], self.estimate.positions_m[0], atol=ROUNDED_M)
        np.testing.assert_allclose(views[0, 3:], rotation_matrices(self.estimate.quaternions[:1])[0][:, 2], atol=1e-4)

    def test_located_pictures_are_at_their_poses(self):
        located = self.estimate.select(range(3))
        fake_site.write_queries(self.site_dir, located, 2)
        (self.folder / "queries").mkdir()
        Image.new("RGB", (64, 48), "red").save(self.folder / "queries" / "0.png")
        pictures = scene_of(self)[1]["queries"]["pictures"]
        np.testing.assert_allclose([picture["place"] for picture in pictures], located.positions_m, atol=ROUNDED_M)
        axes = np.reshape([picture["axes"] for picture in pictures], (-1, 3, 3))
        np.testing.assert_allclose(axes, located.rotations().transpose(0, 2, 1), atol=1e-4)
        self.assertTrue(pictures[0]["picture"].startswith("data:image/jpeg;base64,"))
        self.assertEqual([picture["picture"] for picture in pictures[1:]], ["", ""])  # no such file

    def test_the_same_results_give_the_same_section(self):
        site = Site(self.site_dir, self.folder)
        self.assertEqual(scene_section(site, {}, None), scene_section(Site(self.site_dir), {}, None))


class LaserTest(laser_site.LaserFolderTest):
    def setUp(self):
        super().setUp()
        self.estimate = laser_site.write_site(self.site_dir)

    def test_the_grid_carries_the_way(self):
        scene, layers = scene_of(self)
        [plane] = layers["grid"]["planes"]
        self.assertEqual((plane["corner"], layers["grid"]["on"]), ([-3, -2, 0], True))
        rows, columns = fake_site.room_pixels().shape
        np.testing.assert_allclose(plane["size"], [0.1 * columns, 0.1 * rows])
        self.assertEqual(len(layers["loops_accepted"]["segments"]), 1)
        ahead = rotation_matrices(self.estimate.quaternions[:1])[0][:, 0]
        np.testing.assert_allclose(scene["views"][0], [*(self.estimate.positions_m[0] + [0, 0, 1]), *ahead], atol=1e-4)

    def test_a_floor_is_at_its_height(self):
        floors = [{"number": 0, "height_m": 2.5, "yaml": "map.yaml"}]
        self.write("grid/floors.json", json.dumps({"format": "nightmap floors", "version": 2, "floors": floors}))
        [plane] = scene_of(self)[1]["grid"]["planes"]
        self.assertEqual(plane["corner"][2], 2.5)

    def test_located_scans_point_along_the_robot(self):
        fake_site.write_queries(self.site_dir, self.estimate.select([7]), 1)
        queries = self.site_dir / "localize" / "queries.csv"
        site = SimpleNamespace(made=lambda job, _: queries if job == "localize" else None, pipeline=SimpleNamespace(asks="scans"))
        [layer] = query_layers(site, {}, None)
        [scan] = layer["scans"]
        self.assertEqual(scan["name"], "queries/0.png")
        ahead = rotation_matrices(self.estimate.quaternions[7:8])[0][:, 0]
        np.testing.assert_allclose(scan["view"], [*(self.estimate.positions_m[7] + [0, 0, 1]), *ahead], atol=1e-4)
