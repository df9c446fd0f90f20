# SPDX-License-Identifier: Apache-2.0
"""Things of a map, things.json (pipeline/io/things_io.h): upright boxes, and how much two of them overlap."""

from dataclasses import dataclass

import numpy as np

from nightmap_site.checked_reading import NUMBER, REMEDY, read_object
from nightmap_site.script_errors import DataError

VIEW = {"time_ns": int, "color_path": str, "rectangle_px": [int]}
THING = {"name": str, "class": str, "x_m": NUMBER, "y_m": NUMBER, "heading_rad": NUMBER, "bottom_m": NUMBER, "size_m": [NUMBER],
         "num_views": int, "confidence": NUMBER, "?best_view": VIEW}  # fmt: skip
SIGNS = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])  # of the corners, counter-clockwise


@dataclass
class UprightBox:
    """A box that is turned about z alone."""

    centre_m: np.ndarray  # (3,)
    half_size_m: np.ndarray  # (3,), along its own axes
    heading_rad: float  # of its x axis

    def axes(self):
        """Rows: its x and y axis, in the plane."""
        cos, sin = np.cos(self.heading_rad), np.sin(self.heading_rad)
        return np.array([[cos, sin], [-sin, cos]])

    def corners_m(self):
        """The footprint (4, 2), counter-clockwise."""
        return self.centre_m[:2] + (SIGNS * self.half_size_m[:2]) @ self.axes()

    def to_own_axes(self, points_m):
        """Points (n, 3) relative to its centre, along its axes."""
        offsets = np.asarray(points_m, float) - self.centre_m
        return np.column_stack([offsets[:, :2] @ self.axes().T, offsets[:, 2]])

    def volume_m3(self):
        return float(np.prod(2 * self.half_size_m))

    def moved(self, target_from_source):
        """The box in another frame whose z axis is up too."""
        turn = np.arctan2(target_from_source.rotation[1, 0], target_from_source.rotation[0, 0])
        centre_m = target_from_source.apply(self.centre_m[None])[0]
        return UprightBox(centre_m, self.half_size_m, self.heading_rad + float(turn))


@dataclass
class Thing:
    name: str
    class_name: str
    box: UprightBox  # in the map frame; its x axis points out of the front
    num_views: int
    confidence: float  # of its class, 0 .. 1
    color_path: str  # of the picture that shows it best; "" without one
    rectangle_px: tuple  # left, top, and behind the last column and row


def read_things(site):
    """The things that the job `things` found; None where it did not run."""
    path = site.made("things", "things")
    if path is None:
        return None
    content = read_object(path, {"format": str, "version": int, "things": [THING]})
    if (content["format"], content["version"]) != ("nightmap_things", 1):
        raise DataError(f"{path}: not a list of things of this version; {REMEDY}")
    return [_thing(path, entry) for entry in content["things"]]


def _thing(path, entry):
    view = entry.get("best_view", {"color_path": "", "rectangle_px": [0, 0, 1, 1]})
    size_m = np.array(entry["size_m"], float)
    if size_m.shape != (3,) or not (size_m > 0).all() or len(view["rectangle_px"]) != 4:
        raise DataError(f"{path}: thing '{entry['name'][:80]}': not a valid size or rectangle; {REMEDY}")
    centre_m = np.array([entry["x_m"], entry["y_m"], entry["bottom_m"] + size_m[2] / 2], float)
    box = UprightBox(centre_m, size_m / 2, float(entry["heading_rad"]))
    return Thing(entry["name"], entry["class"], box, entry["num_views"], float(entry["confidence"]), view["color_path"],
                 tuple(view["rectangle_px"]))  # fmt: skip


def iou(a, b):
    """Intersection over union of two boxes, exactly."""
    low_m = max(a.centre_m[2] - a.half_size_m[2], b.centre_m[2] - b.half_size_m[2])
    high_m = min(a.centre_m[2] + a.half_size_m[2], b.centre_m[2] + b.half_size_m[2])
    both = max(0.0, float(high_m - low_m))
    if both > 0:  # of footprints what lies in both (Sutherland and Hodgman, 1974)
        polygon, convex = a.corners_m(), b.corners_m()
        for start, end in zip(convex, np.roll(convex, -1, axis=0)):
            polygon = _left_of(polygon, start, end - start)
        both *= _area(polygon)
    union = a.volume_m3() + b.volume_m3() - both
    return both / union if union > 0 else 0.0


def _left_of(polygon, start, along):
    """The part of a polygon to the left of a line."""
    kept = []
    sides = [along[0] * (y - start[1]) - along[1] * (x - start[0]) for x, y in polygon]
    for i, point in enumerate(polygon):
        if sides[i - 1] * sides[i] < 0:
            share = sides[i - 1] / (sides[i - 1] - sides[i])
            kept.append(polygon[i - 1] + share * (point - polygon[i - 1]))
        if sides[i] >= 0:
            kept.append(point)
    return kept


def _area(polygon):
    if len(polygon) < 3:
        return 0.0
    x, y = np.transpose(polygon)
    return float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)) / 2)
