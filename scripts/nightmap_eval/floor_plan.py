# SPDX-License-Identifier: Apache-2.0
"""The floor plan of a site as features in the map frame: rooms, walls, the way of the recording, the planned path, boxes of things."""

from dataclasses import dataclass, field
from itertools import groupby

import numpy as np

from nightmap_eval.grid import read_grid
from nightmap_eval.polygons import Polygon
from nightmap_eval.rooms import find_rooms, find_walls

FLOOR_REACH_M = 0.5  # what is above a floor begins at most so far below it


@dataclass
class Feature:
    """shape: a Polygon, or the points (n, 2) of a line. height_m: of the floor. label_m: where its text stands."""

    kind: str
    floor: int
    height_m: float
    shape: Polygon | np.ndarray
    figures: dict = field(default_factory=dict)
    label: str = ""
    label_m: tuple = ()


def floors_at(floors, heights_m, reach_m=FLOOR_REACH_M):
    """For each height the highest of floors.json's floors that is not above it by more than reach_m, else the lowest: floors by height, and
    indices in them."""
    by_height = sorted(floors, key=lambda floor: floor["height_m"])
    above = np.searchsorted([floor["height_m"] for floor in by_height], np.asarray(heights_m) + reach_m, side="right")
    return by_height, np.maximum(above - 1, 0)


def floor_at(floors, z_m):
    by_height, index = floors_at(floors, z_m)
    return by_height[int(index)]


def floor_features(floor, grid):
    """The rooms and walls of a floor."""
    place = (floor["number"], floor["height_m"])
    for room in find_rooms(grid)[1]:
        figures = {"number": room.number, "name": f"room {room.number}", "area_m2": round(room.area_m2, 3),
                   "long_side_m": round(room.width_m, 3), "short_side_m": round(room.height_m, 3)}  # fmt: skip
        for part, polygon in enumerate(sorted(room.polygons, key=lambda polygon: -polygon.area())):
            text = "" if part else f"{room.number}: {room.area_m2:.1f} m2"
            yield Feature("room", *place, polygon, figures | {"part": part + 1}, text, room.centre_m)
    for number, polygon in enumerate(find_walls(grid), 1):
        yield Feature("wall", *place, polygon, {"number": number, "name": f"wall {number}", "area_m2": round(polygon.area(), 3)})


def way_features(kind, points_m, floors_of_points):
    """Lines of a way (n, 2), one for each stretch on one floor; a single point is no line."""
    stretches = [[i for i, _ in group] for _, group in groupby(enumerate(floors_of_points), lambda item: item[1]["number"])]
    for number, stretch in enumerate((stretch for stretch in stretches if len(stretch) > 1), 1):
        floor = floors_of_points[stretch[0]]
        yield Feature(kind, floor["number"], floor["height_m"], points_m[stretch], {"number": number, "name": f"{kind} {number}"})


def thing_features(things, floors):
    """Boxes of things, seen from above."""
    for number, thing in enumerate(things, 1):
        bottom_m, top_m = thing.box.centre_m[2] + np.array([-1, 1]) * thing.box.half_size_m[2]
        floor, polygon = floor_at(floors, bottom_m), Polygon(thing.box.corners_m())
        figures = {"number": number, "name": thing.name, "class": thing.class_name, "area_m2": round(polygon.area(), 3),
                   "bottom_m": round(float(bottom_m), 3), "top_m": round(float(top_m), 3)}  # fmt: skip
        yield Feature("thing", floor["number"], floor["height_m"], polygon, figures, thing.name, tuple(thing.box.centre_m[:2]))


def grids_of(site, floors):
    """(floor, its grid) of all floors."""
    for floor in floors:
        yield floor, read_grid(site.folder_of("grid") / floor["yaml"])
