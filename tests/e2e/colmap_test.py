# SPDX-License-Identifier: Apache-2.0
"""A real COLMAP: it opens the exported map and agrees on its error, and the comparison runs with it."""
import json
import re
import shutil
import sqlite3
import tempfile
import unittest
from pathlib import Path

import numpy as np

from workspace import RECORDING, SITE, Workspace, said_by


FEW = "frames.max_frames=20"  # COLMAP matches every pair: more would take minutes


def colmap(*arguments):
    return said_by(["colmap", *arguments])


def numbers(path):
    """Words of the lines that are no remark; empty lines count, an image may have no keypoints."""
    return [line.split() for line in path.read_text().splitlines() if not line.startswith("#")]


def reprojection_errors_px(folder):
    """Point -> errors of its observations, from the text model of a pinhole camera, by COLMAP's rules."""
    _, model, _, _, fx, fy, cx, cy = numbers(folder / "cameras.txt")[0]
    assert model == "PINHOLE"
    points = {words[0]: np.array(words[1:4], float) for words in numbers(folder / "points3D.txt")}
    lines, errors = numbers(folder / "images.txt"), {}
    for head, keypoints in zip(lines[::2], lines[1::2]):
        w, x, y, z, *translation = map(float, head[1:8])
        rotation = np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                             [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                             [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])
        for px, py, point in zip(keypoints[::3], keypoints[1::3], keypoints[2::3]):
            if point != "-1":
                p = rotation @ points[point] + translation
                seen = float(fx) * p[0] / p[2] + float(cx), float(fy) * p[1] / p[2] + float(cy)
                error_px = np.hypot(seen[0] - float(px), seen[1] - float(py))
                errors.setdefault(point, []).append(error_px)
    return errors


class ColmapTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.work = Workspace.made(RECORDING).removed_after(cls)
        cls.output = cls.work.output("evaluate-colmap", f"SET={FEW}")
        cls.report = json.loads(cls.work.path("landmarks/report.json").read_text())
        cls.results = json.loads(cls.work.path("evaluate_colmap/results.json").read_text())

    def setUp(self):
        self.folder = Path(self.enterContext(tempfile.TemporaryDirectory()))

    def copy_model(self, suffix):
        folder = self.folder / suffix
        folder.mkdir()
        for path in self.work.path("landmarks/colmap").glob(f"*.{suffix}"):
            shutil.copy(path, folder)
        return folder

    def test_model_analyzer_confirms_counts_and_error_of_both_forms(self):
        for suffix in ("txt", "bin"):
            with self.subTest(suffix):
                output = colmap("model_analyzer", "--path", self.copy_model(suffix))
                for title, key in (("Points", "num_colmap_points"), ("Registered images", "num_observers")):
                    self.assertEqual(int(re.search(rf"^{title}: (\d+)", output, re.M).group(1)), self.report[key])
                self.assertLessEqual(self.report["num_colmap_points"], self.report["num_landmarks"])
                self.assertIs(self.report["colmap_names_usable"], True)
                error_px = float(re.search(r"Mean reprojection error: ([\d.]+)px", output).group(1))
                self.assertAlmostEqual(error_px, self.report["mean_reprojection_error_px"], places=5)

    def test_the_error_is_that_of_the_geometry(self):
        """model_analyzer averages what the points say of themselves: here it is computed anew."""
        errors_px = reprojection_errors_px(self.copy_model("txt"))
        mean_px = np.mean([np.mean(values) for values in errors_px.values()])
        self.assertAlmostEqual(mean_px, self.report["mean_reprojection_error_px"], places=4)

    def test_colmap_takes_the_same_error_from_the_geometry(self):
        """Its bundle adjustment prints the root mean square over both axes before the first step."""
        squares = [error**2 for errors in reprojection_errors_px(self.copy_model("txt")).values() for error in errors]
        (self.folder / "out").mkdir()
        output = colmap("bundle_adjuster", "--input_path", self.copy_model("bin"), "--output_path", self.folder / "out",
                        "--BundleAdjustment.max_num_iterations", 1)
        initial_px = float(re.search(r"Initial cost : ([\d.]+) \[px\]", output).group(1))
        self.assertAlmostEqual(initial_px, np.sqrt(np.sum(squares) / (2 * len(squares))) / np.sqrt(2), places=3)

    def test_colmap_triangulates_from_the_database(self):
        database = shutil.copy(self.work.path("landmarks/colmap/database.db"), self.folder)
        (self.folder / "out").mkdir()
        colmap("point_triangulator", "--database_path", database, "--image_path", self.work.folder / "data",
               "--input_path", self.copy_model("bin"), "--output_path", self.folder / "out", "--clear_points", 1)
        output = colmap("model_analyzer", "--path", self.folder / "out")
        self.assertGreater(int(re.search(r"^Points: (\d+)", output, re.M).group(1)), self.report["num_observers"])

    def test_database_has_the_features_of_the_map(self):
        connection = sqlite3.connect(self.work.path("landmarks/colmap/database.db"))
        self.addCleanup(connection.close)
        images = dict(connection.execute("SELECT image_id, name FROM images"))
        self.assertEqual(len(images), self.report["num_observers"])
        for name in images.values():
            self.assertTrue((self.work.folder / "data" / name).exists())
        for table in ("keypoints", "descriptors"):
            (count,) = connection.execute(f"SELECT COUNT(*) FROM {table}").fetchone()
            self.assertEqual(count, self.report["num_observers"], table)
        for rows, size in connection.execute("SELECT rows, length(data) FROM descriptors"):
            self.assertEqual(size, 128 * rows)

    def test_the_export_is_a_part_of_its_own(self):
        receipt = json.loads(self.work.path("landmarks/receipt.json").read_text())
        times_s = {part["name"]: part["wall_time_s"] for part in receipt["parts"]}
        self.assertGreater(times_s["export"], 0)
        counted_s = self.results["methods"]["nightmap"]["map_parts_s"]["landmarks"]
        self.assertAlmostEqual(counted_s, receipt["wall_time_s"] - times_s["export"], places=6)

    def assert_located(self, name):
        figures = self.results["methods"][name]
        self.assertEqual(figures["failed"], "")
        self.assertGreaterEqual(figures["num_located"], figures["num_queries"] / 2)
        self.assertEqual(figures["against"]["truth"]["local"]["num_wrong"], 0)

    def test_queries_are_located_in_the_map_and_in_colmaps_points_at_its_poses(self):
        self.assert_located("nightmap")
        self.assert_located("colmap_triangulate")
        self.assert_located("colmap_held")
        self.assertIn("exhaustive", " ".join(self.results["setting"]))
        self.assertIn("| located |", self.output)

    def test_a_query_is_timed_in_phases_and_so_few_frames_need_no_retrieval(self):
        phases_s = self.results["methods"]["colmap_triangulate"]["query_phases_s"]
        self.assertEqual(list(phases_s), ["features", "search", "registration", "adjustment"])
        self.assertGreater(min(phases_s.values()), 0)
        self.assertEqual(self.results["methods"]["colmap_held"]["query_phases_s"]["adjustment"], "in registration")
        self.assertEqual([name for name in self.results["methods"] if "default" in name], [])

    def test_colmaps_own_map_is_used_where_it_fits_and_reported_where_it_does_not(self):
        """COLMAP 3.8 draws other samples each time it runs. About one in four of its maps of these
        frames is wrong. (comparison_test makes such models to measure.)"""
        figures = self.results["methods"]["colmap_mapper"]
        self.assertEqual([run["map"] for run in figures["runs"]], ["mapper_1", "mapper_2", "mapper_3"])
        counts = sorted(run["num_located"] for run in figures["runs"])
        self.assertLessEqual(counts[0], figures["num_located"])
        self.assertLessEqual(figures["num_located"], counts[2])
        self.assertGreater(len(figures["models"]), 0)
        if any(model["fits"] for model in figures["models"]):
            self.assert_located("colmap_mapper")
            return
        self.assertEqual((figures["failed"], figures["num_located"]), ("no model fits the metric map", 0))
        for model in figures["models"]:
            self.assertRegex(model["reason"], "^wrong: [0-9]+ % of its map cameras")

    def test_nothing_is_repeated_and_the_report_shows_it(self):
        self.assertEqual(self.work.make("-q", "evaluate-colmap", f"SET={FEW}").returncode, 0)
        receipts = {path: path.stat().st_mtime_ns for path in self.work.path("evaluate_colmap").glob("*/receipt.json")}
        self.work.output("report", f"SET={FEW}")
        self.assertIn("Comparison with COLMAP", self.work.path("report/index.html").read_text())
        # A corrected truth is compared anew.
        truth = self.work.path("queries/query_ground_truth.tum")
        truth.write_text(truth.read_text() + "# corrected\n")
        self.assertEqual(self.work.make("-q", "evaluate-colmap", f"SET={FEW}").returncode, 1)
        # A changed way of locating leaves COLMAP's work as it is.
        said = self.work.output("evaluate-colmap", f"SET={FEW} localize.max_error_px=4.5")
        self.assertEqual(receipts, {path: path.stat().st_mtime_ns for path in receipts})
        self.assertIn(SITE, said)
