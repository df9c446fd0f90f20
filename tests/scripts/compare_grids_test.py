# SPDX-License-Identifier: Apache-2.0
"""compare_grids.py: cells that two grids have in common, in whatever frames their maps are."""

import json
import unittest

import numpy as np

import fake_site
from compare_grids import compare
from fake_site import rotation_about
from folder_case import FolderTest
from nightmap_eval.grid import FREE, OCCUPIED, UNKNOWN, Grid
from nightmap_eval.trajectory import Similarity, quaternion
from nightmap_eval.walls_and_doors import Sampler


def hall():
    cells = np.full((40, 60), FREE, dtype=np.uint8)
    cells[[0, -1]], cells[:, [0, -1]] = OCCUPIED, OCCUPIED
    return cells


def sampler(cells, yaw_rad=0.0, shift_m=(0.0, 0.0), resolution_m=0.1):
    """A grid of the building whose map is turned and moved against it."""
    rotation, translation = rotation_about([0, 0, 1], yaw_rad), np.array([*shift_m, 0.2])
    origin = -rotation.T @ translation
    return Sampler(Grid(cells, resolution_m, origin[0], origin[1], -yaw_rad), Similarity(1.0, rotation, translation), 0.2)


class CompareTest(unittest.TestCase):
    def test_equal_grids_in_different_frames_are_equal(self):
        for yaw_rad in (0.0, 0.4, np.pi / 2, -2.0):
            figures = compare(sampler(hall()), sampler(hall(), yaw_rad, (3.0, -1.0)))
            self.assertEqual(figures["num_cells"], 2 * 40 * 60)
            for name in ("", "free_", "occupied_"):
                self.assertEqual(figures[f"{name}equal_percent"], 100)
                self.assertEqual(figures[f"{name}equal_within_a_cell_percent"], 100)

    def test_cells_that_differ_are_counted_in_both_directions(self):
        cells = hall()
        cells[10:15, 10:20] = OCCUPIED  # 50 cells in the middle of what the other has free
        figures = compare(sampler(hall()), sampler(cells))
        self.assertEqual(figures["num_cells"], 2 * 2400)
        self.assertAlmostEqual(figures["equal_percent"], 100 * 2350 / 2400)
        # The other grid has nothing occupied near the block; this grid has free cells near all but 3 x 8 of them.
        self.assertAlmostEqual(figures["equal_within_a_cell_percent"], 100 * (4800 - 50 - 24) / 4800)
        self.assertEqual(figures["num_occupied_cells"], 2 * 196 + 50)
        self.assertAlmostEqual(figures["occupied_equal_percent"], 100 * 392 / 442)

    def test_cells_that_one_has_not_seen_do_not_count(self):
        cells = hall()
        cells[:, 30:] = UNKNOWN
        figures = compare(sampler(hall()), sampler(cells))
        self.assertEqual((figures["num_cells"], figures["equal_percent"]), (2 * 40 * 30, 100))
        figures = compare(sampler(hall()), sampler(hall(), 0.0, (-50.0, 0.0)))
        self.assertEqual(figures["num_cells"], 2400 * 2)  # the frames differ, the building does not
        figures = compare(sampler(hall()), sampler(np.full((4, 4), UNKNOWN, dtype=np.uint8)))
        self.assertEqual((figures["num_cells"], figures["equal_percent"]), (0, None))

    def test_a_wall_one_cell_beside_is_equal_within_a_cell(self):
        one, other = (np.full((20, 20), FREE, dtype=np.uint8) for _ in range(2))
        one[:, 9], other[:, 10] = OCCUPIED, OCCUPIED
        figures = compare(sampler(one), sampler(other))
        self.assertAlmostEqual(figures["equal_percent"], 100 * 18 / 20)
        self.assertEqual((figures["occupied_equal_percent"], figures["equal_within_a_cell_percent"]), (0, 100))
        other[:, 10], other[:, 11] = FREE, OCCUPIED
        figures = compare(sampler(one), sampler(other))
        self.assertEqual(figures["occupied_equal_within_a_cell_percent"], 0)

    def test_grids_of_different_resolution(self):
        fine = np.repeat(np.repeat(hall(), 2, axis=0), 2, axis=1)
        figures = compare(sampler(hall()), sampler(fine, resolution_m=0.05))
        self.assertEqual(figures["num_cells"], 2400 + 9600)
        self.assertEqual(figures["equal_percent"], 100)


class CommandTest(FolderTest):
    def write_site(self, name, yaw_rad, shift_m, laser):
        """A site whose map frame is the building's, turned and moved, as evaluate wrote it."""
        site_dir = self.folder / name
        rotation, translation = rotation_about([0, 0, 1], yaw_rad), np.array([*shift_m, 0.0])
        fake_site.write_map(site_dir / "grid", "map", fake_site.room_pixels())
        x, y, _ = rotation.T @ (np.array([-3, -2, 0]) - translation)
        path = site_dir / "grid" / "map.yaml"
        path.write_text(path.read_text().replace("[-3.0, -2.0, 0]", f"[{x}, {y}, {-yaw_rad}]"))
        ate = dict.fromkeys(("ate_rmse_m", "ate_median_m", "ate_max_m", "rotation_rmse_deg"), 0.0)
        none = {"num_pairs": 0, "num_missing": 0}
        trajectory = {"truth_from_map_m_q": [*translation, *quaternion(rotation)], "se3": ate, "sim3": ate}
        if laser:
            trajectory |= {"num_scans_with_truth": 3, "missing_percent": 0, "relative_1m": none, "relative_10m": none}
            figures = {"num_scans": 3, "num_scans_with_pose": 3, "path_length_m": 1.0, "trajectory": trajectory}
            metrics = {"sections": {"grid": figures}}
        else:
            metrics = {"trajectory": trajectory | {"num_pairs": 3, "rpe_per_frame": none, "rpe_per_metre": none}}
        (site_dir / "evaluate").mkdir()
        (site_dir / "evaluate" / "metrics.json").write_text(json.dumps(metrics))
        return site_dir

    def test_a_camera_and_a_laser_and_the_plan(self):
        camera, laser = self.write_site("camera", 0.5, (1, -2), False), self.write_site("laser", -1.0, (4, 4), True)
        fake_site.write_map(self.folder, "plan", fake_site.room_pixels())
        for pair in ((camera, laser), (laser, self.folder / "plan.yaml"), (self.folder / "plan.yaml", camera)):
            result = fake_site.run("compare_grids.py", *pair)
            self.assertEqual(result.returncode, 0, result.stderr)
            self.assertIn("| all | 4800 | 100.00 | 100.00 |", result.stdout)

    def test_what_is_missing_is_named(self):
        site = self.write_site("site", 0.0, (0, 0), False)
        self.check_failed(fake_site.run("compare_grids.py", site, self.folder / "none"), "none: no such folder or file")
        (site / "evaluate" / "metrics.json").unlink()
        self.assertIn("not aligned to a truth; run make evaluate", fake_site.run("compare_grids.py", site, site).stderr)
        (site / "grid" / "map.yaml").unlink()
        self.assertIn("no grid; run make map", fake_site.run("compare_grids.py", site, site).stderr)
        self.assertEqual(fake_site.run("compare_grids.py", site).returncode, 2)
