# SPDX-License-Identifier: Apache-2.0
"""bench_drive.py: a right drive is judged right, and each kind of wrong one is found."""

import argparse
import json
import unittest

import numpy as np

import fake_site
from folder_case import FolderTest
from nightmap_eval.grid import FREE, OCCUPIED, UNKNOWN, read_grid
from nightmap_eval.planar_poses import wrapped_rad
from nightmap_site.script_errors import DataError

import bench_drive
from grid_holes import holes

PERIOD_S = 0.05
RADIUS_M = 0.2
CONFIG = {"period_s": PERIOD_S, "max_v_m_s": 0.5, "max_acceleration_m_s2": 1.0, "max_omega_rad_s": 1.0,
          "max_angular_acceleration_rad_s2": 2.0, "wheel_noise": 0.0}  # fmt: skip


def commands():
    """Speeds up, turns to the left, and stops; within the limits."""
    v = np.concatenate([np.arange(0, 0.5, 0.05), np.full(40, 0.5), np.arange(0.5, 0, -0.05), [0]])
    omega = np.zeros(len(v))
    omega[15:45] = np.concatenate([np.arange(0, 0.8, 0.1), np.full(14, 0.8), np.arange(0.8, 0, -0.1)])
    return v, omega


def driven(v, omega):
    """Poses from (1, 2) with a heading of 0.3 on, in a thousand small straight steps each."""
    poses = [np.array([1.0, 2.0, 0.3])]
    for v_m_s, omega_rad_s in zip(v[:-1], omega[:-1]):
        x, y, heading = poses[-1]
        step_s = PERIOD_S / 1000
        headings = heading + omega_rad_s * step_s * (np.arange(1000) + 0.5)
        ahead = v_m_s * step_s * np.array([np.cos(headings).sum(), np.sin(headings).sum()])
        poses.append(np.array([x + ahead[0], y + ahead[1], heading + omega_rad_s * PERIOD_S]))
    return np.array(poses)


class ArcsTest(unittest.TestCase):
    def test_a_quarter_of_a_circle_and_a_line(self):
        quarter = bench_drive.on_arcs(1, 2, 0, 1, np.pi / 2, 1)
        np.testing.assert_allclose(quarter, [1 + 2 / np.pi, 2 + 2 / np.pi, np.pi / 2])
        np.testing.assert_allclose(bench_drive.on_arcs(1, 2, np.pi / 2, 3, 0, 2), [1, 8, np.pi / 2])


class DriveTest(FolderTest):
    def setUp(self):
        self.v, self.omega = commands()
        self.poses = driven(self.v, self.omega)
        self.path = self.poses[:, :2].copy()
        self.goal_heading_rad = self.poses[-1, 2]
        self.obstacles_m = np.array([[0.0, 0.0], [3.0, 1.0]])
        self.config = dict(CONFIG)

    def drive(self):
        times_ns = np.arange(len(self.v)) * round(PERIOD_S * 1e9)
        rows = [f"{time},{x:.6f},{y:.6f},{wrapped_rad(heading):.6f},{v:.6f},{omega:.6f}"
                for time, (x, y, heading), v, omega in zip(times_ns, self.poses, self.v, self.omega)]  # fmt: skip
        header = "time_ns,x_m,y_m,heading_rad,v_m_s,omega_rad_s"
        (self.folder / "drive.csv").write_text("\n".join([header, *rows]) + "\n")
        config = "".join(f"{key} = {value}\n" for key, value in self.config.items())
        report = {"config": config, "robot_radius_m": RADIUS_M}
        (self.folder / "report.json").write_text(json.dumps(report))
        return bench_drive.Drive(self.folder, self.path)

    def wrong(self):
        return bench_drive.judge(self.drive(), self.obstacles_m, 0.1, self.goal_heading_rad)

    def test_a_right_drive(self):
        self.assertEqual(self.wrong(), [])

    def test_limits(self):
        for name in ("max_v_m_s", "max_acceleration_m_s2", "max_omega_rad_s", "max_angular_acceleration_rad_s2"):
            self.config = CONFIG | {name: 0.9 * CONFIG[name] * (0.8 if "omega" in name else 1)}
            self.assertEqual(self.wrong(), ["limits"], name)
        self.config = CONFIG | {"period_s": 0.04}  # not that of the times
        self.assertIn("limits", self.wrong())

    def test_a_last_command_that_is_not_to_stand(self):
        self.v[-1] = 0.05
        self.assertEqual(self.wrong(), ["limits"])

    def test_poses_that_do_not_follow_from_the_commands(self):
        self.poses[30, 1] += 1e-4
        self.assertEqual(self.wrong(), ["replay"])
        self.config["wheel_noise"] = 0.05  # then they may be so far off
        self.assertEqual(self.wrong(), [])
        self.poses[30, 1] += 0.02
        self.assertEqual(self.wrong(), ["replay"])

    def test_collisions_also_between_poses(self):
        drive = self.drive()
        middle = np.array(bench_drive.on_arcs(*self.poses[30], self.v[30], self.omega[30], PERIOD_S / 2))
        beside = np.array([-np.sin(middle[2]), np.cos(middle[2])])
        # A cell of next to no size, so that its distance is that of its centre.
        for distance_m in (RADIUS_M - 2e-5, RADIUS_M + 2e-5):
            obstacle_m = (middle[:2] + distance_m * beside)[None]
            self.assertAlmostEqual(drive.clearance_m(obstacle_m, 1e-9), distance_m, delta=1e-5)
            wrong = bench_drive.judge(drive, obstacle_m, 1e-9, self.goal_heading_rad)
            self.assertEqual(wrong, ["collision"] if distance_m < RADIUS_M else [])

    def test_an_obstacle_is_a_square(self):
        nearest = self.drive().clearance_m(np.array([[0.8, 1.8]]), 0.2)
        self.assertAlmostEqual(nearest, np.hypot(0.1, 0.1), places=6)  # its corner to the first pose

    def test_arrival_and_start(self):
        self.path[-1] += [0.04, 0.04]
        self.assertEqual(self.wrong(), ["position"])
        self.path = self.poses[:, :2] + [0, 1e-4]
        self.assertEqual(self.wrong(), ["start"])
        self.path = self.poses[:, :2]
        self.goal_heading_rad += np.radians(5.5) - 2 * np.pi
        self.assertEqual(self.wrong(), ["heading"])


class ObstaclesTest(FolderTest):
    def obstacles(self, unknown_is_obstacle):
        """(column, row) of the obstacles among 3 x 2 cells, the right ones of the upper row not free."""
        cells = np.array([[FREE, FREE, FREE], [FREE, OCCUPIED, UNKNOWN]])
        gray = {FREE: 254, OCCUPIED: 0, UNKNOWN: 205}
        pixels = np.vectorize(gray.get)(cells).astype(np.uint8)
        fake_site.write_map(self.folder, "map", pixels, (1.0, 2.0), 0.1)
        grid = read_grid(self.folder / "map.yaml")
        centres_m = bench_drive.obstacle_centres_m(grid, unknown_is_obstacle, 0.1)
        return {tuple(cell) for cell in np.round((centres_m - [1.05, 2.05]) / 0.1).astype(int)}

    def test_those_that_a_robot_on_a_free_cell_is_next_to(self):
        rim = {(0, -1), (1, -1), (2, -1), (-1, 0), (-1, 1), (3, 0), (0, 2)}  # beside the free cells
        self.assertEqual(self.obstacles(True), {(1, 1), (2, 1)} | rim)
        self.assertEqual(self.obstacles(False), {(1, 1)})

    def test_small_holes_are_none(self):
        cells = np.full((8, 9), FREE)
        cells[2, 2] = cells[2, 5] = cells[3, 6] = cells[5, 2] = cells[0, 4] = UNKNOWN
        cells[6, 3] = OCCUPIED
        found = holes(cells == FREE, cells == OCCUPIED, 1)
        self.assertTrue(not found[0, 4] and not found[5, 2])  # at the border, beside an obstacle
        self.assertEqual(found.sum(), 3)
        cells[3, 5] = cells[2, 6] = UNKNOWN  # now a square of two
        self.assertEqual(holes(cells == FREE, cells == OCCUPIED, 1).sum(), 1)
        self.assertEqual(holes(cells == FREE, cells == OCCUPIED, 2).sum(), 5)


class OptionsTest(unittest.TestCase):
    def test_each_stage_gets_its_own(self):
        arguments = argparse.Namespace(set=["drive.max_v_m_s=0.3", 'plan.start="1,2"', "drive.seed=4"])
        self.assertEqual(bench_drive.options_of(arguments, "drive"), {"max_v_m_s": "0.3", "seed": "4"})
        self.assertEqual(bench_drive.options_of(arguments, "plan"), {"start": '"1,2"'})
        for text in ("max_v_m_s=1", "drive.max_v_m_s", "drive.max.v=1"):
            with self.assertRaises(DataError):
                bench_drive.options_of(argparse.Namespace(set=[text]), "drive")
