# SPDX-License-Identifier: Apache-2.0
"""Shared parts of the tests of accuracy: maps of real recordings and of made-up buildings, and the bars that the project
promises, for one seed; tests/bench/seeds.py prints medians of several. Maps are kept in <build>/accuracy, so that a second
run costs only what changed. Readers here share no code with nightmap: numpy, PIL, and the octomap tools."""
import json
import os
import pathlib
import re
import sys
import unittest

import numpy as np
from PIL import Image

from workspace import BUILD, REPOSITORY, said_by

sys.path.append(str(REPOSITORY / "tests/bench"))
from grid_holes import holes  # noqa: E402

DATA = pathlib.Path(os.environ.get("NIGHTMAP_DATA", REPOSITORY / "../shared/data"))
FOLDER = BUILD / "accuracy"


def make(site, data, *goals):
    said_by(["make", "--no-print-directory", f"SITE={site}", f"DATA={data}", f"MAPS={FOLDER}/maps", f"BUILD={BUILD}", *goals])
    return FOLDER / "maps" / site


def metrics_of(site_dir):
    return json.loads((site_dir / "evaluate/metrics.json").read_text())


def calibration_of(site_dir):
    """The calibration of the site's only camera that mapping found."""
    [calibration] = json.loads((site_dir / "adjust/report.json").read_text())["calibrations"]
    return calibration


def real(recording):
    """Skips the test without the recording, except in CI, where a skip would hide a missing test."""
    if (DATA / recording).is_dir():
        return DATA
    message = f"{DATA / recording} is missing: set NIGHTMAP_DATA"
    if os.environ.get("CI") == "true":
        raise AssertionError(message)
    raise unittest.SkipTest(message)


def read_map(site_dir, name="map"):
    """Gray values (row 0 at the largest y), resolution and origin, by the rules of map_server."""
    text = (site_dir / f"grid/{name}.yaml").read_text()
    value = dict(re.findall(r"(?m)^(\w+): *(.*)$", text))
    pixels = np.array(Image.open(site_dir / "grid" / value["image"]))
    x, y, yaw = json.loads(value["origin"])
    assert value["negate"] == "0" and yaw == 0 and pixels.dtype == np.uint8
    occupancy = (255 - pixels.astype(float)) / 255
    known = {"free": occupancy < float(value["free_thresh"]),
             "occupied": occupancy > float(value["occupied_thresh"])}
    return pixels, known, float(value["resolution"]), (x, y)


class Bars(unittest.TestCase):
    def check_trajectory(self, metrics, max_ate_m, min_frames):
        self.assertLessEqual(metrics["trajectory"]["se3"]["ate_rmse_m"], max_ate_m)
        self.assertGreaterEqual(metrics["coverage"]["num_frames_with_pose"], min_frames)

    def check_queries(self, queries, max_median_cm, max_median_deg):
        """Against the map around them; and none is in a wrong place."""
        self.assertLessEqual(queries["local"]["median_translation_error_cm"], max_median_cm)
        self.assertLessEqual(queries["local"]["median_rotation_error_deg"], max_median_deg)
        self.assertEqual(queries["num_wrong"], 0)

    def check_grid(self, floor, min_walls_closed_percent):
        """One floor against its exact plan: cells, walls, doors."""
        self.assertGreaterEqual(floor["seen_right_percent"], 97)
        self.assertGreaterEqual(floor["walls_closed_percent"], min_walls_closed_percent)
        self.assertGreaterEqual(floor["num_walls"], 10)
        self.assertEqual(floor["num_walls_crossed"], 0)
        self.assertEqual((floor["num_doors_wrongly_passable"], floor["num_doors_wrongly_closed"]), (0, 0))

    def check_path_between_pictures(self, site_dir):
        plan = self.check_path(site_dir)
        self.assertTrue(plan["start"]["is_picture"] and plan["goal"]["is_picture"])

    def check_path(self, site_dir, name="map"):
        """Every cell of a floor's grid that the robot touches on the path is free or a hole, and the path has no gap."""
        pixels, known, resolution_m, origin = read_map(site_dir, name)
        plan = json.loads((site_dir / "plan/report.json").read_text())
        radius_m = float(re.search(r"robot_radius_m = ([0-9.]+)", plan["config"]).group(1))
        points = np.loadtxt(site_dir / "plan/path.csv", delimiter=",", skiprows=1, ndmin=2)[:, :2]
        self.assertLessEqual(np.linalg.norm(np.diff(points, axis=0), axis=1).max(), 1.5 * resolution_m)
        max_hole_m = float(re.search(r"max_hole_m = ([0-9.]+)", plan["config"]).group(1))
        filled = holes(known["free"], known["occupied"], int(max_hole_m / resolution_m + 1e-6))
        self.assertEqual(filled.sum(), plan["num_hole_cells"])
        rows, columns = np.nonzero(~known["free"] & ~filled)
        blocked = np.column_stack([origin[0] + (columns + 0.5) * resolution_m,
                                   origin[1] + (pixels.shape[0] - rows - 0.5) * resolution_m])
        # From the path to the square of a blocked cell.
        gaps_m = (np.maximum(np.abs(blocked - point) - resolution_m / 2, 0) for point in points)
        nearest_m = min(np.linalg.norm(gap_m, axis=1).min() for gap_m in gaps_m)
        self.assertGreaterEqual(nearest_m, radius_m - 1e-5)
        return plan
