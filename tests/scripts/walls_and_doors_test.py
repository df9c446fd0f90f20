# SPDX-License-Identifier: Apache-2.0
"""Walls, doors and floors of a made-up building in grids that have them, and in grids that do not."""

import json
import unittest

import numpy as np

import fake_site
from fake_site import rotation_about
from folder_case import FolderTest
from nightmap_eval.grid import FREE, OCCUPIED, UNKNOWN, Grid
from nightmap_eval.trajectory import Similarity
from nightmap_eval.walls_and_doors import Sampler, door_figures, evaluate_floors, passage_width_m, read_floors, wall_figures
from nightmap_site.script_errors import DataError
from nightmap_site.site import Site

CELL_M = 0.05
WALL = 1
# Two rooms of 4 m x 3 m side by side; the wall between them has a door in its middle.
DOOR_M = [3.95, 1.0, 4.05, 2.0]
BOXES = [
    {"center_m": [4.0, 0.5, 1.3], "half_size_m": [0.05, 0.5, 1.3], "yaw_rad": 0, "label": WALL},
    {"center_m": [4.0, 2.5, 1.3], "half_size_m": [0.5, 0.05, 1.3], "yaw_rad": np.pi / 2, "label": WALL},
    {"center_m": [4.0, 1.5, 2.3], "half_size_m": [0.05, 0.5, 0.3], "yaw_rad": 0, "label": WALL},  # lintel
    {"center_m": [2.0, 1.5, 0.4], "half_size_m": [0.5, 0.5, 0.4], "yaw_rad": 0, "label": 5},  # table
]


def rooms(door_m=(1.0, 2.0)):
    """Cells of the two rooms; the door is where the wall is free."""
    cells = np.full((60, 160), FREE, dtype=np.uint8)
    cells[:, 79:81] = OCCUPIED
    cells[round(door_m[0] / CELL_M):round(door_m[1] / CELL_M), 79:81] = FREE  # fmt: skip
    return cells


def sampler(cells, yaw_rad=0.0):
    """The grid seen in a map that is turned against the building and moved."""
    rotation, translation = rotation_about([0, 0, 1], yaw_rad), np.array([1.0, -2.0, 0.3])
    origin = rotation.T @ -translation  # of the building in the map
    grid = Grid(cells, CELL_M, origin[0], origin[1], -yaw_rad)
    return Sampler(grid, Similarity(1.0, rotation, translation), 0.0)


class WallTest(unittest.TestCase):
    def figures(self, cells, yaw_rad=0.0):
        return wall_figures(sampler(cells, yaw_rad), Grid(rooms(), CELL_M), BOXES, WALL)

    def test_the_plan_itself_has_all_its_walls(self):
        for yaw_rad in (0.0, 0.4, 2.0):
            figures = self.figures(rooms(), yaw_rad)
            self.assertEqual((figures["num_walls"], figures["num_walls_closed"]), (2, 2))  # no lintel, no table
            self.assertEqual(figures["wall_length_present_percent"], 100)
            self.assertEqual(figures["wall_length_unseen_percent"], 0)

    def test_a_hole_of_one_cell_opens_a_wall(self):
        cells = rooms()
        cells[8, 79:81] = FREE
        figures = self.figures(cells)
        self.assertEqual((figures["num_walls_closed"], figures["num_walls_crossed"]), (1, 1))
        self.assertEqual(figures["walls_closed_percent"], 50)
        self.assertLess(figures["wall_length_present_percent"], 98)

    def test_a_dent_does_not(self):
        cells = rooms()
        cells[8, 79] = FREE
        self.assertEqual(self.figures(cells)["num_walls_closed"], 2)

    def test_a_wall_beside_its_place_is_missing(self):
        cells = rooms()
        cells[:20, 79:81], cells[:20, 76] = FREE, OCCUPIED
        figures = self.figures(cells)
        self.assertEqual(figures["num_walls_closed"], 1)
        self.assertLess(figures["wall_length_present_percent"], 60)

    def test_a_wall_that_was_not_seen_is_not_closed(self):
        cells = rooms()
        cells[:12, 79:81] = UNKNOWN  # more than half of the first wall
        figures = self.figures(cells)
        self.assertEqual((figures["num_walls"], figures["num_walls_closed"]), (2, 1))
        self.assertEqual(figures["num_walls_crossed"], 0)
        self.assertEqual(figures["wall_length_present_percent"], 100)
        self.assertAlmostEqual(figures["wall_length_unseen_percent"], 100 * 12 / 40, delta=3)

    def test_a_wall_behind_things_only_must_not_be_crossed(self):
        plan = rooms()
        plan[:12, 70:90] = OCCUPIED  # 0.4 m of the first wall are left
        for state, num_crossed in ((UNKNOWN, 0), (FREE, 1)):
            cells = rooms()
            cells[:20, 79:81] = state
            figures = wall_figures(sampler(cells), Grid(plan, CELL_M), BOXES, WALL)
            self.assertEqual((figures["num_walls"], figures["num_walls_hidden"]), (1, 1))
            self.assertEqual((figures["num_walls_closed"], figures["num_walls_crossed"]), (1, num_crossed))

    def test_without_walls_there_are_no_percentages(self):
        figures = wall_figures(sampler(rooms()), Grid(rooms(), CELL_M), [], WALL)
        self.assertIsNone(figures["walls_closed_percent"])


class DoorTest(unittest.TestCase):
    def test_width_is_right_within_a_cell(self):
        for width_m in (0.3, 0.5, 0.75, 1.0):
            for yaw_rad in (0.0, 0.4):
                cells = rooms((1.5 - width_m / 2, 1.5 + width_m / 2))
                measured_m = passage_width_m(sampler(cells, yaw_rad), DOOR_M)
                self.assertAlmostEqual(measured_m, width_m, delta=CELL_M + 1e-9)

    def test_a_closed_or_unknown_door_has_no_width(self):
        for state in (OCCUPIED, UNKNOWN):
            cells = rooms()
            cells[20:40, 79:81] = state
            self.assertEqual(passage_width_m(sampler(cells), DOOR_M), 0)

    def test_verdicts(self):
        narrow = rooms((1.4, 1.7))
        for cells, robot_m, passable, closed in (
            (rooms(), 0.5, 0, 0),
            (rooms(), 1.2, 0, 0),  # neither the plan nor the grid lets it through
            (narrow, 0.5, 0, 1),  # the grid closes a door of 1 m
            (narrow, 0.3, 0, 0),
        ):
            figures = door_figures(sampler(cells), [DOOR_M], robot_m)
            self.assertEqual(figures["num_doors_wrongly_passable"], passable)
            self.assertEqual(figures["num_doors_wrongly_closed"], closed)
        true_narrow = [3.95, 1.4, 4.05, 1.7]  # 0.3 m in the plan, 1 m in the grid
        figures = door_figures(sampler(rooms()), [true_narrow], 0.5)
        self.assertEqual(figures["num_doors_wrongly_passable"], 1)
        self.assertAlmostEqual(figures["max_door_width_error_m"], 0.7, delta=CELL_M + 1e-9)


class FloorsTest(FolderTest):
    def setUp(self):
        self.site_dir, self.truth_dir = self.folder / "site", self.folder / "truth"
        pixels = np.array([205, 254, 0], dtype=np.uint8)[rooms()]
        for folder, names in ((self.site_dir / "grid", ("map", "floor_1")),
                              (self.truth_dir, ("floor_plan", "floor_plan_1"))):  # fmt: skip
            for name in names:
                fake_site.write_map(folder, name, pixels, (0.0, 0.0), CELL_M)
        self.truth_dir.joinpath("boxes.json").write_text(json.dumps({
            "labels": ["none", "wall"], "boxes": BOXES,
            "floors": [{"height_m": 0.0, "plan": "floor_plan.yaml", "doorways_m": [DOOR_M]},
                       {"height_m": 2.9, "plan": "floor_plan_1.yaml", "doorways_m": []}],
        }))  # fmt: skip

    def write_floors(self, heights_m, **more):
        floors = [{"number": i, "height_m": h, "yaml": "map.yaml" if i == 0 else f"floor_{i}.yaml"}
                  for i, h in enumerate(heights_m)]  # fmt: skip
        content = {"format": "nightmap floors", "version": 2, "floors": floors} | more
        (self.site_dir / "grid" / "floors.json").write_text(json.dumps(content))

    def evaluate(self):
        return evaluate_floors(Site(self.site_dir), self.truth_dir, Similarity(1.0, np.eye(3), np.zeros(3)))

    def test_each_floor_is_compared_with_its_plan(self):
        self.write_floors([0.0, 2.95])
        figures = self.evaluate()
        self.assertEqual((figures["num_true_floors"], figures["num_floors_found"]), (2, 2))
        self.assertEqual(figures["seen_right_percent"], 100)
        self.assertEqual(figures["num_doors"], 1)
        self.assertEqual(figures["floors"][1]["seen_right_percent"], 100)
        self.assertEqual(figures["floors"][1]["num_walls"], 0)  # the boxes stand downstairs
        self.assertAlmostEqual(figures["floors"][1]["height_error_m"], 0.05)

    def test_a_floor_that_was_not_found_says_so(self):
        self.write_floors([0.0])
        figures = self.evaluate()
        self.assertEqual(figures["num_floors_found"], 1)
        self.assertFalse(figures["floors"][1]["found"])
        self.assertNotIn("seen_right_percent", figures["floors"][1])

    def test_the_robot_is_the_one_that_the_site_plans_for(self):
        self.write_floors([0.0])
        (self.site_dir / "config").mkdir()
        (self.site_dir / "config" / "plan.toml").write_text("robot_radius_m = 0.6\n")
        figures = self.evaluate()
        self.assertEqual(figures["robot_width_m"], 1.2)
        self.assertEqual(figures["num_doors_wrongly_passable"] + figures["num_doors_wrongly_closed"], 0)

    def test_other_files_are_refused(self):
        self.assertEqual(read_floors(Site(self.site_dir))[0]["yaml"], "map.yaml")  # none: one floor
        for wrong in ({"format": "other"}, {"version": 1}, {"version": 3}):
            self.write_floors([0.0], **wrong)
            with self.assertRaisesRegex(DataError, "floors.json"):
                read_floors(Site(self.site_dir))
