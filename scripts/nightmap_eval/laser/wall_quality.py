# SPDX-License-Identifier: Apache-2.0
"""Quality of a grid's walls by measurements that need no truth: how thick they are, and how many are drawn twice.

A map whose poses are wrong smears its walls, or draws one wall at two places. Both show in the grid alone:

- *Wall cell*: an occupied cell on a straight piece of wall. The occupied cells within RADIUS_M that hang together with it
  (with gaps of at most one cell) give the direction by their principal axes; the smaller variance is at most
  MAX_VARIANCE_RATIO of the larger, and the piece is at least MIN_PIECE_M long. Corners and clutter are no wall cells.
- *Thickness*: along the wall's normal through the cell, the distance between the first and the last cell of the run of
  occupied cells, plus one, in cells. A wall of one cell has thickness 1, oblique too; a line that is drawn through all
  cells that it touches has up to 2 where it is oblique.
- *Doubled*: beside a wall cell whose wall is at least MIN_LENGTH_M long, along the normal on either side, another such
  wall begins that is parallel (MAX_TURN_DEG), its face NEAR_M to FAR_M from this wall's, and at least half of the cells
  between are free. Beams went through where the other drawing is. Between the two faces of a real partition the cells
  are unknown, so it does not count. Furniture along a wall does, when a scanner sees the gap behind it.
"""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import binary_propagation

from nightmap_eval.grid import FREE, OCCUPIED, UNKNOWN
from nightmap_eval.metrics_json import WALL_KEYS
from nightmap_eval.trajectory_errors import statistics

RADIUS_M = 0.5
MIN_PIECE_M = 0.5
MAX_VARIANCE_RATIO = 0.15
MAX_THICKNESS_M = 1.0
MIN_LENGTH_M = 1.0
MAX_HOLE_M = 0.1  # in a wall that counts as one
NEAR_M, FAR_M = 0.1, 0.4
MAX_TURN_DEG = 15
CHUNK = 4096  # cells at a time: bounds the memory
EPSILON = 1e-9


@dataclass
class WallCells:
    cells: np.ndarray  # (n, 2) row, column
    along: np.ndarray  # (n, 2) unit direction of the wall, in rows and columns

    def normals(self):
        return np.stack([-self.along[:, 1], self.along[:, 0]], axis=1)


def wall_metrics(grid):
    """Figures of the wall cells of a grid; percentages and thickness are None without any."""
    walls = wall_cells(grid)
    figures = {"num_occupied_cells": int(np.count_nonzero(grid.cells == OCCUPIED)), "num_wall_cells": len(walls.cells)}
    if len(walls.cells) == 0:
        return figures | dict.fromkeys(WALL_KEYS)
    return figures | {**statistics(thickness_cells(grid, walls), "thickness_{}_cells", "mean", "median", "p90"),
                      "doubled_percent": 100 * float(np.mean(doubled(grid, walls)))}  # fmt: skip


def wall_cells(grid):
    """The WallCells of a grid, in the order of rows."""
    occupied = grid.cells == OCCUPIED
    cells = np.argwhere(occupied)
    if len(cells) == 0:
        return WallCells(cells, np.zeros((0, 2)))
    radius = max(2, round(RADIUS_M / grid.resolution_m))
    found = [_straight(occupied, part, radius, grid.resolution_m) for part in np.array_split(cells, 1 + len(cells) // CHUNK)]
    is_wall, along = (np.concatenate(parts) for parts in zip(*found))
    return WallCells(cells[is_wall], along[is_wall])


def _straight(occupied, cells, radius, resolution_m):
    """Whether the piece of wall around each cell is straight and long enough, and its direction."""
    windows = np.lib.stride_tricks.sliding_window_view(np.pad(occupied, radius), (2 * radius + 1,) * 2)
    offsets = np.arange(-radius, radius + 1)
    disc = offsets[:, None] ** 2 + offsets**2 <= radius**2
    piece = _hanging_together(windows[cells[:, 0], cells[:, 1]] & disc).astype(float)
    count = piece.sum(axis=(1, 2))
    by_row, by_column = piece.sum(axis=2), piece.sum(axis=1)
    mean_row, mean_column = by_row @ offsets / count, by_column @ offsets / count
    rr = by_row @ offsets**2 / count - mean_row**2
    cc = by_column @ offsets**2 / count - mean_column**2
    rc = np.einsum("nij,i,j->n", piece, offsets, offsets) / count - mean_row * mean_column
    values, vectors = np.linalg.eigh(np.stack([np.stack([rr, rc], -1), np.stack([rc, cc], -1)], -2))
    along = vectors[:, :, 1]
    # n cells in a row have variance (n^2 - 1) / 12.
    length_m = np.sqrt(12 * np.maximum(values[:, 1], 0) + 1) * resolution_m
    is_straight = values[:, 0] <= MAX_VARIANCE_RATIO * values[:, 1]
    return is_straight & (length_m >= MIN_PIECE_M - EPSILON), along


def _hanging_together(patches):
    """The part of each patch (n, k, k) that hangs together with its middle, with gaps of one cell at most."""
    middle = np.zeros_like(patches)
    middle[:, patches.shape[1] // 2, patches.shape[2] // 2] = True
    return binary_propagation(middle & patches, np.ones((1, 5, 5)), patches)


def _at(values, cells, outside):
    """Values at cells (..., 2), of which some may be outside."""
    rows, columns = cells[..., 0], cells[..., 1]
    inside = (rows >= 0) & (rows < values.shape[0]) & (columns >= 0) & (columns < values.shape[1])
    return np.where(inside, values[np.where(inside, rows, 0), np.where(inside, columns, 0)], outside)


def _steps(directions):
    """Directions that advance by one whole cell along the axis nearest to them, and the length of such a step in cells."""
    lengths = 1 / np.max(np.abs(directions), axis=1)
    return directions * lengths[:, None], lengths


def _nearest_axes(directions):
    """One cell along the axis that is nearest to each direction: a diagonal step would pass between the cells of a diagonal."""
    cells = np.zeros(directions.shape, dtype=int)
    cells[np.arange(len(cells)), np.argmax(np.abs(directions), axis=1)] = 1
    return cells


def _lines(cells, directions, ks):
    """Cells (n, k, 2) on the lines through each cell: step k along its direction."""
    return cells[:, None] + np.rint(ks[None, :, None] * directions[:, None]).astype(int)


def _run_ends(grid, cells, steps, max_steps):
    """How many occupied cells follow each cell without a gap, along its line."""
    states = _at(grid.cells, _lines(cells, steps, np.arange(1, max_steps + 1)), UNKNOWN)
    return np.cumprod(states == OCCUPIED, axis=1).sum(axis=1)


def thickness_cells(grid, walls):
    steps, lengths = _steps(walls.normals())
    max_steps = max(1, round(MAX_THICKNESS_M / grid.resolution_m))
    return 1 + lengths * (_run_ends(grid, walls.cells, steps, max_steps) + _run_ends(grid, walls.cells, -steps, max_steps))


def _is_long(grid, walls):
    """Whether the wall goes on for MIN_LENGTH_M at each wall cell, straight within a cell, with holes of MAX_HOLE_M at most."""
    steps, lengths = _steps(walls.along)
    across = _nearest_axes(walls.normals())
    max_steps = max(1, round(MIN_LENGTH_M / grid.resolution_m))
    max_hole = max(1, round(MAX_HOLE_M / grid.resolution_m))
    reach = np.zeros(len(walls.cells), dtype=int)
    for sign in (1, -1):
        line = _lines(walls.cells, sign * steps, np.arange(1, max_steps + 1))
        present = np.zeros(line.shape[:2], dtype=bool)
        for side in (-1, 0, 1):
            present |= _at(grid.cells, line + side * across[:, None], UNKNOWN) == OCCUPIED
        last, is_open = np.zeros(len(reach), dtype=int), np.ones(len(reach), dtype=bool)
        for k in range(1, max_steps + 1):
            is_open &= k - last <= max_hole + 1
            last[is_open & present[:, k - 1]] = k
        reach += last
    return (reach * lengths + 1) * grid.resolution_m >= MIN_LENGTH_M - EPSILON


def doubled(grid, walls):
    """Whether a second drawing of the same wall lies beside each wall cell."""
    index = np.full(grid.cells.shape, -1, dtype=np.int32)
    index[tuple(walls.cells.T)] = np.arange(len(walls.cells))
    is_long = _is_long(grid, walls)
    steps, lengths = _steps(walls.normals())
    found = np.zeros(len(walls.cells), dtype=bool)
    for sign in (1, -1):
        found |= _doubled_on_side(grid, walls, is_long, index, sign * steps, lengths)
    return found & is_long


def _doubled_on_side(grid, walls, is_long, index, steps, lengths):
    face = _run_ends(grid, walls.cells, steps, max(1, round(MAX_THICKNESS_M / grid.resolution_m)))
    beyond = np.arange(1, 1 + int(np.ceil(FAR_M / grid.resolution_m)))  # steps from the face of this wall
    line = walls.cells[:, None] + np.rint((face[:, None] + beyond)[..., None] * steps[:, None]).astype(int)
    states, others = _at(grid.cells, line, UNKNOWN), _others(index, line, walls.along)
    is_wall = others >= 0
    is_face = is_wall & np.diff(is_wall, axis=1, prepend=False)
    before = np.concatenate([np.zeros_like(states[:, :1], dtype=bool), states[:, :-1] != OCCUPIED], axis=1)
    is_free = np.concatenate([np.zeros_like(before[:, :1]), states[:, :-1] == FREE], axis=1)
    num_free, num_between = np.cumsum(is_free, axis=1), np.cumsum(before, axis=1)
    distance_m = beyond * lengths[:, None] * grid.resolution_m
    is_near = (distance_m >= NEAR_M - EPSILON) & (distance_m <= FAR_M + EPSILON)
    cosine = np.abs(np.einsum("nd,nkd->nk", walls.along, walls.along[others]))
    is_parallel = (cosine >= np.cos(np.radians(MAX_TURN_DEG))) & is_long[others]
    is_seen_between = (2 * num_free >= num_between) & (num_free > 0)
    return np.any(is_face & is_near & is_parallel & is_seen_between, axis=1)


def _others(index, line, along):
    """Number of the wall cell at each cell of the lines (n, k, 2), or beside it along the wall: a diagonal line of cells slips
    through a diagonal wall. -1: none."""
    here = _at(index, line, -1)
    return np.where(here >= 0, here, _at(index, line + _nearest_axes(along)[:, None], -1))
