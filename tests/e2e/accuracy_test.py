#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Accuracy on real recordings and on the demo building, and its artifacts in the eyes of others.

Bars are those the project promises, for one seed; tests/bench/seeds.py prints medians of several. Maps
are kept in <build>/accuracy, so that a second run costs only what changed. Readers here share no
code with nightmap: numpy, PIL, and the octomap tools.
"""
import json
import os
import pathlib
import re
import shutil
import subprocess
import unittest

import h5py
import numpy as np
from PIL import Image

from workspace import BUILD, REPOSITORY, environment

DATA = pathlib.Path(os.environ.get("NIGHTMAP_DATA", REPOSITORY / "../shared/data"))
FOLDER = BUILD / "accuracy"
FREE = 254


def make(site, data, *goals):
    result = subprocess.run(
        ["make", "--no-print-directory", f"SITE={site}", f"DATA={data}", f"MAPS={FOLDER}/maps",
         f"BUILD={BUILD}", *goals],
        cwd=REPOSITORY, env=environment(), text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    if result.returncode != 0:
        raise AssertionError(f"make {' '.join(goals)} SITE={site} failed:\n{result.stdout[-4000:]}")
    return FOLDER / "maps" / site


def metrics_of(site_dir):
    return json.loads((site_dir / "evaluate/metrics.json").read_text())


def calibration_of(site_dir):
    """What mapping found out about the site's only camera."""
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


def quaternion_matrix(x, y, z, w):
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                     [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                     [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])


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
        """Every cell of a floor's grid that the robot touches on the path is free, and the path has no gap."""
        pixels, known, resolution_m, origin = read_map(site_dir, name)
        plan = json.loads((site_dir / "plan/report.json").read_text())
        radius_m = float(re.search(r"robot_radius_m = ([0-9.]+)", plan["config"]).group(1))
        points = np.loadtxt(site_dir / "plan/path.csv", delimiter=",", skiprows=1, ndmin=2)[:, :2]
        self.assertLessEqual(np.linalg.norm(np.diff(points, axis=0), axis=1).max(), 1.5 * resolution_m)
        rows, columns = np.nonzero(~known["free"])
        blocked = np.column_stack([origin[0] + (columns + 0.5) * resolution_m,
                                   origin[1] + (pixels.shape[0] - rows - 0.5) * resolution_m])
        # From the path to the square of a blocked cell.
        gaps_m = (np.maximum(np.abs(blocked - point) - resolution_m / 2, 0) for point in points)
        nearest_m = min(np.linalg.norm(gap_m, axis=1).min() for gap_m in gaps_m)
        self.assertGreaterEqual(nearest_m, radius_m - 1e-5)
        return plan


class RealDataTest(Bars):
    def test_fr1_xyz(self):
        data = real("tum_fr1_xyz_15hz")
        site_dir = make("tum_fr1_xyz_15hz", data, "map", "evaluate")
        self.check_trajectory(metrics_of(site_dir), 0.009, 399)
        # A Kinect reads its rows one after the other, from the top, in most of the 33 ms of a frame.
        readout_s = calibration_of(site_dir)["rolling_shutter_readout_s"]
        self.assertTrue(0.015 < readout_s < 0.034, readout_s)

    def test_fr1_xyz_queries(self):
        data = real("tum_fr1_xyz_15hz")
        queries = metrics_of(make("tum_fr1_xyz_15hz_queries", data, "localize", "evaluate"))["queries"]
        self.check_queries(queries, 1.0, 0.6)

    def test_hololens_office(self):
        data = real("hololens_office")
        self.check_trajectory(metrics_of(make("hololens_office", data, "map", "evaluate")), 0.045, 373)

    def test_hololens_office_queries(self):
        data = real("hololens_office")
        site_dir = make("hololens_office_queries", data, "map", "localize", "plan", "evaluate")
        queries = metrics_of(site_dir)["queries"]
        self.check_queries(queries, 1.2, 0.3)
        self.assertGreaterEqual(queries["local"]["recall_5cm_5deg_percent"], 97)
        self.assertGreaterEqual(queries["global"]["recall_5cm_5deg_percent"], 85)
        self.check_path_between_pictures(site_dir)


class DemoTest(Bars):
    @classmethod
    def setUpClass(cls):
        cls.site_dir = make("demo", FOLDER / "data", "map", "localize", "plan", "evaluate", "report")
        cls.metrics = metrics_of(cls.site_dir)

    def test_trajectory_queries_cloud_and_grid_against_the_truth(self):
        self.check_trajectory(self.metrics, 0.02, 700)
        calibration = calibration_of(self.site_dir)  # of a rendered camera: what is configured
        self.assertAlmostEqual(calibration["focal_scale"], 1, delta=0.001)
        self.assertAlmostEqual(calibration["rolling_shutter_readout_s"], 0, delta=0.001)
        self.check_queries(self.metrics["queries"], 0.5, 0.2)
        self.assertGreaterEqual(self.metrics["queries"]["local"]["recall_1cm_1deg_percent"], 98)
        self.assertLessEqual(self.metrics["map"]["cloud"]["surface_distance_median_m"], 0.02)
        self.check_grid(self.metrics["map"]["grid"], 99)
        self.assertGreaterEqual(self.metrics["map"]["grid"]["wall_length_present_percent"], 99)

    def test_path(self):
        self.check_path_between_pictures(self.site_dir)

    def test_grid_by_the_rules_of_map_server(self):
        _, known, _, _ = read_map(self.site_dir)
        report = json.loads((self.site_dir / "grid/report.json").read_text())
        self.assertEqual(np.count_nonzero(known["free"]), report["num_free_cells"])
        self.assertEqual(np.count_nonzero(known["occupied"]), report["num_occupied_cells"])

    def test_picture_and_distances_of_the_grid(self):
        pixels, known, resolution_m, origin = read_map(self.site_dir)
        np.testing.assert_array_equal(np.array(Image.open(self.site_dir / "grid/map.png")), pixels)
        [floor] = json.loads((self.site_dir / "grid/floors.json").read_text())["floors"]
        with h5py.File(self.site_dir / "grid/distances.h5") as file:
            group = file[floor["distances"]]
            clearance_m, signed_m = np.array(group["clearance_m"]), np.array(group["signed_distance_m"])
            np.testing.assert_allclose(np.ravel(group["origin_in_map_m"]), origin)
        np.testing.assert_array_equal(clearance_m > 0, known["free"][::-1])  # row 0 is the smallest y
        np.testing.assert_array_equal(signed_m < 0, known["occupied"][::-1])
        blocked = np.argwhere(~known["free"][::-1])
        for cell in np.argwhere(known["free"][::-1])[::997]:
            nearest_m = resolution_m * np.linalg.norm(blocked - cell, axis=1).min()
            self.assertAlmostEqual(clearance_m[tuple(cell)], nearest_m, places=5)

    def test_trajectories_as_evo_reads_them(self):
        for name, count in (("trajectory", 700), ("keyframes", None)):
            values = np.loadtxt(self.site_dir / f"adjust/{name}.tum")
            self.assertEqual(values.shape[1], 8)
            self.assertTrue(count is None or len(values) == count)
            self.assertTrue(np.all(np.diff(values[:, 0]) > 0))
            np.testing.assert_allclose(np.linalg.norm(values[:, 4:], axis=1), 1, atol=1e-6)

    def test_g2o_edges_agree_with_the_vertices(self):
        poses, errors_m = {}, []
        for line in (self.site_dir / "adjust/graph.g2o").read_text().splitlines():
            tag, *words = line.split()
            if tag == "VERTEX_SE3:QUAT":
                values = [float(word) for word in words[1:]]
                poses[int(words[0])] = quaternion_matrix(*values[3:]), np.array(values[:3])
            elif tag == "EDGE_SE3:QUAT":
                a, b = (poses[int(word)] for word in words[:2])
                a_from_b = a[0].T @ (b[1] - a[1])
                errors_m.append(np.linalg.norm(a_from_b - [float(word) for word in words[2:5]]))
        self.assertGreater(len(errors_m), 300)
        self.assertLess(np.median(errors_m), 0.01)  # an edge the wrong way round is off by 0.2 m

    def test_octree_as_the_octomap_tools_read_it(self):
        self.assertTrue(shutil.which("convert_octree"), "install octomap-tools: scripts/install_deps.sh")
        for source, target in (("map.ot", "from_ot.bt"), ("map.bt", "from_bt.bt")):
            result = subprocess.run(["convert_octree", self.site_dir / "octree" / source, FOLDER / target],
                                    text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
            self.assertEqual(result.returncode, 0, result.stdout)
        self.assertEqual((FOLDER / "from_ot.bt").read_bytes().split(b"data\n")[1],
                         (FOLDER / "from_bt.bt").read_bytes().split(b"data\n")[1])

    def test_cloud_as_any_ply_reader_reads_it(self):
        content = (self.site_dir / "point_cloud/cloud.ply").read_bytes()
        header, body = content.split(b"end_header\n", 1)
        kinds = {b"float": "<f4", b"uchar": "u1", b"ushort": "<u2"}
        self.assertIn(b"format binary_little_endian 1.0", header)
        fields = [(name.decode(), kinds[kind]) for kind, name in re.findall(rb"property (\w+) (\w+)", header)]
        points = np.frombuffer(body, dtype=fields)
        self.assertEqual(len(points), int(re.search(rb"element vertex (\d+)", header).group(1)))
        normals = np.column_stack([points["nx"], points["ny"], points["nz"]])
        np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1, atol=1e-3)
        self.assertTrue(-0.2 < np.percentile(points["z"], 1) and np.percentile(points["z"], 99) < 2.8)


class TwoFloorsTest(Bars):
    def test_each_floor_has_a_right_grid(self):
        site_dir = make("two_floors", FOLDER / "data", "map", "evaluate")
        metrics = metrics_of(site_dir)
        self.check_trajectory(metrics, 0.02, 600)
        grid = metrics["map"]["grid"]
        self.assertEqual((grid["num_true_floors"], grid["num_floors"], grid["num_floors_found"]), (2, 2, 2))
        for floor in grid["floors"]:
            # The way never faces two walls: behind a door that stands open, and at the ramp's foot.
            self.check_grid(floor, 90)
            self.assertLess(floor["height_error_m"], 0.03)
        for name in ("map", "floor_1"):
            text = (site_dir / f"grid/{name}.yaml").read_text()
            self.assertIn(f"image: {name}.pgm\n", text)
            self.assertTrue((site_dir / f"grid/{name}.png").exists())
        self.check_drive_upstairs(site_dir)

    def check_drive_upstairs(self, site_dir):
        """Between two places where the camera was upstairs, the one as a pose, the other by its floor."""
        floor = json.loads((site_dir / "grid/floors.json").read_text())["floors"][1]
        poses = np.loadtxt(site_dir / "map_frame/trajectory.tum")[:, 1:4]
        upstairs = poses[np.abs(poses[:, 2] - floor["height_m"] - 1) < 0.1]
        self.assertGreater(len(upstairs), 100)
        start, goal = upstairs[len(upstairs) // 4], upstairs[3 * len(upstairs) // 4]
        ends = [f"START={start[0]},{start[1]},{start[2]}", f"GOAL={goal[0]},{goal[1]}"]
        with self.assertRaisesRegex(AssertionError, r"start .* is on floor 1 .* but goal .* on floor 0"):
            make("two_floors", FOLDER / "data", "drive", *ends)
        make("two_floors", FOLDER / "data", "drive", *ends, "SET=plan.floor=1")
        plan = self.check_path(site_dir, "floor_1")
        self.assertEqual((plan["floor"], plan["floor_height_m"]), (1, floor["height_m"]))
        points = np.loadtxt(site_dir / "plan/path.csv", delimiter=",", skiprows=1)
        np.testing.assert_allclose(points[:, 6:], [[floor["height_m"], 1]] * len(points), atol=1e-6)
        positions = re.findall(r"position: {.* z: (.*)}", (site_dir / "plan/path.yaml").read_text())
        self.assertEqual(set(positions), {f"{floor['height_m']:.6f}"})
        drive = json.loads((site_dir / "drive/report.json").read_text())
        self.assertEqual(drive["floor"], 1)
        self.assertLess(drive["position_error_m"], 0.05)


if __name__ == "__main__":
    unittest.main()
