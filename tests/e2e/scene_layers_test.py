# SPDX-License-Identifier: Apache-2.0
"""Layers of the map in space as the page holds them: the octree against OctoMap's reader, names of things, labels beside colors."""
import json
import pathlib
import re
import shutil
import subprocess
import tempfile
import unittest

import numpy as np

from scene_page import SCENE, SceneCase, ScenePage

from labels_site import thing_box, thing_entry
from nightmap_eval import html
from nightmap_eval.page import scene, scene_layers
from nightmap_eval.page.scene_cloud import color_cloud
from nightmap_eval.things import UprightBox, read_things

VOXEL = re.compile(r"translation (\S+) (\S+) (\S+) \n.*size (\S+) ")


class OctreeTest(SceneCase):
    def test_cubes_are_the_occupied_leaves(self):
        self.assertTrue(shutil.which("bt2vrml"), "install octomap-tools: scripts/install_deps.sh")
        copy = self.work.folder / "map.bt"
        shutil.copy(self.work.path("octree/map.bt"), copy)
        subprocess.run(["bt2vrml", copy], check=True, capture_output=True)
        voxels = np.array(VOXEL.findall(copy.with_suffix(".bt.wrl").read_text()), float)
        page = self.open()
        cubes = np.reshape(page.value(f"{SCENE}.cubes(1e9)"), (-1, 4))
        self.assertGreater(len(voxels), 1000)
        self.assertEqual(len(cubes), len(voxels))
        for one, other in zip(*(rows[np.lexsort(np.round(rows, 4).T)] for rows in (cubes, voxels))):
            np.testing.assert_allclose(one, other, atol=1e-4)

    def test_few_cubes_cover_all_the_leaves(self):
        page = self.open()
        fine, coarse = (np.reshape(page.value(f"{SCENE}.cubes({most})"), (-1, 4)) for most in (1e9, 2000))
        self.assertLessEqual(len(coarse), 2000)
        self.assertGreater(len(coarse), 100)
        inside = (np.abs(fine[:, None, :3] - coarse[None, :, :3]) < coarse[None, :, 3:] / 2).all(axis=2)
        self.assertTrue((inside.sum(axis=1) == 1).all())  # each leaf in one cube
        self.assertTrue(inside.any(axis=0).all())  # no cube of nothing


class MadeUpPageTest(unittest.TestCase):
    NAME = "</script><img src=x onerror=\"document.title = 'broken'\"><b>&amp;"

    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="nightmap-e2e-"))
        self.addCleanup(shutil.rmtree, self.folder)

    def open(self, layers, texts):
        shown = {"site": self.NAME, "layers": layers, "views": [], "outline": [0, 0, 0, 2, 3, 1], "bounds": [0, 0, 0, 2, 3, 1]}
        path = self.folder / "index.html"
        path.write_text(html.page(self.NAME, "", [html.section(self.NAME, html.Raw(scene.markup(shown, texts)), is_open=True)]), encoding="utf-8")
        return ScenePage(self, path)

    def test_markup_in_a_name_stays_text(self):
        entry = thing_entry(self.NAME, "table", thing_box(UprightBox(np.array([1.0, 2, 0.5]), np.array([0.5, 0.4, 0.5]), 0.3)))
        things = self.folder / "things.json"
        things.write_text(json.dumps({"format": "nightmap_things", "version": 1, "things": [entry]}))

        class OneFile:
            def made(self, *_):
                return things

        self.assertEqual(read_things(OneFile())[0].name, self.NAME)
        page = self.open(list(scene_layers.thing_layers(OneFile())), {})
        page.wait("document.querySelectorAll('.scene-names span').length === 1")
        self.assertEqual(page.texts(".scene-names span"), [self.NAME])
        self.assertNotEqual(page.value("document.title"), "broken")
        self.assertEqual(page.value("document.querySelectorAll('img, b').length"), 0)
        self.assertGreater(page.value(f"{SCENE}.pixelsDrawn()"), 0)

    def test_one_of_two_clouds_of_the_same_points_is_shown(self):
        texts, path = {}, self.folder / "cloud.ply"
        head = "".join(f"property {kind}\n" for kind in ("float x", "float y", "float z", "uchar red", "uchar green", "uchar blue"))
        row = np.array([(x, y, 0, 200, 10, 10) for x in np.arange(0, 2, 0.05) for y in np.arange(0, 3, 0.05)],
                       [("x", "<f4"), ("y", "<f4"), ("z", "<f4"), ("r", "u1"), ("g", "u1"), ("b", "u1")])  # fmt: skip
        path.write_bytes(f"ply\nformat binary_little_endian 1.0\nelement vertex {len(row)}\n{head}end_header\n".encode() + row.tobytes())
        clouds = [{"name": name, "title": name, "kind": "cloud", "text": f"scene-{name}", "on": name == "colors", "cloud": color_cloud(path).head()}
                  for name in ("colors", "labels")]  # fmt: skip
        texts |= {cloud["text"]: color_cloud(path).text for cloud in clouds}
        page = self.open(clouds, texts)
        picture = page.hash()
        page.click("#scene input[name=labels]")
        page.wait(f"{SCENE}.layers[1].isLoaded")
        self.assertEqual([layer["on"] for layer in page.value(f"{SCENE}.layers")], [False, True])
        self.assertEqual(page.hash(), picture)  # the same points
        self.assertFalse(page.value("document.querySelector('#scene input[name=colors]').checked"))
        page.click("#scene input[name=labels]")
        self.assertEqual(page.value(f"{SCENE}.pixelsDrawn()"), 0)
