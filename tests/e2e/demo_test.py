# SPDX-License-Identifier: Apache-2.0
"""Accuracy on the demo building, and its artifacts in the eyes of others."""
import json
import re
import shutil
import subprocess

import h5py
import numpy as np
from PIL import Image

from accuracy import FOLDER, Bars, calibration_of, make, metrics_of, read_map


def quaternion_matrix(x, y, z, w):
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                     [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                     [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])


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
