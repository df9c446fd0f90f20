# SPDX-License-Identifier: Apache-2.0
"""evaluate.py on a small site folder: figures, what it refuses, and what it leaves behind."""

import json
import struct
import tempfile
import unittest
from pathlib import Path

import numpy as np

import fake_site
from fake_site import moved, rotation_about, walk
from nightmap_eval.artifacts import to_json
from nightmap_eval.dense.cloud_accuracy import distances_m
from nightmap_eval.grid import Grid, compare_with_plan, read_grid, read_pgm
from nightmap_eval.ply import read_ply
from nightmap_eval.sealed_hdf5 import sealed
from nightmap_eval.trajectory import Similarity, quaternion
from nightmap_site.script_errors import DataError

IDENTITY = Similarity(1.0, np.eye(3), np.zeros(3))


class EvaluateTest(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.root = Path(self.folder.name)
        self.site_dir = self.root / "maps" / "office"
        self.out = self.site_dir / "evaluate" / "metrics.json"

    def tearDown(self):
        self.folder.cleanup()

    def evaluate(self, *more):
        folders = ("--site-dir", self.site_dir, "--data", self.root, "--out", self.out)
        return fake_site.run("evaluate.py", *folders, *more)

    def metrics(self, *more):
        result = self.evaluate(*more)
        self.assertEqual(result.returncode, 0, result.stderr)
        return json.loads(self.out.read_text())

    def test_perfect_map(self):
        fake_site.write_site(self.site_dir)
        metrics = self.metrics()
        self.assertEqual(metrics["trajectory"]["num_pairs"], fake_site.NUM_FRAMES)
        self.assertLess(metrics["trajectory"]["se3"]["ate_max_m"], 1e-6)
        self.assertAlmostEqual(metrics["trajectory"]["sim3"]["scale"], 1.0, places=6)
        self.assertEqual(metrics["coverage"]["num_frames_without_pose"], 0)
        self.assertEqual(metrics["coverage"]["num_keyframes"], 8)
        self.assertFalse(list(self.out.parent.glob(".writing.*")))

    def test_the_line_has_the_rotation_and_what_turns_all_poses(self):
        estimate = fake_site.write_site(self.site_dir)
        self.assertRegex(self.evaluate().stdout, r"^office: ATE RMSE 0\.00 cm, 0\.00 deg \(SE\(3\) alignment\)$")
        turn = fake_site.rotation_about([1, 0, 0], np.radians(165))  # as of other axes on the same body
        estimate.quaternions[:] = [quaternion(rotation @ turn) for rotation in estimate.rotations()]
        path = self.site_dir / "map_frame" / "trajectory.tum"
        fake_site.write_tum(path, estimate)
        self.assertRegex(self.evaluate().stdout, r"0\.00 cm, 165\.00 deg .*turns all poses by 165 deg: are its axes those of the camera")
        angles_rad = np.linspace(0, 2, len(estimate))
        estimate.quaternions[:] = [quaternion(rotation @ fake_site.rotation_about([1, 0, 0], angle_rad))
                                   for rotation, angle_rad in zip(estimate.rotations(), angles_rad)]  # fmt: skip
        fake_site.write_tum(path, estimate)
        self.assertNotIn("axes", self.evaluate().stdout)  # a map that bends

    def test_a_truth_by_another_clock_is_not_taken_for_none(self):
        fake_site.write_site(self.site_dir, truth=False)
        for job in ("frames", "queries"):
            report = self.site_dir / job / "report.json"
            report.parent.mkdir(exist_ok=True)
            report.write_text(json.dumps({"ground_truths_apart": [{"file": "office/truth.txt", "apart_s": 7199.25}]}))
            result = self.evaluate()
            self.assertEqual(result.returncode, 1, job)
            self.assertIn("office/truth.txt: gives no frame a pose: the nearest of its times is 7199.25 s from a frame's", result.stderr)
            self.assertIn("correct its times to the clock of the frames", result.stderr)
            self.assertFalse(self.out.exists())
            report.unlink()
        self.assertEqual(self.evaluate().returncode, 0)

    def test_same_bytes_twice(self):
        fake_site.write_site(self.site_dir)
        self.metrics()
        first = self.out.read_bytes()
        self.metrics()
        self.assertEqual(self.out.read_bytes(), first)

    def test_lists_frames_without_pose(self):
        estimate = fake_site.write_site(self.site_dir)
        kept = [i for i in range(len(estimate)) if i not in (7, 39)]
        fake_site.write_tum(self.site_dir / "map_frame" / "trajectory.tum", estimate.select(kept))
        metrics = self.metrics()
        self.assertEqual(metrics["coverage"]["frames_without_pose"], [7, 39])
        # Frame 7 takes two steps with it, the last frame one.
        self.assertEqual(metrics["trajectory"]["rpe_per_frame"]["num_pairs"], 39 - 3)

    def test_counts_bridged_frames(self):
        fake_site.write_site(self.site_dir)
        path = self.site_dir / "odometry" / "shard_0001.h5"
        path.parent.mkdir()
        with sealed(path) as file:
            file["frame_idx"] = np.array([[25], [26], [27]], dtype=np.int32)
            file["state"] = np.array([[0], [1], [0]], dtype=np.int32)
        self.assertEqual(self.metrics()["coverage"]["frames_bridged"], [26])
        path.write_bytes(b"not HDF5")
        self.assertEqual(self.evaluate().returncode, 1)

    def test_frames_of_a_part_apart_have_no_pose(self):
        fake_site.write_site(self.site_dir)
        parts = [{"num_frames": 36, "runs": [[0, 9], [14, 39]]}, {"num_frames": 4, "runs": [[10, 13]]}]
        report = self.site_dir / "pose_graph" / "report.json"
        report.write_text(json.dumps({"parts": parts}), encoding="utf-8")
        coverage = self.metrics()["coverage"]
        self.assertEqual(coverage["frames_apart"], [10, 11, 12, 13])
        self.assertEqual(coverage["num_frames_with_pose"], 36)

    def test_without_truth_says_so(self):
        fake_site.write_site(self.site_dir, truth=False)
        result = self.evaluate()
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("no ground truth", result.stdout)
        metrics = json.loads(self.out.read_text())
        self.assertFalse(metrics["has_ground_truth"])
        self.assertNotIn("trajectory", metrics)

    def write_queries(self, shift_m, num_failed):
        true_queries = walk(10)
        true_queries.times_ns += 5 * 10**17
        shift = np.array([1.0, -2.0, shift_m])
        located = moved(true_queries, rotation_about([0, 0, 1], 0.5), shift)
        fake_site.write_queries(self.site_dir, located, num_failed)
        failed = walk(num_failed) if num_failed else walk(2).select([])
        failed.times_ns = 2 * 10**18 + 10 + np.arange(len(failed))
        both = [np.concatenate(pair) for pair in (
            (true_queries.times_ns, failed.times_ns),
            (true_queries.positions_m, failed.positions_m),
            (true_queries.quaternions, failed.quaternions),
        )]  # fmt: skip
        truth = fake_site.Trajectory(*both)
        fake_site.write_tum(self.site_dir / "queries" / "query_ground_truth.tum", truth)

    def test_queries(self):
        fake_site.write_site(self.site_dir)
        self.write_queries(shift_m=0.07, num_failed=10)
        queries = self.metrics()["queries"]
        self.assertEqual((queries["num_located"], queries["num_failed"]), (10, 10))
        self.assertEqual(queries["num_by_verdict"]["not_in_map"], 10)
        self.assertEqual(queries["num_with_truth"], 20)
        self.assertEqual(queries["recall_5cm_5deg_percent"], 0)
        self.assertEqual(queries["recall_10cm_5deg_percent"], 50)
        self.assertAlmostEqual(queries["rows"][0]["translation_error_cm"], 7, places=3)
        self.assertNotIn("translation_error_cm", queries["rows"][10])
        self.assertEqual(queries["global"]["recall_10cm_5deg_percent"], 50)
        self.assertAlmostEqual(queries["local"]["located_median_translation_error_cm"], 7, places=3)
        self.assertAlmostEqual(queries["rows"][0]["local_translation_error_cm"], 7, places=3)
        self.assertEqual(queries["rows"][10]["reason"], "too few inliers")

    def test_query_with_half_a_pose_is_refused(self):
        fake_site.write_site(self.site_dir)
        self.write_queries(0, 0)
        path = self.site_dir / "localize" / "queries.csv"
        lines = path.read_text().splitlines()
        lines[1] = lines[1].rsplit(",", 1)[0] + ","
        path.write_text("\n".join(lines))
        self.assertEqual(self.evaluate().returncode, 1)

    def test_map_of_a_synthetic_site(self):
        fake_site.write_site(self.site_dir)
        truth = self.root / "built" / "truth"
        # The map's grid is the plan itself, turned and moved with the trajectory: origin and yaw.
        fake_site.write_map(truth, "floor_plan", fake_site.room_pixels())
        fake_site.write_map(self.site_dir / "grid", "map", fake_site.room_pixels())
        x, y = rotation_about([0, 0, 1], 0.5)[:2, :2] @ [-3, -2] + [1, -2]
        path = self.site_dir / "grid" / "map.yaml"
        path.write_text(path.read_text().replace("[-3.0, -2.0, 0]", f"[{x}, {y}, 0.5]"))
        config = self.root / "site.toml"
        config.write_text('root = "built"\n')
        grid = self.metrics("--site-config", config)["map"]["grid"]
        self.assertEqual(grid["seen_right_percent"], 100)
        self.assertEqual(grid["num_occupied_cells"], 2 * 60 + 2 * 38 + 3 * 8)

    def test_refusals(self):
        self.assertEqual(self.evaluate().returncode, 1)  # no trajectory
        self.assertEqual(fake_site.run("evaluate.py", "--out", "x").returncode, 2)
        fake_site.write_site(self.site_dir)
        path = self.site_dir / "map_frame" / "trajectory.tum"
        path.write_text(path.read_text() + "3000000000 nan 0 0 0 0 0 1\n")
        result = self.evaluate()
        self.assertEqual(result.returncode, 1)
        self.assertIn("trajectory.tum:42: NaN", result.stderr)
        self.assertFalse(self.out.exists())

    def test_pose_of_an_unlisted_frame_is_refused(self):
        estimate = fake_site.write_site(self.site_dir)
        estimate.times_ns[-1] += 1
        fake_site.write_tum(self.site_dir / "map_frame" / "trajectory.tum", estimate)
        self.assertEqual(self.evaluate().returncode, 1)


class JsonTest(unittest.TestCase):
    def test_nan_and_infinity_are_refused(self):
        for value in (np.nan, np.inf):
            with self.assertRaises(DataError):
                to_json({"a": [value]})

    def test_numpy_values(self):
        values = {"a": np.float64(0.1), "b": np.int64(3), "c": np.bool_(True), "d": None}
        self.assertEqual(json.loads(to_json(values)), {"a": 0.1, "b": 3, "c": True, "d": None})


class GridTest(unittest.TestCase):
    def grid(self, pixels):
        states = {254: 1, 0: 2, 205: 0}
        cells = np.vectorize(states.get)(pixels).astype(np.uint8)
        return Grid(cells, 0.1, -3.0, -2.0)

    def test_one_cell_off_is_right_two_are_wrong(self):
        plan = self.grid(fake_site.room_pixels())
        shifts = {0.1: 100, 0.25: 0}
        for shift_m, expected in shifts.items():
            pixels = np.full((40, 60), 205, dtype=np.uint8)
            pixels[8:-2, 0] = 0  # only the left wall is seen
            moved_grid = Similarity(1.0, np.eye(3), np.array([shift_m, 0, 0]))
            figures = compare_with_plan(self.grid(pixels), plan, moved_grid)
            self.assertEqual(figures["occupied_right_percent"], expected)
            self.assertIsNone(figures["free_right_percent"])

    def test_indices_invert_centres(self):
        grid = self.grid(fake_site.room_pixels())
        grid.origin_yaw_rad = 0.7
        rows, columns = grid.indices(grid.centres_m().reshape(-1, 2))
        np.testing.assert_array_equal(rows, np.repeat(np.arange(40), 60))
        np.testing.assert_array_equal(columns, np.tile(np.arange(60), 40))

    def test_unseen_plan_and_outside_are_wrong(self):
        plan = self.grid(np.full((40, 60), 205, dtype=np.uint8))
        figures = compare_with_plan(self.grid(fake_site.room_pixels()), plan, IDENTITY)
        self.assertEqual(figures["seen_right_percent"], 0)

    def test_read_write_and_truncated(self):
        with tempfile.TemporaryDirectory() as folder:
            fake_site.write_map(Path(folder), "map", fake_site.room_pixels())
            grid = read_grid(Path(folder) / "map.yaml")
            np.testing.assert_array_equal(grid.cells, self.grid(fake_site.room_pixels()).cells)
            image = Path(folder) / "map.pgm"
            image.write_bytes(image.read_bytes()[:-1])
            with self.assertRaisesRegex(DataError, "map.pgm"):
                read_pgm(image)


class SurfaceTest(unittest.TestCase):
    VERTICES = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])

    def test_distance_to_face_edge_and_corner(self):
        points = np.array([[0.2, 0.2, 0.5], [0.5, -0.3, 0], [-3, -4, 0], [0.1, 0.1, 0]])
        found = distances_m(points, self.VERTICES, np.array([[0, 1, 2]]))
        np.testing.assert_allclose(found, [0.5, 0.3, 5, 0], atol=1e-12)

    def test_pruning_changes_nothing(self):
        random = np.random.default_rng(1)
        vertices, points = random.normal(size=(60, 3)), random.normal(size=(50, 3))
        triangles = np.arange(60).reshape(-1, 3)
        each = [distances_m(points, vertices, triangle[None]) for triangle in triangles]
        np.testing.assert_allclose(distances_m(points, vertices, triangles), np.min(each, axis=0))

    def test_distance_is_not_above_that_to_any_point_of_the_triangle(self):
        random = np.random.default_rng(2)
        for _ in range(20):
            corners, points = random.normal(size=(3, 3)), random.normal(size=(30, 3))
            weights = random.dirichlet([1, 1, 1], size=4000)
            near = np.linalg.norm(points[:, None] - weights @ corners, axis=2).min(axis=1)
            found = distances_m(points, corners, np.array([[0, 1, 2]]))
            self.assertTrue(np.all(found <= near + 1e-12))
            self.assertTrue(np.all(found >= near - 0.2))

    def test_reads_meshes(self):
        header = (
            b"ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
            b"property float z\nproperty uchar red\nelement face 1\n"
            b"property list uchar int vertex_indices\nend_header\n"
        )
        rows = b"".join(struct.pack("<fffB", *vertex, 9) for vertex in self.VERTICES)
        binary = header + rows + struct.pack("<B3i", 3, 0, 1, 2)
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "m.ply"
            path.write_bytes(binary)
            vertices, triangles = read_ply(path)
            np.testing.assert_array_equal(vertices, self.VERTICES)
            np.testing.assert_array_equal(triangles, [[0, 1, 2]])
            path.write_bytes(binary[:-1])
            with self.assertRaisesRegex(DataError, "truncated"):
                read_ply(path)


if __name__ == "__main__":
    unittest.main()
