# SPDX-License-Identifier: Apache-2.0
"""A site of two cameras that record at once: frames are listed by time and camera with unique times and described, and a map is
refused before anything runs."""
import unittest

import h5py
import matplotlib.image
import numpy as np
from workspace import SITE, Workspace, read_csv

FEATURES = f"maps/{SITE}/features/shard_0000.h5"
CAMERA = """
[[camera]]
id = "{name}"
width = 160
height = 120
fx = 130.0
fy = 130.0
cx = 79.5
cy = 59.5
depth_units_per_m = 1000
"""
SEQUENCE = """
[[sequence]]
layout = "tum"
folder = "{name}"
camera = "{name}"
depth = "none"
rig = "head"
"""
NAMES, NUM_FRAMES = ("left", "right"), 4


class RigTest(unittest.TestCase):
    def setUp(self):
        self.work = Workspace().removed_after(self)
        self.site = self.work.folder / f"configs/sites/{SITE}.toml"
        self.site.write_text(f'root = "{SITE}"\n' + "".join(table.format(name=name) for table in (CAMERA, SEQUENCE) for name in NAMES))
        random = np.random.default_rng(1)
        for name in NAMES:
            folder = self.work.data() / name
            folder.mkdir(parents=True)
            for i in range(NUM_FRAMES):
                blocks = random.integers(0, 255, (15, 20, 3), dtype=np.uint8)
                matplotlib.image.imsave(folder / f"{i}.png", np.kron(blocks, np.ones((8, 8, 1), np.uint8)))
            (folder / "rgb.txt").write_text("".join(f"{i}.5 {i}.png\n" for i in range(NUM_FRAMES)))

    def test_frames_and_features_are_made_and_a_map_is_refused_once(self):
        self.work.output(FEATURES)
        rows = [(int(row["time_ns"]), row["camera_idx"], row["color_path"]) for row in read_csv(self.work.path("frames/shard_0000.csv"))]
        self.assertEqual(rows, [(i * 10**9 + 5 * 10**8 + camera, str(camera), f"{SITE}/{name}/{i}.png")
                                for i in range(NUM_FRAMES) for camera, name in enumerate(NAMES)])  # fmt: skip
        with h5py.File(self.work.folder / FEATURES) as file:
            self.assertEqual(list(file["frame_idx"]), list(range(2 * NUM_FRAMES)))
            self.assertTrue((np.diff(file["first_feature"]) > 0).all())

        result = self.work.output("map", code=2)
        for said in ("cameras of a rig record at once, which odometry, pose_graph cannot use", "no recording has depth"):
            self.assertEqual(result.count(said), 1, result)
        lines = [i for i, line in enumerate(self.site.read_text().splitlines(), 1) if line == "[[sequence]]"]
        self.assertIn(", ".join(f"configs/sites/{SITE}.toml:{i}" for i in lines), result)
        self.assertNotIn("== ", result)

        self.site.write_text(self.site.read_text().replace('rig = "head"\n', ""))
        self.assertIn("cameras that record at once need the same `rig`", self.work.output(FEATURES, code=2))
