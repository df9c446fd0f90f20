# SPDX-License-Identifier: Apache-2.0
"""bench_place_search.py and made_up_floor.py: floors are of the area asked for and connected, scans end on their walls."""

import unittest

import h5py
import numpy as np

from folder_case import FolderTest  # first: it makes the benchmarks importable

import bench_place_search as bench
import made_up_floor as floor
import mrpt_localization as mrpt
from nightmap_eval.grid import FREE, OCCUPIED, Grid, read_grid
from nightmap_eval.trajectory import read_tum

EXACT = floor.Laser(noise_m=0.0)


def reached(free, start):
    """Cells that a way through free cells leads to."""
    result = np.zeros_like(free)
    result[start] = True
    count = 0
    while count != (count := np.count_nonzero(result)):
        for axis in (0, 1):
            for step in (1, -1):
                for _ in range(20):
                    result |= np.roll(result, step, axis) & free
    return result


class FloorTest(unittest.TestCase):
    def test_equal_seeds_give_equal_floors(self):
        first, again, other = (floor.make_floor(600, seed).cells for seed in (1, 1, 2))
        np.testing.assert_array_equal(first, again)
        self.assertFalse(np.array_equal(first, other))

    def test_floors_are_closed_and_have_the_area(self):
        for area_m2 in (500, 1200, 3000):
            grid = floor.make_floor(area_m2, 3)
            self.assertLess(abs(grid.cells.size * grid.resolution_m**2 / area_m2 - 1), 0.01)
            for edge in (grid.cells[0], grid.cells[-1], grid.cells[:, 0], grid.cells[:, -1]):
                self.assertTrue(np.all(edge == OCCUPIED))

    def test_most_of_the_floor_can_be_reached_from_the_corridor(self):
        free = floor.make_floor(1000, 1).cells == FREE
        self.assertGreater(np.count_nonzero(reached(free, (5, 5))), 0.8 * np.count_nonzero(free))

    def test_rooms_fill_their_strip(self):
        random = np.random.default_rng(0)
        for total in range(161, 900, 37):
            sizes = floor.lengths(random, total)
            self.assertEqual(sum(sizes), total)
            self.assertTrue(all(floor.cells_of(4) <= size <= floor.cells_of(12) for size in sizes), sizes)

    def test_strips_fill_the_floor_with_corridors_between(self):
        random = np.random.default_rng(0)
        for total in range(447, 2900, 97):
            strips = floor.strips(random, total)
            self.assertTrue(strips and len(strips) % 2 == 0)
            gaps = [after[0] - sum(before) for before, after in zip(strips, strips[1:])]
            self.assertEqual(gaps, [floor.cells_of(2), 0] * (len(gaps) // 2) + [floor.cells_of(2)])
            self.assertEqual((strips[0][0], sum(strips[-1])), (0, total))
            self.assertTrue(all(floor.cells_of(3) < rows < floor.cells_of(10) for _, rows in strips), strips)


class ScanTest(unittest.TestCase):
    def setUp(self):
        cells = np.full((100, 200), FREE, dtype=np.uint8)
        cells[0], cells[-1], cells[:, 0], cells[:, -1] = (OCCUPIED,) * 4
        self.grid = Grid(cells, 0.05)
        self.random = np.random.default_rng(0)

    def test_beams_end_on_the_walls_of_a_room(self):
        ranges_m = floor.scan(self.grid, (3.0, 2.0, np.pi / 2), EXACT, self.random)
        for angle_deg, expected_m in ((0, 2.95), (-90, 6.95), (90, 2.95)):  # of y = 4.95, x = 9.95 and x = 0.05
            beam = round((np.radians(angle_deg) - EXACT.first_rad) / EXACT.step_rad)
            self.assertAlmostEqual(ranges_m[beam], expected_m, delta=1.5 * floor.STEP_M)

    def test_nothing_within_the_limit_is_0(self):
        ranges_m = floor.scan(self.grid, (5.0, 2.5, 0.0), floor.Laser(limit_m=1.0), self.random)
        self.assertTrue(np.all(ranges_m == 0))

    def test_poses_have_room(self):
        poses = floor.free_poses(self.grid, 40, self.random)
        self.assertGreater(poses[:, :2].min(), floor.ROBOT_M)
        self.assertLess(poses[:, 0].max(), 10 - floor.ROBOT_M)
        self.assertLess(poses[:, 1].max(), 5 - floor.ROBOT_M)


class QuestionTest(FolderTest):
    def test_files_say_what_was_drawn(self):
        folder = self.folder / "floor"
        grid = bench.make_question(500, 3, 1, folder)
        read = read_grid(folder / "map.yaml")
        queries, truth = mrpt.read_queries(folder / "queries.h5"), read_tum(folder / "truth.tum")
        with h5py.File(folder / "queries.h5") as file:
            self.assertTrue(all(data.ndim == 2 for data in file.values()))
            self.assertEqual(file.attrs["format"], b"nightmap scan queries")
        np.testing.assert_array_equal(read.cells, grid.cells)
        self.assertEqual([query.time_ns for query in queries], list(truth.times_ns))
        for query, x_y_m, heading_rad in zip(queries, truth.positions_m[:, :2], headings_rad(truth)):
            expected = floor.scan(grid, (*x_y_m, heading_rad), EXACT, np.random.default_rng(0))
            self.assertLess(np.median(np.abs(query.scans[0].ranges_m - expected)), 0.02)

    def test_the_exponent_is_that_of_a_power(self):
        areas = np.array([500, 2000, 5000])
        self.assertAlmostEqual(bench.growth_exponent(areas, 0.1 * areas**0.7), 0.7)

    def test_the_exponent_stands_below_the_rows(self):
        text = bench.table_text(["| a |", "| b |"], [(100, 1.0), (400, 4.0)])
        self.assertIn("| a |\n| b |\n\nCPU time per query grows as the area to the power of 1.00.", text)
        self.assertNotIn("power", bench.table_text(["| a |"], [(100, 1.0)]))


def headings_rad(truth):
    rotations = truth.rotations()
    return np.arctan2(rotations[:, 1, 0], rotations[:, 0, 0])
