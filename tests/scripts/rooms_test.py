# SPDX-License-Identifier: Apache-2.0
"""Rooms and walls of made-up floor plans: how many, how large, where."""

import unittest

import numpy as np

import fake_site  # noqa: F401 (path of the scripts)
from nightmap_eval.grid import FREE, OCCUPIED, UNKNOWN, Grid
from nightmap_eval.polygons import crossing_rings
from nightmap_eval.rooms import find_rooms, find_walls

CELL_M = 0.05


def plan(width_m, height_m, *rooms_m):
    """A grid with walls of 0.1 m around free rectangles (x0, y0, x1, y1), which may overlap; unknown outside."""
    cells = np.full((round(height_m / CELL_M), round(width_m / CELL_M)), UNKNOWN, dtype=np.uint8)
    for grown, state in ((2, OCCUPIED), (0, FREE)):
        for room in rooms_m:
            x0, y0, x1, y1 = (round(value / CELL_M) for value in room)
            cells[y0 - grown : y1 + grown, x0 - grown : x1 + grown] = state
    return cells


def two_rooms(door_m=0.9):
    """4 m x 3 m and 3 m x 3 m, with a door in the wall of 0.1 m between them."""
    return plan(8, 4, (0.5, 0.5, 4.5, 3.5), (4.6, 0.5, 7.6, 3.5), (4.5, 1.5, 4.6, 1.5 + door_m))


def area_of(ring):
    x, y = (ring - ring[0]).T
    return (x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2


def inside(ring, point):
    """Even-odd rule."""
    (x0, y0), (x1, y1) = ring.T, np.roll(ring, -1, axis=0).T
    crossed = (y0 > point[1]) != (y1 > point[1])
    at = x0[crossed] + (point[1] - y0[crossed]) / (y1 - y0)[crossed] * (x1 - x0)[crossed]
    return np.count_nonzero(at > point[0]) % 2 == 1


def num_crossings(polygon):
    """Pairs of sides of a polygon that cross each in its inner, and corners that lie on the inner of a side."""
    rings = [polygon.outer, *polygon.holes]
    a, b = np.concatenate(rings), np.concatenate([np.roll(ring, -1, axis=0) for ring in rings])

    def turn(p, q, r):
        return (q - p)[..., 0] * (r - p)[..., 1] - (q - p)[..., 1] * (r - p)[..., 0]

    i, j = np.triu_indices(len(a), 1)
    apart = turn(a[i], b[i], a[j]) * turn(a[i], b[i], b[j]) < -1e-12
    num_crossed = np.count_nonzero(apart & (turn(a[j], b[j], a[i]) * turn(a[j], b[j], b[i]) < -1e-12))
    starts, ends = a[:, None], b[:, None]
    on_line = np.abs(turn(starts, ends, a)) < 1e-9
    return num_crossed + np.count_nonzero(on_line & (np.sum((a - starts) * (a - ends), axis=2) < -1e-9))


class RoomsTest(unittest.TestCase):
    def check(self, grid, labels, rooms):
        """Properties of the rooms of any grid."""
        self.assertEqual([room.number for room in rooms], list(range(1, labels.max(initial=0) + 1)))
        self.assertTrue(np.all(grid.cells[labels > 0] == FREE))
        areas = [room.area_m2 for room in rooms]
        self.assertEqual(areas, sorted(areas, reverse=True))
        for room in rooms:
            own = labels == room.number
            self.assertGreaterEqual(room.area_m2, 1 - 1e-9)
            self.assertAlmostEqual(room.area_m2, np.count_nonzero(own) * grid.resolution_m**2)
            self.assertTrue(own[tuple(at[0] for at in grid.indices(np.array([room.centre_m])))])
            rings = [ring for polygon in room.polygons for ring in (polygon.outer, *polygon.holes)]
            tolerance_m2 = sum(len(ring) for ring in rings) * grid.resolution_m**2
            tolerance_m2 += sum(np.sum(np.linalg.norm(ring - np.roll(ring, 1, axis=0), axis=1)) for ring in rings) * grid.resolution_m / 4
            self.assertAlmostEqual(sum(polygon.area() for polygon in room.polygons), room.area_m2, delta=tolerance_m2)
            self.assertLessEqual(room.height_m, room.width_m)
            self.assertGreaterEqual((room.width_m + grid.resolution_m) * (room.height_m + grid.resolution_m), room.area_m2)
            for polygon in room.polygons:
                self.check_polygon(polygon)

    def check_polygon(self, polygon):
        self.assertGreater(area_of(polygon.outer), 0)
        self.assertTrue(all(area_of(hole) < 0 for hole in polygon.holes))
        self.assertEqual(num_crossings(polygon), 0)

    def rooms_of(self, cells, *origin):
        grid = Grid(cells, CELL_M, *origin)
        labels, rooms = find_rooms(grid)
        self.check(grid, labels, rooms)
        return labels, rooms

    def test_door_parts_two_rooms(self):
        for door_m in (0.7, 0.9, 1.1):
            labels, rooms = self.rooms_of(two_rooms(door_m))
            self.assertEqual(len(rooms), 2, door_m)
            for room, area_m2, sides in zip(rooms, (12, 9), ((4, 3), (3, 3))):
                self.assertAlmostEqual(room.area_m2, area_m2, delta=0.15)
                self.assertAlmostEqual(room.width_m, sides[0], delta=0.11)
                self.assertAlmostEqual(room.height_m, sides[1], delta=0.11)
            # The border is in the doorway, columns 90 and 91: every free cell beside it has the number of its room.
            self.assertTrue(np.all(labels[10:70, 10:90] == 1) and np.all(labels[10:70, 92:152] == 2), door_m)

    def test_wide_opening_parts_none(self):
        _, rooms = self.rooms_of(two_rooms(1.8))
        self.assertEqual(len(rooms), 1)
        self.assertAlmostEqual(rooms[0].area_m2, 12 + 9 + 0.18, places=6)

    def test_l_shape_is_one_room(self):
        _, rooms = self.rooms_of(plan(7, 7, (0.5, 0.5, 6.5, 2.5), (0.5, 0.5, 2.5, 6.5)))
        self.assertEqual(len(rooms), 1)
        self.assertAlmostEqual(rooms[0].area_m2, 20, places=6)
        self.assertAlmostEqual(rooms[0].polygons[0].area(), 20, places=6)
        self.assertEqual(len(rooms[0].polygons[0].outer), 6)

    def test_corridor_with_a_narrow_place_is_one_room(self):
        cells = plan(13, 3, (0.5, 0.5, 12.5, 2.0))
        cells[10:18, 100:110] = OCCUPIED  # a shelf leaves 1.1 m
        self.assertEqual(len(self.rooms_of(cells)[1]), 1)

    def test_narrow_corridor_alone_is_a_room(self):
        _, rooms = self.rooms_of(plan(6, 2, (0.5, 0.5, 5.5, 1.4)))
        self.assertAlmostEqual(rooms[0].area_m2, 4.5, places=6)

    def test_slivers_are_none(self):
        self.assertEqual(self.rooms_of(plan(3, 3, (0.5, 0.5, 1.4, 1.4)))[1], [])
        labels, rooms = self.rooms_of(plan(8, 4, (0.5, 0.5, 4.5, 3.5), (4.6, 0.5, 5.4, 1.4), (4.4, 0.6, 4.7, 1.3)))
        self.assertEqual(len(rooms), 1)
        self.assertEqual(labels[16, 100], 1)  # the closet of 0.7 m2 belongs to the room before it

    def test_table_and_specks_part_nothing(self):
        cells = two_rooms()
        cells[35:50, 30:48] = OCCUPIED
        cells[20:23, 120:140] = UNKNOWN
        _, rooms = self.rooms_of(cells)
        self.assertEqual(len(rooms), 2)
        self.assertAlmostEqual(rooms[0].area_m2, 12 - 0.75 * 0.9, delta=0.15)
        self.assertEqual([len(room.polygons[0].holes) for room in rooms], [1, 1])

    def test_turned_grid(self):
        yaw_rad = 0.4
        straight, turned = self.rooms_of(two_rooms())[1], self.rooms_of(two_rooms(), 3.0, -2.0, yaw_rad)[1]
        turn = np.array([[np.cos(yaw_rad), -np.sin(yaw_rad)], [np.sin(yaw_rad), np.cos(yaw_rad)]])
        for one, other in zip(straight, turned):
            self.assertEqual((one.area_m2, one.width_m, one.height_m), (other.area_m2, other.width_m, other.height_m))
            np.testing.assert_allclose(turn @ one.centre_m + (3, -2), other.centre_m)
            np.testing.assert_allclose(one.polygons[0].outer @ turn.T + (3, -2), other.polygons[0].outer)

    def test_room_turned_in_the_grid(self):
        rows, columns = np.mgrid[:160, :200]
        along, across = ((columns - 100) * 0.8 + (rows - 80) * 0.6, (rows - 80) * 0.8 - (columns - 100) * 0.6)
        cells = np.where((abs(along) < 60) & (abs(across) < 40), FREE, OCCUPIED).astype(np.uint8)
        (room,) = self.rooms_of(cells)[1]
        self.assertAlmostEqual(room.width_m, 6, delta=0.15)
        self.assertAlmostEqual(room.height_m, 4, delta=0.15)
        self.assertLess(len(room.polygons[0].outer), 40)  # of hundreds of steps

    def test_nothing_to_find(self):
        for cells in (np.zeros((0, 0)), np.zeros((5, 7)), np.full((30, 30), OCCUPIED)):
            labels, rooms = self.rooms_of(cells.astype(np.uint8))
            self.assertEqual((labels.shape, rooms), (cells.shape, []))
        self.assertEqual(find_walls(Grid(np.zeros((4, 4), np.uint8), CELL_M)), [])

    def test_free_to_the_border(self):
        _, rooms = self.rooms_of(np.full((40, 60), FREE, dtype=np.uint8))
        self.assertAlmostEqual(rooms[0].area_m2, 6, places=6)

    def test_ties_by_place_and_same_again(self):
        cells = plan(8, 8, (0.5, 0.5, 3.5, 3.5), (4.5, 0.5, 7.5, 3.5), (0.5, 4.5, 3.5, 7.5))
        first, second = self.rooms_of(cells), self.rooms_of(cells)
        np.testing.assert_array_equal(first[0], second[0])
        self.assertEqual([first[0][at] for at in ((20, 20), (20, 100), (100, 20))], [1, 2, 3])
        for one, other in zip(first[1], second[1]):
            np.testing.assert_array_equal(one.polygons[0].outer, other.polygons[0].outer)

    def test_hostile_grids(self):
        random = np.random.default_rng(3)
        for share in (0.05, 0.3, 0.6):
            cells = random.choice([UNKNOWN, FREE, OCCUPIED], (90, 110), p=[0.1, 0.9 - share, share]).astype(np.uint8)
            grid = Grid(cells, 0.1, 1.0, 2.0, -0.7)
            self.check(grid, *find_rooms(grid))
            walls = find_walls(grid)
            for wall in walls:
                self.check_polygon(wall)
            occupied_m2 = np.count_nonzero(cells == OCCUPIED) * 0.01
            self.assertAlmostEqual(sum(wall.area() for wall in walls), occupied_m2, delta=0.2 * occupied_m2)


class WallsTest(unittest.TestCase):
    def test_walls_of_two_rooms(self):
        (wall,) = find_walls(Grid(two_rooms(), CELL_M, 10.0, 20.0))
        self.assertEqual(len(wall.holes), 1)  # both rooms: the door joins them
        self.assertAlmostEqual(wall.area(), 0.1 * (2 * (3.2 + 7.1) + 2.1), places=6)
        np.testing.assert_allclose(wall.outer.min(axis=0), (10.4, 20.4))
        np.testing.assert_allclose(wall.outer.max(axis=0), (17.7, 23.6))

    def test_each_cell_is_inside_or_outside_within_half_a_cell(self):
        rows, columns = np.mgrid[:80, :80]
        ring = np.abs(np.hypot(rows - 40, columns - 40) - 30) < 4
        walls = find_walls(Grid(np.where(ring, OCCUPIED, FREE).astype(np.uint8), 1.0))
        self.assertEqual([len(wall.holes) for wall in walls], [1])
        self.assertLess(len(walls[0].outer), 60)  # of some two hundred
        for row, column in zip(rows.ravel()[::7], columns.ravel()[::7]):
            distance = abs(np.hypot(row - 40, column - 40) - 30) - 4
            if abs(distance) > 1.5:
                centre = (column + 0.5, row + 0.5)
                is_in = inside(walls[0].outer, centre) and not inside(walls[0].holes[0], centre)
                self.assertEqual(is_in, distance < 0, (row, column))

    def test_what_simplifying_would_break_stays(self):
        found = 0
        for seed in range(240, 300):  # two of them need it
            for size, share in ((24, 0.65), (12, 0.75)):
                cells = np.random.default_rng(seed).random((size, size)) < share
                walls = find_walls(Grid(np.where(cells, OCCUPIED, FREE).astype(np.uint8), 1.0))
                found += sum(num_crossings(wall) for wall in walls)
        self.assertEqual(found, 0)
        bow_tie, apart = np.array([[0, 0], [4, 4], [4, 0], [0, 4]]), np.array([[9, 9], [11, 9], [11, 11]])
        self.assertEqual(crossing_rings([apart, bow_tie]), {1})
        self.assertEqual(crossing_rings([apart, apart + (1, 0)]), {0, 1})
        self.assertEqual(crossing_rings([apart, apart + (2, 2)]), set())  # one corner is of both
        self.assertEqual(crossing_rings([apart, np.array([[10, 9], [10, 5], [12, 5]])]), {0, 1})  # a corner on a side

    def test_cells_that_touch_in_corners(self):
        cells = np.zeros((6, 6), dtype=np.uint8)
        cells[1:5, 1:5] = OCCUPIED
        cells[2, 2] = cells[3, 3] = FREE  # holes that touch each other
        cells[1, 1] = FREE  # and the outside
        cells[5, 5] = OCCUPIED  # a part of its own
        walls = find_walls(Grid(cells, 1.0))
        self.assertEqual(sorted(round(wall.area()) for wall in walls), [1, 12])  # half a cell off at the notch
        self.assertEqual(sorted(len(wall.holes) for wall in walls), [0, 2])


if __name__ == "__main__":
    unittest.main()
