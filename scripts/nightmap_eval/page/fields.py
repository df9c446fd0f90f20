# SPDX-License-Identifier: Apache-2.0
"""Fields of the plan, known place by place: room around the robot, who saw it, how sure it is, how thick surfaces are there."""

from dataclasses import dataclass

import numpy as np

from nightmap_eval.artifacts import read_csv, read_hdf5, read_landmarks
from nightmap_site.checked_reading import using
from nightmap_site.unit_lists import read_tiles, whole

CELL_M = 0.25  # of fields of landmarks
SURFACE_REACH_M = 0.1  # lower points belong to the ceiling of the floor below
STRAY_M = 5.0
PLACE_COLUMNS = ("x_m", "y_m", "z_m", "num_flat", "thickness_m", "num_rays", "num_rays_agreeing")
MIN_FLAT, MIN_RAYS = 20, 5  # points and rays that a place needs to be judged


@dataclass
class Field:
    """values[row, column], row 0 at the smallest y, NaN where nothing is known; shown between least and most."""

    name: str
    floor: int
    values: np.ndarray
    resolution_m: float
    origin_m: tuple  # x, y of the lower left corner
    yaw_rad: float
    least: float
    most: float
    unit: str
    colors: str = "viridis"

    def title(self):
        return f"{self.name}, {self.least:g} to {self.most:g} {self.unit}".rstrip()


def fields(site, plan):
    """The fields of a site, each on one floor."""
    return [*_clearance(site, plan), *_landmarks(site, plan), *_places(site, plan)]


def _of_floors(plan, positions_m):
    """(floor, mask) of the surfaces and landmarks on each floor, without those that lie far from all that it holds: one that went astray
    would make the field large."""
    numbers = plan.numbers_at(positions_m[:, 2], SURFACE_REACH_M)
    for floor in sorted(set(numbers.tolist())):
        low, high = plan.bounds_m(floor)
        chosen = (numbers == floor) & (positions_m[:, :2] > low - STRAY_M).all(axis=1) & (positions_m[:, :2] < high + STRAY_M).all(axis=1)
        if chosen.any():
            yield floor, chosen


def _clearance(site, plan):
    path = site.made("grid", "distances")
    for floor in plan.floors if path else []:
        if "distances" not in floor:
            continue
        (values,) = read_hdf5(path, f"{floor['distances']}/clearance_m")
        grid = plan.grids[floor["number"]]
        with using(path):
            if values.shape != grid.cells.shape:
                raise ValueError(f"{values.shape} cells of clearance, {grid.cells.shape} of {floor['yaml']}")
        values = np.where(values > 0, values, np.nan)
        yield Field("distance to obstacles", floor["number"], values, grid.resolution_m, (grid.origin_x_m, grid.origin_y_m), grid.origin_yaw_rad,
                    0, 1.5, "m")  # fmt: skip


def _landmarks(site, plan):
    """Keyframes that saw a place, and the median standard deviation of its landmarks."""
    path = site.made("landmarks", "landmarks")
    if not path:
        return
    positions_m, sigmas_m, offsets, keyframes = read_landmarks(
        path, "landmarks/position_in_map_m", "landmarks/position_sigma_m", "observations/offsets", "observations/keyframe_idx")
    with using(path):
        counts = np.diff(offsets.ravel())
        landmark_of = np.repeat(np.arange(len(positions_m)), counts)
        if len(landmark_of) != len(keyframes):
            raise ValueError("offsets and observations do not fit each other")
    for floor, chosen in _of_floors(plan, positions_m):
        cells = Cells(positions_m[chosen, :2], CELL_M)
        seen = chosen[landmark_of]
        cell_of = np.full(len(positions_m), -1, dtype=np.int64)
        cell_of[chosen] = cells.indices
        num_keyframes = int(keyframes.max(initial=0)) + 1
        pairs = np.unique(cell_of[landmark_of[seen]] * num_keyframes + keyframes.ravel()[seen])
        saw = np.bincount(pairs // num_keyframes, minlength=cells.size).astype(float)
        yield cells.field("keyframes that saw it", floor, np.where(saw > 0, saw, np.nan), 0, 50, "")
        yield cells.field("uncertainty of landmarks", floor, 100 * cells.median(sigmas_m.ravel()[chosen]), 0, 10, "cm", "inferno")


def read_places(site):
    """Columns of places_X_Y.csv of all tiles: name -> array; None where there are none."""
    if not site.made("tiles", "tiles"):
        return None
    paths = (site.made("point_cloud", "places", tile) for tile in whole(read_tiles, site.folder))
    rows = [row for path in paths if path for row in read_csv(path, PLACE_COLUMNS)]
    if not rows:
        return None
    with using(site.folder_of("point_cloud")):
        return {name: np.array([float(row[name] or "nan") for row in rows]) for name in PLACE_COLUMNS}


def _places(site, plan):
    places = read_places(site)
    if places is None:
        return
    positions_m = np.column_stack([places[f"{axis}_m"] for axis in "xyz"])
    for floor, chosen in _of_floors(plan, positions_m):
        cells = Cells(positions_m[chosen, :2], 0.5)
        flat, rays = (places["num_flat"] >= MIN_FLAT)[chosen], (places["num_rays"] >= MIN_RAYS)[chosen]
        yield cells.field("thickness of surfaces", floor, 100 * cells.most(places["thickness_m"][chosen], flat), 0, 5, "cm", "inferno")
        share = cells.sums(places["num_rays_agreeing"][chosen] * rays) / np.maximum(cells.sums(places["num_rays"][chosen] * rays), 1)
        yield cells.field("held-out rays that agree", floor, np.where(cells.sums(rays) > 0, 100 * share, np.nan), 50, 100, "%")


class Cells:
    """Squares of the plan that points (n, 2) lie in."""

    def __init__(self, points_m, cell_m):
        self.cell_m = cell_m
        keys = np.floor(points_m / cell_m).astype(int)
        self.low = keys.min(axis=0)
        self.columns, self.rows = (keys.max(axis=0) - self.low + 1).tolist()
        self.size = self.rows * self.columns
        self.indices = (keys[:, 1] - self.low[1]) * self.columns + keys[:, 0] - self.low[0]

    def sums(self, values):
        return np.bincount(self.indices, weights=np.nan_to_num(values), minlength=self.size)

    def most(self, values, is_used):
        found = np.full(self.size, -np.inf)
        np.maximum.at(found, self.indices[is_used], values[is_used])
        return np.where(np.isfinite(found), found, np.nan)

    def median(self, values):
        order = np.lexsort((values, self.indices))
        cells, starts, counts = np.unique(self.indices[order], return_index=True, return_counts=True)
        found = np.full(self.size, np.nan)
        found[cells] = values[order][starts + counts // 2]
        return found

    def field(self, name, floor, values, least, most, unit, colors="viridis"):
        origin_m = tuple((self.low * self.cell_m).tolist())
        return Field(name, floor, values.reshape(self.rows, self.columns), self.cell_m, origin_m, 0.0, least, most, unit, colors)
