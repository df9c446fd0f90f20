# SPDX-License-Identifier: Apache-2.0
"""A ROS map alone, without a recording: paths are planned on it and laser scans located in it. Text and picture of the map are
those that Python programs write."""
import json
import shutil

import numpy as np
import yaml
from PIL import Image

from workspace import SiteTest, Workspace

SITE = "office"
CELL_M = 0.05
CONFIG = """\
root = "office"
profile = "laser"

[import]
map = "office/map.yaml"

[[sensor]]
id = "laser"
kind = "scan"
start_angle_deg = -180
angle_step_deg = 4
max_range_m = 12
robot_from_sensor = [0.0, 0.0, 0.3, 0.0, 0.0, 0.0, 1.0]
"""
POSE = (2.2, 1.4, 0.5)  # of the robot when it takes the scan: x, y, heading


def floor():
    """Gray values as map_saver writes them, top row first: an L-shaped room of 8 m x 5 m with a pillar, in unseen space."""
    gray = np.full((140, 200), 205, np.uint8)
    gray[20:120, 20:180] = 254
    gray[20:60, 100:180] = 205
    gray[20:120, 20], gray[119, 20:180], gray[60:120, 179], gray[20, 20:100], gray[20:60, 99], gray[60, 99:180] = [0] * 6
    gray[80:88, 60:72] = 0
    return gray


def scan(gray, origin_m):
    """Ranges of 90 beams from POSE, by steps along each."""
    x, y, heading = POSE
    steps = np.arange(0.1, 12, 0.01)
    ranges = []
    for beam in range(90):
        angle = heading - np.pi + beam * np.radians(4)
        columns = ((x + steps * np.cos(angle) - origin_m[0]) / CELL_M).astype(int)
        rows = gray.shape[0] - 1 - ((y + steps * np.sin(angle) - origin_m[1]) / CELL_M).astype(int)
        hit = np.flatnonzero(gray[rows.clip(0, gray.shape[0] - 1), columns.clip(0, gray.shape[1] - 1)] == 0)
        ranges.append(steps[hit[0]] if len(hit) else 12)
    return ranges


class RosMapTest(SiteTest):
    given = (f"SITE={SITE}",)

    def setUp(self):
        self.work = Workspace().removed_after(self)
        self.folder = self.work.folder / "data" / SITE
        self.folder.mkdir(parents=True)
        (self.work.folder / f"configs/sites/{SITE}.toml").write_text(CONFIG)
        self.maps = self.work.folder / "maps" / SITE
        self.gray, self.origin_m = floor(), [-1.5, -2.0, 0.0]
        self.write("map.png")

    def write(self, picture, **changed):
        """The map as yaml.dump writes it: keys in order, lists as blocks."""
        values = {"image": picture, "mode": "trinary", "resolution": CELL_M, "origin": self.origin_m, "negate": False, "occupied_thresh": 0.65,
                  "free_thresh": 0.196} | changed  # fmt: skip
        (self.folder / "map.yaml").write_text(yaml.dump(values, explicit_start=True, explicit_end=True, version=(1, 1)))
        self.save(picture)

    def save(self, picture):
        """As a picture with a palette."""
        Image.fromarray(self.gray).convert("P").save(self.folder / picture)

    def test_paths_are_planned_and_scans_located_on_a_map_alone(self):
        log = self.folder / "scan.log"
        log.write_text("FLASER 90 " + " ".join(f"{r:.3f}" for r in scan(self.gray, self.origin_m)) + " 0 0 0 0 0 0 1.0 robot 1.0\n")
        self.make("plan", "START=0.5,-0.2", "GOAL=5.5,0.5")
        path = json.loads((self.maps / "plan/path.json").read_text())
        self.assertGreater(path["length_m"], 5)
        self.assertLess(path["length_m"], 7)
        self.assertFalse((self.maps / "frames").exists())
        pixels = (self.maps / "grid/map.pgm").read_bytes()[-self.gray.size :]
        self.assertEqual(pixels, self.gray.tobytes())
        self.make("localize", f"QUERY={log}")
        row = (self.maps / "localize/queries.tum").read_text().splitlines()[-1].split()
        self.assertLess(np.hypot(float(row[1]) - POSE[0], float(row[2]) - POSE[1]), 0.05)
        self.make("-q", "localize", f"QUERY={log}")
        self.assertIn("all as written", self.make("verify"))
        self.make("drive", "START=0.5,-0.2", "GOAL=5.5,0.5")
        for goal in ("report", "evaluate", "status", "export"):
            self.make(goal)
        self.assertTrue((self.maps / "floor_plan/plan.geojson").exists())

    def test_damaged_objects_are_refused_before_anything_runs(self):
        (self.folder / "objects.yaml").write_text("format: nightmap objects\nversion: 1\nobjects:\n  - name: desk\n    x_m: one\n    y_m: 1\n    size_x_m: 1\n"
                                                   "    size_y_m: 1\n    angle_deg: 0\n")
        config = self.work.folder / f"configs/sites/{SITE}.toml"
        config.write_text(CONFIG.replace("[import]\n", '[import]\nobjects = "office/objects.yaml"\n'))
        self.assertRegex(self.make("plan", "START=0.5,-0.2", "GOAL=5.5,0.5", code=2), r"office/objects.yaml:5: x_m")
        self.assertFalse((self.maps / "grid").exists())

    def test_a_picture_replaced_and_thresholds_are_noticed(self):
        self.make("map")
        self.make("-q", "map")
        self.gray[70:80, 60:72] = 0
        self.save("map.png")
        self.make("-q", "map", code=1)
        self.make("map")
        self.assertEqual((self.maps / "grid/map.pgm").read_bytes()[-self.gray.size :], self.gray.tobytes())
        self.write("map.png", free_thresh=0.25)
        self.assertIn(f"{np.count_nonzero(self.gray == 205)} cells of the gray that map_saver gives to unseen space", self.make("map"))
        self.write("map.png", free_thresh=None)
        said = self.make("map", code=2)
        self.assertIn("office/map.yaml:3: free_thresh has no value", said)
        shutil.rmtree(self.maps)
        self.write("map.png", image="none.png")
        self.assertIn("office/none.png: no such image file", self.make("map", code=2))
