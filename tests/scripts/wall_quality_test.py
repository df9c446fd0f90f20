# SPDX-License-Identifier: Apache-2.0
"""Thickness and doubling of walls: on grids whose walls are known."""

import unittest
from types import SimpleNamespace

import numpy as np

import fake_site  # noqa: F401  first: it makes the packages of scripts/ importable
from nightmap_eval.grid import FREE, OCCUPIED, UNKNOWN, Grid
from nightmap_eval.laser.report_laser import fields
from nightmap_eval.laser.wall_quality import wall_metrics
from nightmap_eval.page.places import bad_parts

CELL_M = 0.05
SIZE = 121
AXES_DEG = (0, 90)
ANGLES_DEG = (0, 30, 45, 60, 90, 133, 160)


def walls(offsets_m, angle_deg=0.0, between=FREE):
    """Parallel walls of one cell through a free hall, at these distances from its middle; `between` is the state between the
    outermost two."""
    cells = np.full((SIZE, SIZE), FREE, dtype=np.uint8)
    rows, columns = np.mgrid[:SIZE, :SIZE] - SIZE // 2
    cos, sin = np.cos(np.radians(angle_deg)), np.sin(np.radians(angle_deg))
    across = (cos * rows - sin * columns) * CELL_M
    cells[(across > min(offsets_m)) & (across < max(offsets_m))] = between
    # One cell in each row or column, whichever the wall crosses more of.
    major = np.arange(SIZE) - SIZE // 2
    for offset in np.array(offsets_m) / CELL_M:
        column, row = (major, (offset + sin * major) / cos) if abs(cos) >= abs(sin) else ((cos * major - offset) / sin, major)
        row, column = np.rint(row).astype(int), np.rint(column).astype(int)
        shown = (abs(row) <= SIZE // 2) & (abs(column) <= SIZE // 2)
        cells[row[shown] + SIZE // 2, column[shown] + SIZE // 2] = OCCUPIED
    return Grid(cells, CELL_M)


def band(thickness_cells, angle_deg=0.0):
    """A solid wall."""
    grid = walls([0.0], angle_deg)
    rows, columns = np.mgrid[:SIZE, :SIZE] - SIZE // 2
    across = np.cos(np.radians(angle_deg)) * rows - np.sin(np.radians(angle_deg)) * columns
    grid.cells[:] = np.where(np.abs(across) <= thickness_cells / 2 - 1e-6, OCCUPIED, FREE)
    return grid


class ThicknessTest(unittest.TestCase):
    def test_a_wall_of_one_cell_has_thickness_one(self):
        for angle_deg in ANGLES_DEG:
            with self.subTest(angle_deg):
                figures = wall_metrics(walls([0.0], angle_deg))
                self.assertEqual(figures["num_wall_cells"], figures["num_occupied_cells"])
                self.assertAlmostEqual(figures["thickness_median_cells"], 1)
                self.assertLess(figures["thickness_mean_cells"], 1.05)
                self.assertEqual(figures["doubled_percent"], 0)

    def test_a_thick_wall_has_its_thickness(self):
        for angle_deg in ANGLES_DEG:
            for thickness in (3, 5, 7):
                with self.subTest((angle_deg, thickness)):
                    figures = wall_metrics(band(thickness, angle_deg))
                    self.assertAlmostEqual(figures["thickness_median_cells"], thickness, delta=1e-6 if angle_deg in AXES_DEG else 1)
                    self.assertEqual(figures["doubled_percent"], 0)

    def test_a_wall_that_is_thick_at_a_part_shows_in_the_worst_cells(self):
        grid = walls([0.0])
        grid.cells[61:63, 30:60] = OCCUPIED  # 3 cells thick over a quarter of the wall
        figures = wall_metrics(grid)
        self.assertAlmostEqual(figures["thickness_median_cells"], 2, delta=1)
        self.assertAlmostEqual(figures["thickness_p90_cells"], 3, delta=0.1)

    def test_clutter_and_stubs_are_no_walls(self):
        cells = np.full((SIZE, SIZE), FREE, dtype=np.uint8)
        cells[20:24, 20:24] = OCCUPIED  # a box
        cells[60, 60:68] = OCCUPIED  # 0.4 m
        cells[90:110:10, 20:100:10] = OCCUPIED  # legs of chairs
        figures = wall_metrics(Grid(cells, CELL_M))
        self.assertEqual(figures["num_wall_cells"], 0)
        self.assertIsNone(figures["thickness_median_cells"])
        self.assertIsNone(figures["doubled_percent"])

    def test_a_grid_with_no_or_one_cell(self):
        for cells in (np.zeros((0, 0), np.uint8), np.zeros((3, 3), np.uint8), np.full((1, 1), OCCUPIED, np.uint8)):
            self.assertEqual(wall_metrics(Grid(cells, CELL_M))["num_wall_cells"], 0)

    def test_walls_at_the_border_and_cells_of_another_size(self):
        cells = np.full((40, 200), FREE, dtype=np.uint8)
        cells[0], cells[-1] = OCCUPIED, OCCUPIED
        for cell_m in (0.02, 0.05, 0.1):
            figures = wall_metrics(Grid(cells, cell_m))
            self.assertEqual(figures["num_wall_cells"], 400)
            self.assertEqual(figures["thickness_p90_cells"], 1)


class DoubledTest(unittest.TestCase):
    def percent(self, *arguments, **more):
        return wall_metrics(walls(*arguments, **more))["doubled_percent"]

    def test_a_wall_that_is_drawn_twice_is_found(self):
        for angle_deg in ANGLES_DEG:
            for apart_m in (0.2, 0.25, 0.3):
                with self.subTest((angle_deg, apart_m)):
                    self.assertGreater(self.percent([0.0, apart_m], angle_deg), 95)

    def test_the_limits_of_the_distance(self):
        for apart_m, expected in ((0.1, 100), (0.4, 100), (0.45, 0), (0.5, 0)):
            self.assertEqual(self.percent([0.0, apart_m]), expected)

    def test_a_real_partition_of_15_cm_is_not_doubled(self):
        for angle_deg in ANGLES_DEG:
            for apart_m in (0.1, 0.15, 0.2):
                self.assertEqual(self.percent([0.0, apart_m], angle_deg, between=UNKNOWN), 0)

    def test_a_few_free_cells_in_a_partition_do_not_count(self):
        grid = walls([0.0, 0.2], between=UNKNOWN)
        grid.cells[62, ::7] = FREE
        self.assertEqual(wall_metrics(grid)["doubled_percent"], 0)

    def test_most_of_the_cells_between_must_be_free_where_the_wall_is_doubled(self):
        grid = walls([0.0, 0.2], between=UNKNOWN)
        grid.cells[61:64, :60] = FREE
        self.assertAlmostEqual(wall_metrics(grid)["doubled_percent"], 50, delta=2)

    def test_short_pieces_beside_a_wall_are_not_its_double(self):
        grid = walls([0.0])
        grid.cells[64, 20:38] = OCCUPIED  # 0.9 m
        self.assertEqual(wall_metrics(grid)["doubled_percent"], 0)
        grid.cells[64, 20:45] = OCCUPIED  # 1.25 m, of a wall of 6 m
        self.assertAlmostEqual(wall_metrics(grid)["doubled_percent"], 100 * 50 / (121 + 25), delta=1)

    def test_a_wall_at_an_angle_is_not_its_double(self):
        grid = walls([0.0])
        columns = np.arange(20, 60)
        grid.cells[64 + (columns - 20) // 2, columns] = OCCUPIED  # turned by 27 degrees
        self.assertEqual(wall_metrics(grid)["doubled_percent"], 0)

    def test_both_faces_of_a_corridor_are_walls_of_their_own(self):
        self.assertEqual(self.percent([-0.6, 0.6]), 0)

    def test_a_box_in_between_hides_no_double(self):
        grid = walls([0.0, 0.3])
        grid.cells[63, 50] = OCCUPIED
        self.assertGreater(wall_metrics(grid)["doubled_percent"], 98)


class FieldsTest(unittest.TestCase):
    """The same by place, as the page shows it."""

    def places(self, grid):
        return [place for field in fields(None, SimpleNamespace(grids={0: grid})) for _, place in bad_parts(field)]

    def test_a_wall_that_is_drawn_twice_in_part_is_told_there(self):
        grid = walls([0.0])
        grid.cells[65, 60:] = OCCUPIED  # 0.25 m beside it
        [place] = self.places(grid)
        self.assertRegex(place.said, "walls are drawn twice")
        self.assertGreater(place.x_m, 60 * CELL_M - 0.5)
        self.assertAlmostEqual(place.y_m, 61 * CELL_M, delta=0.5)

    def test_a_thick_wall_is_told_with_its_thickness(self):
        [place] = self.places(band(7))
        self.assertRegex(place.said, "walls are 35 cm thick")

    def test_thin_walls_are_no_places_to_look_at_and_an_empty_grid_has_none(self):
        for angle_deg in ANGLES_DEG:
            self.assertEqual(self.places(walls([0.0], angle_deg)), [])
        self.assertEqual(self.places(Grid(np.full((40, 40), FREE, np.uint8), CELL_M)), [])
