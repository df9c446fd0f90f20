# SPDX-License-Identifier: Apache-2.0
"""Occupancy grids in the ROS map_server format (PGM + YAML), and their comparison with a plan."""

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import yaml

from nightmap_site.checked_reading import REMEDY, read_text, using
from nightmap_site.receipts import WrittenFiles
from nightmap_site.script_errors import DataError

UNKNOWN, FREE, OCCUPIED = 0, 1, 2


@dataclass
class Grid:
    """cells[row, column], row 0 at the bottom: cell (r, c) covers resolution * [c, c+1) x [r, r+1)
    in the grid's frame, which is turned by origin_yaw_rad and then moved by the origin."""

    cells: np.ndarray
    resolution_m: float
    origin_x_m: float = 0.0
    origin_y_m: float = 0.0
    origin_yaw_rad: float = 0.0

    def from_cells(self, columns, rows):
        """Points (..., 2) in the map frame; (0, 0) is the lower left corner of the first cell."""
        x, y = columns * self.resolution_m, rows * self.resolution_m
        cos, sin = np.cos(self.origin_yaw_rad), np.sin(self.origin_yaw_rad)
        return np.stack([cos * x - sin * y + self.origin_x_m, sin * x + cos * y + self.origin_y_m], axis=-1)

    def centres_m(self):
        """Centres (rows, columns, 2) of all cells in the map frame."""
        rows, columns = self.cells.shape
        return self.from_cells(*np.meshgrid(np.arange(columns) + 0.5, np.arange(rows) + 0.5))

    def indices(self, points_m):
        """Row and column of points (n, 2); out of range when outside."""
        x, y = points_m[:, 0] - self.origin_x_m, points_m[:, 1] - self.origin_y_m
        cos, sin = np.cos(self.origin_yaw_rad), np.sin(self.origin_yaw_rad)
        u, v = cos * x + sin * y, -sin * x + cos * y
        column = np.floor(u / self.resolution_m).astype(int)
        return np.floor(v / self.resolution_m).astype(int), column

    def extent_m(self):
        """left, right, bottom, top for matplotlib, before the rotation about the origin."""
        rows, columns = self.cells.shape
        x, y = self.origin_x_m, self.origin_y_m
        return x, x + columns * self.resolution_m, y, y + rows * self.resolution_m


def read_pgm(path):
    """8-bit gray image (rows, columns), top row first. Raises DataError when truncated."""
    data = Path(path).read_bytes()
    header = re.match(rb"P5(?:\s+|\s*#[^\n]*\n)+(\d{1,9})\s+(?:#[^\n]*\n\s*)*(\d{1,9})\s+(\d{1,9})\s", data)
    if not header:
        raise DataError(f"{path}: not a binary PGM (P5) image; {REMEDY}")
    width, height, top = (int(word) for word in header.groups())
    pixels = np.frombuffer(data, np.uint8, offset=header.end())
    if top != 255 or len(pixels) != width * height:
        raise DataError(f"{path}: {len(pixels)} pixels of {width}x{height}, largest value {top}; {REMEDY}")
    return pixels.reshape(height, width)


def read_grid(yaml_path):
    with using(yaml_path):
        try:
            keys = yaml.load(read_text(yaml_path), yaml.BaseLoader)  # every value is text: PyYAML takes 1e-05 for no number
        except yaml.YAMLError as error:
            raise ValueError(" ".join(str(error).split())) from None
        image = Path(yaml_path).parent / Path(keys["image"]).name
        resolution_m, x, y, yaw = map(float, (keys["resolution"], *keys["origin"]))
        occupied, free = float(keys.get("occupied_thresh", 0.65)), float(keys.get("free_thresh", 0.196))
        negate = int(keys.get("negate", 0))
        if not (0 < resolution_m < np.inf and np.all(np.isfinite([x, y, yaw]))):
            raise ValueError("resolution or origin is not a valid length")
    written = WrittenFiles()
    for path in (yaml_path, image):
        written.require(path)
    gray = read_pgm(image)[::-1].astype(float)
    occupancy = gray / 255 if negate else (255 - gray) / 255
    cells = np.full(gray.shape, UNKNOWN, dtype=np.uint8)
    cells[occupancy < free] = FREE
    cells[occupancy > occupied] = OCCUPIED
    return Grid(cells, resolution_m, x, y, yaw)


def _near(plan, state, rows, columns, radius):
    """Whether the plan has a cell of the state within `radius` cells of each (row, column)."""
    found = np.zeros(len(rows), dtype=bool)
    height, width = plan.cells.shape
    for step_r in range(-radius, radius + 1):
        for step_c in range(-radius, radius + 1):
            r, c = rows + step_r, columns + step_c
            inside = (r >= 0) & (r < height) & (c >= 0) & (c < width)
            found[inside] |= plan.cells[r[inside], c[inside]] == state
    return found


def compare_with_plan(grid, plan, building_from_map):
    """Percentage of the grid's seen cells that are right within one cell of the exact plan.

    A cell is right when the plan has a cell of its state among its own cell there and the eight
    around it. A cell outside the plan is wrong."""
    centres = grid.centres_m().reshape(-1, 2)
    points = np.column_stack([centres, np.zeros(len(centres))])
    rows, columns = plan.indices(building_from_map.apply(points)[:, :2])
    radius = max(1, round(grid.resolution_m / plan.resolution_m))
    states, figures, num_right_all = grid.cells.ravel(), {}, 0
    for name, state in (("free", FREE), ("occupied", OCCUPIED)):
        chosen = states == state
        right = _near(plan, state, rows[chosen], columns[chosen], radius)
        num, num_right = int(np.count_nonzero(chosen)), int(np.count_nonzero(right))
        figures[f"num_{name}_cells"] = num
        figures[f"{name}_right_percent"] = 100 * num_right / num if num else None
        num_right_all += num_right
    num_seen = figures["num_free_cells"] + figures["num_occupied_cells"]
    figures["seen_right_percent"] = 100 * num_right_all / num_seen if num_seen else None
    figures["tolerance_m"] = radius * plan.resolution_m
    return figures
