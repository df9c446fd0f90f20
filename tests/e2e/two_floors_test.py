# SPDX-License-Identifier: Apache-2.0
"""Accuracy on a building of two floors: a right grid of each, and a drive upstairs."""
import json
import re

import numpy as np

from accuracy import FOLDER, Bars, make, metrics_of


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
