# SPDX-License-Identifier: Apache-2.0
"""bench_night_laser.py: the composed night is one rigid world with the same scans at both visits; rays and scores are exact."""

import csv

from folder_case import FolderTest  # first: it makes scripts and benchmarks importable

import numpy as np
from nightmap_eval.planar_poses import compose, inverse, to_rows, to_trajectory
from nightmap_eval.sealed_hdf5 import sealed
from nightmap_eval.trajectory import quaternion

from night import laser_compose, laser_run, rays

ALL_AROUND_RAD = -np.pi + np.radians(1) * np.arange(360)


def write_signal(path, kind, times_ns, value, ranges_m):
    with sealed(path) as file:
        file.attrs["format"], file.attrs["version"], file.attrs["kind"], file.attrs["sensor_0"] = "nightmap signals", 1, kind, kind
        file["robot_from_sensor"] = np.array([[0, 0, 0, 0, 0, 0, 1.0]])
        file["sample_offset"] = np.array([[0], [len(times_ns)]])
        file["time_ns"], file["value"] = times_ns[:, None], value
        file["range_offset"] = np.arange(len(times_ns) + 1)[:, None] * ranges_m.shape[1]
        file["range_m"] = ranges_m.astype(np.float32).reshape(-1, 1)


class NightTest(FolderTest):
    """A robot drives 3 m through a room of 6 m x 4 m, and its wheels with it."""

    def setUp(self):
        super().setUp()
        poses = np.column_stack([np.arange(1, 4, 0.1), np.full(30, 2.0), np.linspace(0, 0.5, 30)])
        times_ns = 10**9 + 10**8 * np.arange(30)
        headings = poses[:, 2:] + ALL_AROUND_RAD
        with np.errstate(divide="ignore"):
            to_x = np.maximum((6 - poses[:, :1]) / np.cos(headings), -poses[:, :1] / np.cos(headings))
            to_y = np.maximum((4 - poses[:, 1:2]) / np.sin(headings), -poses[:, 1:2] / np.sin(headings))
        (self.folder / "frames").mkdir()
        beams = np.tile([ALL_AROUND_RAD[0], np.radians(1), 30.0], (30, 1))
        write_signal(self.folder / "frames/scans.h5", "scan", times_ns, beams, np.minimum(to_x, to_y))
        write_signal(self.folder / "frames/odometry.h5", "odometry", times_ns, compose(inverse(poses[0]), poses), np.zeros((30, 0)))
        truth = to_trajectory(times_ns, poses)
        lines = [f"{time / 1e9:.9f} {' '.join(map(repr, map(float, (*place, *turn))))}"
                 for time, place, turn in zip(truth.times_ns.tolist(), truth.positions_m, truth.quaternions)]  # fmt: skip
        (self.folder / "frames/robot_truth.tum").write_text("\n".join(lines) + "\n")
        self.composer = laser_compose.Composer(laser_compose.Source(self.folder), 1000)

    def test_both_visits_see_the_same_but_for_noise_and_the_wheels_follow_the_truth(self):
        truth = self.composer.write(self.folder / "night")
        scans, wheels = (laser_compose.Log(self.folder / f"night/frames/{name}.h5") for name in ("scans", "odometry"))
        visit = len(truth) // 2
        self.assertLess(abs(len(truth) - 1000), 200)
        np.testing.assert_allclose(truth.positions_m[:visit], truth.positions_m[visit:])
        apart_m = scans.ranges_m[:visit] - scans.ranges_m[visit:]
        self.assertAlmostEqual(float(np.std(apart_m)), np.sqrt(2) * laser_compose.NOISE_M, delta=0.001)
        steps_m = np.linalg.norm(np.diff(truth.positions_m, axis=0), axis=1)
        self.assertLess(steps_m.max(), 0.13)
        self.assertTrue((np.diff(truth.times_ns) == laser_compose.PERIOD_NS).all() and (np.diff(wheels.time_ns) > 0).all())
        at = np.searchsorted(wheels.time_ns, truth.times_ns[:visit])
        found = compose(inverse(wheels.value[0]), wheels.value[at])
        rows = to_rows(truth)
        turned = rays.wrapped_rad(found[:, 2] - (rows[:visit, 2] - rows[0, 2]))
        self.assertLess(np.abs(turned).max(), 1e-6)
        driven = compose(inverse(rows[0]), rows[:visit])
        self.assertLess(np.linalg.norm(found[:, :2] - driven[:, :2], axis=1).max(), 0.011 * steps_m.sum())

    def test_scans_of_the_tunnel_agree_with_the_rooms_at_its_ends(self):
        for copy, row, frame in ((0, 0, self.composer.end(0)), (0, -1, self.composer.begin(1))):
            tunnel, leg = self.composer.tunnels[copy], self.composer.legs[2 * copy + 1]
            pose = leg.poses[row]
            ranges_m = tunnel.ranges_m(pose[None], ALL_AROUND_RAD)[0]
            hit = np.isfinite(ranges_m)
            angles = pose[2] + ALL_AROUND_RAD[hit]
            hits_m = pose[:2] + ranges_m[hit, None] * np.column_stack([np.cos(angles), np.sin(angles)])
            along_m = tunnel.in_tunnel(hits_m)[:, 0]
            outside = along_m < -0.2 if row == 0 else along_m > tunnel.length_m + 0.2
            self.assertGreater(outside.sum(), 90)
            walls_m = hits_m[outside] - self.composer.offset_m(0 if row == 0 else 1)
            off_m = np.minimum(np.minimum(np.abs(walls_m[:, 0]), np.abs(walls_m[:, 0] - 6)),
                               np.minimum(np.abs(walls_m[:, 1]), np.abs(walls_m[:, 1] - 4)))  # fmt: skip
            self.assertLess(np.median(off_m), 0.02)
            self.assertLess(np.linalg.norm(frame[:2] - pose[:2]), 0.11)


class PartsTest(FolderTest):
    def test_each_place_of_a_ring_is_beside_the_one_before(self):
        for num in (2, 4, 6, 16, 30, 100):
            places = np.array(laser_compose.ring(num))
            self.assertEqual(len({tuple(place) for place in places.tolist()}), num)
            steps = np.abs(np.diff(places, axis=0)).sum(axis=1)
            self.assertLessEqual(steps.max(), 2)
            self.assertGreater((steps == 1).mean(), 0.8)

    def test_a_column_is_as_far_as_it_is(self):
        poses, columns = np.array([[0, 0, 0.0], [0, 0, np.pi / 2]]), np.array([[3, 0, 0.5], [5, 0, 0.5]])
        ranges_m = rays.to_columns(poses, np.array([0.0, -np.pi / 2, 1.0]), columns)
        np.testing.assert_allclose(ranges_m, [[2.5, np.inf, np.inf], [np.inf, 2.5, np.inf]])

    def test_loops_and_revisits_are_counted_by_the_truth(self):
        places_m = np.array([0, 2, 4, 6, 8, 8, 6, 4, 2, 0.0])  # a second visit, back
        truth = to_trajectory(np.arange(10) * 10**9, np.column_stack([places_m, np.zeros(10), np.zeros(10)]))
        for job in ("loops", "odometry", "pose_graph"):
            (self.folder / job).mkdir()
        (self.folder / "odometry/keyframes.tum").write_text("".join(f"{time}.0 0 0 0 0 0 0 1\n" for time in range(10)))
        loops = np.array([[1, 8], [3, 6], [0, 9]])  # true, false, rejected
        moved_m = [0.0, 3.0, 0.0]
        with sealed(self.folder / "loops/edges.h5") as file:
            file["kind"], file["time_ns"] = np.ones((3, 1), np.uint8), loops * 10**9
            file["target_from_source"] = np.array([[x, 0, 0, *quaternion(np.eye(3))] for x in moved_m])
        with open(self.folder / "pose_graph/loops.csv", "w", newline="") as file:
            rows = csv.writer(file)
            rows.writerow(["frame_a", "frame_b", "status"])
            rows.writerows([[1, 8, "accepted"], [3, 6, "accepted"], [0, 9, "rejected"]])
        self.assertEqual(laser_run.loop_figures(self.folder, truth, 5), {"num_accepted": 2, "num_false": 1, "closed_percent": 20.0})
