# SPDX-License-Identifier: Apache-2.0
"""A made-up office floor of many different rooms as a grid, and what a laser scans in it. Pure; equal seeds give equal floors.

The grid's frame is the map: x to the right and y up from the lower left corner of cell (0, 0), metres and radians.
"""

import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent))

import checkout  # noqa: E402, F401  first: it makes the packages of scripts/ importable
from nightmap_eval.grid import FREE, OCCUPIED, UNKNOWN, Grid  # noqa: E402

RESOLUTION_M = 0.05
ROOM_M, CORRIDOR_M, DOOR_M = (4.0, 8.0), 2.0, 0.9
BOX_M, NUM_BOXES = (0.4, 1.8), (3, 7)  # furniture of a room: sides, how many at most
ROBOT_M = 0.3  # half the side of the square that is free about a pose
STEP_M = 0.01


@dataclass
class Laser:
    """The beams of a scanner: beam i points at first_rad + i * step_rad from x."""

    first_rad: float = -np.radians(135)
    step_rad: float = np.radians(0.75)
    num_beams: int = 361
    limit_m: float = 30.0
    noise_m: float = 0.01

    def angles_rad(self):
        return self.first_rad + self.step_rad * np.arange(self.num_beams)


def cells_of(length_m):
    return round(length_m / RESOLUTION_M)


def lengths(random, total):
    """Cells of rooms one behind the other, with the wall after each; they fill `total`. The last one takes what is left."""
    least, most = (cells_of(length_m) for length_m in ROOM_M)
    result = []
    while total - sum(result) > most + least:
        result.append(int(random.integers(least, most + 1)))
    return [*result, total - sum(result)]


def draw_box(cells, row, column, height, width):
    """A wall about what no scan sees."""
    cells[row : row + height, column : column + width] = OCCUPIED
    cells[row + 1 : row + height - 1, column + 1 : column + width - 1] = UNKNOWN


def furnish(cells, random):
    """Boxes anywhere in a room, a view of the cells between its walls."""
    for _ in range(random.integers(*NUM_BOXES)):
        height, width = (cells_of(side_m) for side_m in random.uniform(*BOX_M, 2))
        row, column = (random.integers(size - side + 1) for size, side in zip(cells.shape, (height, width)))
        draw_box(cells, row, column, height, width)


def draw_rooms(cells, random, door_row):
    """Rooms side by side in a strip whose rim is wall, each with a door in its row `door_row`."""
    begin, height = 0, cells.shape[0]
    for width in lengths(random, cells.shape[1]):
        cells[:, min(begin + width, cells.shape[1]) - 1] = OCCUPIED
        furnish(cells[1 : height - 1, begin + 1 : begin + width - 1], random)
        door = begin + 1 + random.integers(width - 2 - cells_of(DOOR_M))
        cells[door_row, door : door + cells_of(DOOR_M)] = FREE
        begin += width


def strips(random, total):
    """(first row, rows) of strips of rooms from bottom to top, two and two with a corridor between them; they fill `total`."""
    corridor, middle = cells_of(CORRIDOR_M), cells_of(sum(ROOM_M) / 2)
    num_pairs = max(1, round(total / (2 * middle + corridor)))
    weights = random.uniform(0.85, 1.15, 2 * num_pairs)
    ends = np.round(np.cumsum(weights) / weights.sum() * (total - num_pairs * corridor)).astype(int)
    gaps = corridor * ((np.arange(2 * num_pairs) + 1) // 2)
    begins = np.concatenate([[0], ends[:-1]])
    return [(int(begin + gap), int(end - begin)) for begin, end, gap in zip(begins, ends, gaps)]


def make_floor(area_m2, seed):
    """A square floor of about this area. Its corridors open into one along the left side, so that all is one building."""
    random = np.random.default_rng(seed)
    size = cells_of(np.sqrt(area_m2))
    cells = np.full((size, size), FREE, dtype=np.uint8)
    left = cells_of(CORRIDOR_M)
    for i, (row, height) in enumerate(strips(random, size)):
        strip = cells[row : row + height, left:]
        for edge in (strip[0], strip[-1], strip[:, 0]):
            edge[:] = OCCUPIED
        draw_rooms(strip, random, door_row=-1 if i % 2 == 0 else 0)
    for edge in (cells[0], cells[-1], cells[:, 0], cells[:, -1]):
        edge[:] = OCCUPIED
    return Grid(cells, RESOLUTION_M)


def is_roomy(free, row, column):
    """Whether the robot stands clear of everything at a cell."""
    half = cells_of(ROBOT_M)
    around = free[max(row - half, 0) : row + half + 1, max(column - half, 0) : column + half + 1]
    return around.size == (2 * half + 1) ** 2 and bool(around.all())


def free_poses(grid, num, random):
    """x, y, heading (num, 3), evenly drawn where the robot has room."""
    free = grid.cells == FREE
    places, poses = np.argwhere(free), []
    while len(poses) < num:
        row, column = places[random.integers(len(places))]
        if is_roomy(free, row, column):
            y, x = ((row, column) + random.uniform(0, 1, 2)) * grid.resolution_m
            poses.append((x, y, random.uniform(-np.pi, np.pi)))
    return np.array(poses)


def scan(grid, pose, laser, random):
    """Ranges (m) of the beams, float32: to the first occupied cell, with noise; 0 where there is none within the limit."""
    angles_rad = pose[2] + laser.angles_rad()
    along_m = np.arange(STEP_M, laser.limit_m, STEP_M)
    rows = np.floor((pose[1] + np.outer(np.sin(angles_rad), along_m)) / grid.resolution_m).astype(int)
    columns = np.floor((pose[0] + np.outer(np.cos(angles_rad), along_m)) / grid.resolution_m).astype(int)
    height, width = grid.cells.shape
    inside = (rows >= 0) & (rows < height) & (columns >= 0) & (columns < width)
    hit = inside & (grid.cells[rows.clip(0, height - 1), columns.clip(0, width - 1)] == OCCUPIED)
    range_m = along_m[hit.argmax(axis=1)] + laser.noise_m * random.standard_normal(laser.num_beams)
    return np.where(hit.any(axis=1), range_m.clip(min=STEP_M), 0).astype(np.float32)
