# SPDX-License-Identifier: Apache-2.0
"""evaluate.py and report.py on a site of the profile `ceiling`: known errors give these errors, and what is missing is said."""

import json
import re

import numpy as np

import ceiling_site
from fake_site import write_tum
from folder_case import SiteFolderTest
from nightmap_eval.planar_poses import to_trajectory


class CeilingSiteTest(SiteFolderTest):
    SITE = "hall"

    def setUp(self):
        self.estimate = ceiling_site.write_site(self.site_dir, self.folder)

    def figures(self, job="odometry"):
        return self.metrics()["sections"][job]

    def write_map(self, **changes):
        ceiling_site.write_ceiling_map(self.site_dir, ceiling_site.map_arrays() | changes)

    def test_a_perfect_map_has_no_error(self):
        figures = self.figures()
        for alignment in ("start", "se3", "sim3"):
            self.assertLess(figures["trajectory"][alignment]["ate_max_m"], 1e-6)
            self.assertLess(figures["trajectory"][alignment]["rotation_max_deg"], 1e-5)
            self.assertLess(figures["landmarks"][alignment]["error_max_m"], 1e-5)
        self.assertEqual(figures["trajectory"]["num_missing"], 0)
        self.assertEqual(figures["landmarks"]["num_judged"], 12)
        self.assertEqual(figures["landmarks"]["start"]["inside_percent"], 100)

    def test_frames_and_parts_of_the_map_are_counted(self):
        figures = self.figures()
        names = ("landmarks", "anchors", "loops", "frames_with_slipping_wheels", "frames_without_odometry", "frames_without_landmark")
        self.assertEqual([figures[f"num_{name}"] for name in names], [12, 3, 1, 3, 1, 3])
        self.assertEqual((figures["coverage"]["num_frames"], figures["coverage"]["num_frames_with_pose"]), (60, 60))
        self.assertEqual(figures["nis"]["num_frames"], 57)
        self.assertAlmostEqual(figures["nis"]["mean_per_degree_of_freedom"], 1)
        self.assertEqual(figures["nis"]["within_percent"], 100)

    def test_an_offset_of_3_and_4_cm_is_an_error_of_5_cm(self):
        self.estimate[1:, :2] += [0.03, 0.04]
        ceiling_site.write_estimate(self.site_dir, self.estimate)
        trajectory = self.figures()["trajectory"]
        for kind in ("median", "max"):
            self.assertAlmostEqual(trajectory["start"][f"ate_{kind}_m"], 0.05, places=6)
        self.assertAlmostEqual(trajectory["start"]["ate_rmse_m"], 0.05 * np.sqrt(59 / 60), places=6)
        self.assertLess(trajectory["se3"]["ate_median_m"], 0.002)

    def test_a_turned_way_has_the_turn_as_its_heading_error(self):
        self.estimate[1:, 2] += np.radians(2)
        ceiling_site.write_estimate(self.site_dir, self.estimate)
        start = self.figures()["trajectory"]["start"]
        self.assertAlmostEqual(start["rotation_max_deg"], 2, places=5)
        self.assertLess(start["ate_max_m"], 1e-6)

    def test_a_map_that_is_too_large_shows_in_the_scale(self):
        self.estimate[:, :2] *= 1.01
        ceiling_site.write_estimate(self.site_dir, self.estimate)
        trajectory = self.figures()["trajectory"]
        self.assertAlmostEqual(trajectory["sim3"]["scale"], 1 / 1.01, places=6)
        self.assertLess(trajectory["sim3"]["ate_max_m"], 1e-6)
        self.assertGreater(trajectory["start"]["ate_max_m"], 0.03)

    def test_frames_without_an_estimate_are_missing(self):
        for job in ("odometry", "adjust"):
            ceiling_site.write_estimate(self.site_dir, self.estimate, slice(0, 54), job)
        figures = self.figures()
        self.assertEqual((figures["trajectory"]["num_frames_with_truth"], figures["trajectory"]["num_missing"]), (60, 6))
        self.assertEqual(figures["coverage"]["frames_without_pose"], list(range(54, 60)))
        self.assertIn("<dd>54 of 60 over", self.report())

    def test_the_wheels_alone_are_compared(self):
        drifting, worse = self.estimate.copy(), ceiling_site.drive()
        drifting[1:, 0] += 0.01
        worse[1:, 0] += 0.1
        ceiling_site.write_estimate(self.site_dir, drifting)
        ceiling_site.write_wheels(self.site_dir, worse)
        wheels = self.figures()["wheels"]
        self.assertAlmostEqual(wheels["position_ratio_start"], 10, places=4)
        self.assertAlmostEqual(wheels["start"]["ate_max_m"], 0.1, places=6)
        self.assertNotIn("heading_ratio_sim3", wheels)
        ceiling_site.write_wheels(self.site_dir, worse[:40])
        self.assertEqual(self.figures()["wheels"]["num_missing"], 20)

    def test_the_wheels_are_those_of_the_sensor_that_was_used(self):
        wrong, right = ceiling_site.drive(), ceiling_site.drive()
        wrong[1:, 0] += 1
        ceiling_site.write_wheels(self.site_dir, wrong, right)
        self.assertAlmostEqual(self.figures()["wheels"]["start"]["ate_max_m"], 1, places=6)
        report = self.write("odometry/report.json", '{"odometry_sensor": "wheels_1"}')
        self.assertLess(self.figures()["wheels"]["start"]["ate_max_m"], 1e-6)
        report.write_text('{"odometry_sensor": "legs"}')
        self.check_refused("evaluate.py", "odometry.h5: damaged")

    def test_a_landmark_2_cm_off_is_2_cm_off(self):
        points_m = ceiling_site.map_arrays()["landmark_position_m"]
        points_m[4] += [0, 0, 0.02]
        points_m[7] += [0.04, 0, 0]  # 4 sigma: outside
        self.write_map(landmark_position_m=points_m)
        start = self.figures()["landmarks"]["start"]
        self.assertAlmostEqual(start["error_max_m"], 0.04, places=5)
        self.assertAlmostEqual(start["inside_percent"], 100 * 11 / 12, places=6)
        self.write_map(landmark_position_m=points_m[:5], **{
            name: ceiling_site.map_arrays()[name][:5]
            for name in ("landmark_covariance_m2", "landmark_last_time_ns", "landmark_last_raw_px")})  # fmt: skip
        self.assertAlmostEqual(self.figures()["landmarks"]["start"]["error_max_m"], 0.02, places=5)

    def test_a_landmark_at_the_edge_of_a_lintel_is_counted(self):
        arrays = ceiling_site.map_arrays()
        row = int(np.argmin(np.abs(ceiling_site.drive()[::5, 0] - 3.6)[6:])) + 6  # in the first room, on the way to the doorway
        depth_m, way_m = 2.1 - ceiling_site.CAMERA_HEIGHT_M, 4.2 - ceiling_site.drive()[5 * row, 0]
        pixels = arrays["landmark_last_raw_px"].copy()
        pixels[row] = [ceiling_site.CAMERA["cx"] + ceiling_site.CAMERA["fx"] * way_m / depth_m + 0.5, ceiling_site.CAMERA["cy"]]
        self.write_map(landmark_last_raw_px=pixels)
        landmarks = self.figures()["landmarks"]
        self.assertEqual((landmarks["num_judged"], landmarks["num_at_edge"]), (12, 1))
        self.assertGreater(landmarks["start"]["error_max_m"], 0.2)
        self.assertLess(landmarks["start"]["error_max_off_edges_m"], 1e-5)

    def test_covariances_that_are_too_small_are_above_the_bounds(self):
        poses = ceiling_site.map_arrays()["frame_pose"]
        poses[1:31, 1] += 0.05  # 5 sigma: NEES 25
        self.write_map(frame_pose=poses)
        nees = self.figures()["nees"]
        self.assertAlmostEqual(nees["above_percent"], 50)
        self.assertAlmostEqual(nees["mean"], 12.5, places=5)

    def test_the_page_has_map_figures_and_errors(self):
        self.figures()
        page = self.report()
        titles = re.findall(r"<summary><h2>([^<]*)</h2>", page)
        self.assertEqual(titles, ["The map in space", "Map of the ceiling", "Errors of the robot&#x27;s way", "Adjusted map of the ceiling",
                                  "Picture of the ceiling", "Time and memory", "Skipped items", "Configs", "Files"])  # fmt: skip
        self.assertEqual(page.count("<img"), 4)
        for text in ("Scale error of the wheels", "wheels alone, from the first pose on", "NEES of the poses",
                     "Landmarks against the exact ceiling"):  # fmt: skip
            self.assertIn(text, page)
        self.assertEqual(self.report(), page)

    def test_without_truth_there_are_counts_and_a_note(self):
        (self.site_dir / "frames" / "robot_truth.tum").unlink()
        figures = self.figures()
        self.assertEqual(set(figures) & {"trajectory", "nees", "landmarks"}, set())
        self.assertEqual(set(figures["wheels"]), {"path_length_m"})
        page = self.report()
        self.assertIn("true way is not known", page)
        self.assertEqual(page.count("<img"), 2)

    def test_the_adjusted_map_has_figures_of_its_own(self):
        moved = self.estimate.copy()
        moved[1:, :2] += (0.03, 0.04)
        ceiling_site.write_estimate(self.site_dir, moved, job="adjust")
        points_m = ceiling_site.map_arrays()["landmark_position_m"] + [0, 0, 0.02]
        ceiling_site.write_ceiling_map(self.site_dir, ceiling_site.map_arrays() | {"landmark_position_m": points_m}, "adjust")
        figures = self.figures("adjust")
        self.assertAlmostEqual(figures["trajectory"]["start"]["ate_median_m"], 0.05)
        self.assertAlmostEqual(figures["landmarks"]["start"]["error_median_m"], 0.02, places=4)
        self.assertLess(self.figures()["trajectory"]["start"]["ate_max_m"], 1e-6)

    def test_the_mosaic_is_shown_with_its_figures(self):
        self.assertIn("The mosaic stage did not run.", self.report())
        ceiling_site.write_mosaic(self.site_dir)
        page = self.report()
        self.assertEqual(page.count("<img"), 5)
        self.assertRegex(page, r"Ceiling seen \(m2\)</t[dh]><td[^>]*>23\.5")

    def test_a_map_that_was_not_adjusted_says_so(self):
        for name in ("trajectory.tum", "ceiling_map.h5", "report.json"):
            (self.site_dir / "adjust" / name).unlink()
        self.assertIn("The adjust stage did not run.", self.report())

    def test_without_wheels_loops_and_landmarks(self):
        (self.site_dir / "frames" / "odometry.h5").unlink()
        empty = {name: array[:0] for name, array in ceiling_site.map_arrays().items() if name.startswith(("landmark", "loop", "anchor"))}
        self.write_map(**empty)
        figures = self.figures()
        self.assertNotIn("wheels", figures)
        self.assertEqual((figures["num_landmarks"], figures["landmarks"]["num_judged"]), (0, 0))
        self.assertNotIn("wheels / estimate", self.report())

    def test_without_the_exact_ceiling_no_landmark_is_judged(self):
        (self.folder / "built" / "truth" / "ceiling.json").unlink()
        self.assertNotIn("landmarks", self.figures())

    def test_truth_of_another_clock_is_refused(self):
        write_tum(self.site_dir / "frames" / "robot_truth.tum", to_trajectory(ceiling_site.times_ns() + 10**15, ceiling_site.drive()))
        self.check_refused("evaluate.py", r"check \[robot_truth\]")

    def test_a_damaged_map_is_named(self):
        nan = np.full((60, 3), np.nan)
        loop = np.array([[3, 0]])
        for changes in ({"loop_anchors": loop}, {"frame_pose": nan}, {"frame_nis": np.zeros(7)}, {"anchor_pose": np.zeros(6)}):
            self.write_map(**changes)
            self.check_refused("evaluate.py", r"ceiling_map\.h5: ")

    def test_damaged_figures_are_named(self):
        self.figures()
        path = self.site_dir / "evaluate" / "metrics.json"
        whole = json.loads(path.read_text())
        for change, name in (({"num_loops": "many"}, "num_loops"), ({"trajectory": {}}, "trajectory"), ({"coverage": {}}, "path_length_m")):
            figures = whole["sections"]["odometry"] | change
            path.write_text(json.dumps(whole | {"sections": {"odometry": figures}}))
            self.check_refused("report.py", f"metrics.json: sections.*{name}")
