# SPDX-License-Identifier: Apache-2.0
"""evaluate.py and report.py on a site with a laser and without a camera: exact figures, and no section of a camera."""

import json
import re
import unittest
from types import SimpleNamespace

import numpy as np

import fake_site
import laser_site
from fake_site import rotation_about, write_tum
from folder_case import FolderTest
from nightmap_eval.laser import laser_accuracy
from nightmap_eval.ways import loop_ends
from nightmap_eval.sealed_hdf5 import sealed
from nightmap_eval.trajectory import Trajectory, interpolated, planar_umeyama, quaternion
from nightmap_site.script_errors import DataError
from nightmap_site.site import Site


class LaserSiteTest(laser_site.LaserFolderTest):
    def laser(self):
        return self.metrics()["sections"]["grid"]

    def write_estimate(self, estimate):
        write_tum(self.site_dir / "map_frame" / "trajectory.tum", estimate)

    def test_a_perfect_map_has_no_error(self):
        laser_site.write_site(self.site_dir)
        metrics = self.metrics()
        self.assertTrue(metrics["has_ground_truth"])
        self.assertNotIn("coverage", metrics)
        laser = metrics["sections"]["grid"]
        self.assertEqual((laser["num_scans"], laser["num_scans_with_pose"], laser["num_keyscans"]), (401, 401, 41))
        self.assertAlmostEqual(laser["path_length_m"], 12 * np.pi, places=2)
        trajectory = laser["trajectory"]
        for name in ("se3", "sim3"):
            self.assertLess(trajectory[name]["ate_max_m"], 1e-6)
        self.assertAlmostEqual(trajectory["sim3"]["scale"], 1, places=6)
        self.assertEqual(trajectory["num_missing"], 0)
        for name in ("relative_1m", "relative_10m"):
            self.assertLess(trajectory[name]["translation_max_m"], 1e-6)
            self.assertEqual(trajectory[name]["num_missing"], 0)
        expected = quaternion(rotation_about([0, 0, 1], laser_site.TRUTH_FROM_MAP_YAW_RAD))
        np.testing.assert_allclose(trajectory["truth_from_map_m_q"], [*laser_site.TRUTH_FROM_MAP_M, *expected], atol=1e-6)

    def test_a_map_that_is_too_large_shows_in_scale_and_stretches(self):
        estimate = laser_site.write_site(self.site_dir)
        estimate.positions_m *= 1.02
        self.write_estimate(estimate)
        trajectory = self.laser()["trajectory"]
        self.assertAlmostEqual(trajectory["sim3"]["scale"], 1 / 1.02, places=6)
        self.assertLess(trajectory["sim3"]["ate_max_m"], 1e-6)
        self.assertGreater(trajectory["se3"]["ate_rmse_m"], 0.02)
        # The chord of a stretch is 2 % too long: a metre of the circle is 11 steps of 3 pi / 200 rad.
        chord_m = 4 * np.sin(11 * 3 * np.pi / 400)
        far = trajectory["relative_1m"]
        for kind in ("mean", "median", "p90", "max"):
            self.assertAlmostEqual(far[f"translation_{kind}_m"], 0.02 * chord_m, places=6)
        self.assertLess(far["rotation_max_deg"], 1e-4)
        self.assertEqual(far["num_pairs"], 401 - 11)

    def test_one_turned_pose_is_in_two_stretches(self):
        estimate = laser_site.write_site(self.site_dir)
        turned = rotation_about([0, 0, 1], np.radians(3)) @ estimate.rotations()[200]
        estimate.quaternions[200] = quaternion(turned)
        self.write_estimate(estimate)
        far = self.laser()["trajectory"]["relative_10m"]
        self.assertAlmostEqual(far["rotation_max_deg"], 3, places=4)
        self.assertAlmostEqual(far["rotation_mean_deg"], 2 * 3 / far["num_pairs"], places=4)
        self.assertLess(far["rotation_p90_deg"], 1e-4)

    def test_scans_without_a_pose_are_failures(self):
        estimate = laser_site.write_site(self.site_dir)
        self.write_estimate(estimate.select([i for i in range(401) if i not in (100, 300)]))
        laser = self.laser()
        self.assertEqual((laser["num_scans"], laser["num_scans_without_pose"]), (401, 2))
        trajectory = laser["trajectory"]
        self.assertEqual((trajectory["num_scans_with_truth"], trajectory["num_missing"]), (401, 2))
        self.assertAlmostEqual(trajectory["missing_percent"], 200 / 401, places=6)
        near = trajectory["relative_1m"]
        self.assertEqual((near["num_pairs"], near["num_missing"]), (390 - 4, 4))

    def test_truth_at_other_times_is_interpolated(self):
        laser_site.write_site(self.site_dir)
        truth = laser_site.drive()
        write_tum(self.site_dir / "frames" / "robot_truth.tum", truth.select(range(0, 401, 3)))
        trajectory = self.laser()["trajectory"]
        self.assertEqual(trajectory["num_scans_with_truth"], 400)  # the last scan is after the last true pose
        # The chord of three steps leaves the circle by 2 m * (1 - cos(1.5 steps)).
        self.assertLess(trajectory["se3"]["ate_max_m"], 2 * (1 - np.cos(1.5 * 6 * np.pi / 400)) + 1e-3)
        write_tum(self.site_dir / "frames" / "robot_truth.tum", truth.select(range(0, 401, 8)))  # 0.8 s apart: too far
        self.assertEqual(self.laser()["trajectory"]["num_scans_with_truth"], 51)

    def test_truth_of_another_clock_is_refused(self):
        laser_site.write_site(self.site_dir)
        truth = laser_site.drive()
        truth.times_ns += 10**15
        write_tum(self.site_dir / "frames" / "robot_truth.tum", truth)
        self.check_refused("evaluate.py", r"check \[robot_truth\]")

    def test_the_summary_says_the_errors_or_that_there_is_no_truth(self):
        laser_site.write_site(self.site_dir)
        evaluate = ("evaluate.py", "evaluate/metrics.json")
        self.assertRegex(self.run_script(*evaluate).stdout, r"hall: ATE RMSE 0\.00 cm, 0\.00 deg .*; over 10 m 0\.00 cm, 0\.000 deg")
        (self.site_dir / "frames" / "robot_truth.tum").unlink()
        self.assertIn("no ground truth", self.run_script(*evaluate).stdout)
        metrics = self.metrics()
        self.assertFalse(metrics["has_ground_truth"])
        self.assertNotIn("trajectory", metrics["sections"]["grid"])

    def test_relations_of_the_site_are_measured(self):
        laser_site.write_site(self.site_dir)
        # After half a round the robot is 4 m to its left and looks back. The relation says 4.1 m.
        half_s = 1 + 0.1 * 400 / 6
        relations = f"1 {half_s:.9f} 0 4.1 0 0 0 {np.pi}\n1 500 0 0 0 0 0 0\n"
        (self.site_dir / "frames" / "relations.txt").write_text(relations)
        figures = self.laser()["relations"]
        self.assertEqual((figures["num_relations"], figures["num_missing"]), (2, 1))
        self.assertAlmostEqual(figures["translation_mean_m"], 0.1, places=3)
        self.assertIsNone(figures["translation_std_m"])

    def test_the_grid_is_compared_with_an_exact_plan(self):
        laser_site.write_site(self.site_dir)
        fake_site.write_map(self.folder / "built" / "truth", "floor_plan", fake_site.room_pixels())
        # The grid is the plan, seen from the map frame.
        yaw = -laser_site.TRUTH_FROM_MAP_YAW_RAD
        x, y = rotation_about([0, 0, 1], yaw)[:2, :2] @ (np.array([-3, -2]) - laser_site.TRUTH_FROM_MAP_M[:2])
        self.replace("grid/map.yaml", "[-3.0, -2.0, 0]", f"[{x}, {y}, {yaw}]")
        self.write("config/site/hall.toml", 'root = "built"\n')
        self.assertEqual(self.laser()["map"]["grid"]["seen_right_percent"], 100)
        self.assertIn("Against the exact building", self.report())

    def test_the_page_has_the_sections_of_a_laser_and_none_of_a_camera(self):
        laser_site.write_site(self.site_dir)
        (self.site_dir / "frames" / "relations.txt").write_text("1 2 0 0 0 0 0 0\n1.5 3 0 0 0 0 0 0\n")
        self.metrics()
        page = self.report()
        titles = re.findall(r"<summary><h2>([^<]*)</h2>", page)
        self.assertEqual(titles, ["The map in space", "Path", "Accuracy of the laser map", "Position error", "Objects", "Time and memory", "Loops",
                                  "Skipped items", "Configs", "Files"])  # fmt: skip
        self.assertIn("<dt>scans mapped</dt><dd>401 of 401 over 37.7 m</dd>", page)
        self.assertIn("Squared rotation (deg2)", page)
        self.assertEqual(self.report(), page)

    def test_the_page_without_truth_says_so_and_has_no_errors(self):
        laser_site.write_site(self.site_dir, truth=False)
        self.metrics()
        page = self.report()
        self.assertIn("true way is not known", page)
        self.assertNotIn("Position error", page)
        (self.site_dir / "map_frame" / "trajectory.tum").unlink()
        self.assertIn("map_frame stage did not run", self.report())

    def test_loops_are_drawn_at_the_poses_that_they_number(self):
        estimate = laser_site.write_site(self.site_dir)
        [accepted], [rejected] = loop_ends(Site(self.site_dir), estimate)
        np.testing.assert_allclose(accepted, estimate.positions_m[[0, 133]], atol=1e-6)
        np.testing.assert_allclose(rejected, estimate.positions_m[[5, 300]], atol=1e-6)
        kept = estimate.select([i for i in range(401) if i != 300])  # a loop of a pose that the map has not is not drawn
        self.assertEqual(list(map(len, loop_ends(Site(self.site_dir), kept))), [1, 0])
        (self.site_dir / "pose_graph" / "loops.csv").write_text("frame_a,frame_b,status,reason\n0,401,accepted,\n")
        self.check_refused("report.py", "loops.csv:2: joins 0 and 401, one of which the site has not")

    def test_damaged_figures_are_named(self):
        laser_site.write_site(self.site_dir)
        self.metrics()
        path = self.site_dir / "evaluate" / "metrics.json"
        whole = json.loads(path.read_text())
        for change, name in (({"num_scans": "many"}, "num_scans"), ({"trajectory": {}}, "trajectory"),
                             ({"walls": {"doubled_percent": "x"}}, "doubled_percent")):  # fmt: skip
            figures = whole["sections"]["grid"] | change
            path.write_text(json.dumps(whole | {"sections": {"grid": figures}}))
            self.check_refused("report.py", f"metrics.json: sections.*{name}")


class LoopsOfKeyscansTest(FolderTest):
    """Three rounds: a scan of the second and third round sees what the one 133 1/3 scans before saw."""

    def setUp(self):
        self.truth = laser_site.drive()
        self.nodes = self.truth.select(range(0, 401, 10))  # keyscans
        write_tum(self.folder / "pose_graph_trajectory", self.nodes)
        write_tum(self.folder / "truth.tum", self.truth)
        self.site = SimpleNamespace(path=self.file_of, needed=self.file_of, robot_truth=self.folder / "truth.tum")

    def file_of(self, job, output):
        return self.folder / f"{job}_{output}"

    def relative(self, a, b, error_m=0.0, error_deg=0.0):
        """The pose of node a seen from node b, with an error."""
        rotations, positions_m = self.nodes.rotations(), self.nodes.positions_m
        turn = rotation_about([0, 0, 1], np.radians(error_deg))
        return turn @ rotations[b].T @ rotations[a], rotations[b].T @ (positions_m[a] - positions_m[b]) + [error_m, 0, 0]

    def write_loops(self, *loops):
        """(node a, node b, status, error_m, error_deg)"""
        poses = [self.relative(a, b, *errors) for a, b, _, *errors in loops]
        with sealed(self.folder / "loops_edges") as file:
            file["time_ns"] = np.array([self.nodes.times_ns[[a, b]] for a, b, *_ in loops])
            file["target_from_source"] = np.array([[*t, *quaternion(r)] for r, t in poses])
        rows = "".join(f"{a},{b},{status},{'' if status == 'accepted' else 'inconsistent'}\n" for a, b, status, *_ in loops)
        (self.folder / "pose_graph_loops_csv").write_text("frame_a,frame_b,status,reason\n" + rows)

    def figures(self, *loops):
        self.write_loops(*loops)
        return laser_accuracy.loops_of_keyscans(self.site)

    def test_edges_are_between_nodes_of_their_times(self):
        self.write_loops((0, 27, "accepted"), (40, 13, "accepted"))
        measured = laser_accuracy.measured_loops(self.folder / "loops_edges", self.nodes.times_ns)
        self.assertEqual(set(measured), {(0, 27), (40, 13)})
        for (a, b), (rotation, translation) in measured.items():
            expected = self.relative(a, b)
            np.testing.assert_allclose(rotation, expected[0], atol=1e-9)
            np.testing.assert_allclose(translation, expected[1], atol=1e-9)

    def test_a_loop_that_ends_at_no_node_is_an_error(self):
        self.write_loops((0, 27, "accepted"))
        for times_ns in (self.nodes.times_ns + 1, self.nodes.times_ns[:20]):
            with self.assertRaisesRegex(DataError, "loops_edges: a loop ends where"):
                laser_accuracy.measured_loops(self.folder / "loops_edges", times_ns)

    def test_a_false_loop_is_counted(self):
        good = [(0, 27, "accepted"), (1, 27, "accepted", 0.4), (3, 30, "accepted", 0, 9)]
        figures = self.figures(*good)
        self.assertEqual((figures["num_accepted"], figures["num_false_accepted"]), (3, 0))
        figures = self.figures(*good, (5, 32, "accepted", 0.6), (6, 33, "accepted", 0, 11), (7, 34, "rejected", 3))
        self.assertEqual((figures["num_accepted"], figures["num_rejected"], figures["num_false_accepted"]), (5, 1, 2))
        self.assertEqual(figures["rejected_by_reason"], {"inconsistent": 1})

    def test_revisits_are_those_of_the_later_rounds(self):
        closed = self.figures(*[(a, a + 13, "accepted") for a in range(0, 28, 3)])
        self.assertGreater(closed["num_revisiting_frames"], 20)
        self.assertEqual(closed["revisits_closed_percent"], 100)
        self.assertEqual(self.figures((0, 13, "accepted", 2))["revisits_closed_percent"], 0)

    def test_without_truth_loops_are_counted_alone(self):
        (self.folder / "truth.tum").unlink()
        figures = self.figures((0, 27, "accepted", 5), (7, 34, "rejected"))
        self.assertEqual(figures, {"num_accepted": 1, "num_rejected": 1, "rejected_by_reason": {"inconsistent": 1}})

    def test_a_loop_of_a_node_without_truth_is_not_judged(self):
        write_tum(self.folder / "truth.tum", self.truth.select(range(100, 401)))
        figures = self.figures((0, 27, "accepted", 5), (12, 26, "accepted"))
        self.assertEqual((figures["num_accepted"], figures["num_false_accepted"]), (2, 0))

    def test_a_loop_that_no_job_found_is_named(self):
        self.write_loops((0, 27, "accepted"))
        (self.folder / "pose_graph_loops_csv").write_text("frame_a,frame_b,status,reason\n1,27,accepted,\n")
        with self.assertRaisesRegex(DataError, "names frames 1 and 27"):
            laser_accuracy.loops_of_keyscans(self.site)


class InterpolatedTest(unittest.TestCase):
    def setUp(self):
        quaternions = np.array([quaternion(rotation_about([0, 0, 1], a)) for a in (0.0, 1.0, 1.0)])
        self.poses = Trajectory(np.array([0, 10**9, 3 * 10**9]), np.array([[0.0, 0, 0], [1, 2, 0], [5, 2, 0]]), quaternions)

    def test_between_two_poses(self):
        rows, poses = interpolated(self.poses, [250_000_000, 10**9], 10**9)
        np.testing.assert_array_equal(rows, [0, 1])
        np.testing.assert_allclose(poses.positions_m, [[0.25, 0.5, 0], [1, 2, 0]])
        np.testing.assert_allclose(poses.rotations()[0], rotation_about([0, 0, 1], 0.25), atol=1e-12)

    def test_the_short_way_round(self):
        self.poses.quaternions[1] *= -1
        _, poses = interpolated(self.poses, [500_000_000], 10**9)
        np.testing.assert_allclose(poses.rotations()[0], rotation_about([0, 0, 1], 0.5), atol=1e-12)

    def test_no_pose_outside_or_in_a_long_gap_but_at_its_ends(self):
        times_ns = [-2_000_000, -500_000, 2 * 10**9, 3 * 10**9 - 500_000, 3 * 10**9 + 500_000, 3 * 10**9 + 2_000_000]
        rows, poses = interpolated(self.poses, times_ns, 10**9)
        np.testing.assert_array_equal(rows, [1, 3, 4])
        np.testing.assert_allclose(poses.positions_m[:, 0], [0, 5, 5])
        self.assertEqual(len(interpolated(self.poses.select([]), times_ns, 10**9)[0]), 0)
        self.assertEqual(len(interpolated(self.poses, [], 10**9)[0]), 0)


class PlanarAlignmentTest(unittest.TestCase):
    def test_recovers_a_turn_a_move_and_a_scale(self):
        random = np.random.default_rng(1)
        for num in (2, 3, 20):
            source = random.normal(size=(num, 3)) * [1, 1, 0]
            for yaw in (0.0, 0.5, 2.0, np.pi, -1.0):
                rotation = rotation_about([0, 0, 1], yaw)
                found = planar_umeyama(source, 1.5 * source @ rotation.T + [3, -1, 0.2], with_scale=True)
                self.assertAlmostEqual(found.scale, 1.5)
                np.testing.assert_allclose(found.rotation, rotation, atol=1e-9)
                np.testing.assert_allclose(found.translation_m, [3, -1, 0.2], atol=1e-9)

    def test_a_mirrored_path_does_not_fit(self):
        source = np.random.default_rng(2).normal(size=(30, 3)) * [1, 1, 0]
        mirrored = source * [1, -1, 1]
        errors_m = planar_umeyama(source, mirrored, with_scale=False).apply(source) - mirrored
        self.assertGreater(np.sqrt(np.mean(errors_m**2)), 0.3)

    def test_places_that_are_all_the_same_are_refused(self):
        for points in (np.zeros((5, 3)), np.full((3, 3), np.nan), np.zeros((1, 3))):
            with self.assertRaises(DataError):
                planar_umeyama(points, points, with_scale=False)
