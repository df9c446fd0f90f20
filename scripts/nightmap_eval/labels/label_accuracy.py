# SPDX-License-Identifier: Apache-2.0
"""Compares the classes of voxels with those of a made-up building.

A voxel's true class is that of the surface nearest to its centre. The edge of a table before a wall has voxels with both in them, of
which either class is right: so a second share takes every class for right whose surface is certainly in the voxel.
"""

from dataclasses import dataclass

import numpy as np

from nightmap_eval.things import UprightBox
from nightmap_eval.labels.voxel_labels import read_voxel_labels
from nightmap_eval.trajectory import FRAME_GAP_NS, associate, read_truth, read_tum, umeyama
from nightmap_eval.walls_and_doors import RECORD_AGAIN, truth_folder
from nightmap_site.checked_reading import NUMBER, read_object
from nightmap_site.script_errors import DataError

FURNITURE = ("table", "chair", "shelf", "cabinet", "bed", "sofa")
MAX_DISTANCE_VOXELS = 1.5  # farther off there is nothing that the voxel could be
HALF_EDGE_VOXELS = 0.5  # a surface so near is in the voxel
HALF_DIAGONAL_VOXELS = np.sqrt(3) / 2  # a surface of another class so near may cut the voxel
BOX = {"center_m": [NUMBER], "half_size_m": [NUMBER], "yaw_rad": NUMBER, "label": int}
RECTANGLE = {"origin_m": [NUMBER], "edge_u_m": [NUMBER], "edge_v_m": [NUMBER], "label": int}
TRUTH = {"labels": [str], "boxes": [BOX], "rectangles": [RECTANGLE], "?things": [BOX | {"class": str}]}


def evaluate(site):
    """Shares of the voxels with the right class. A recording that is not made up, and a model with classes of its own, have counts alone."""
    voxels = read_voxel_labels(site)
    if voxels is None:
        return {}
    counts = {"num_voxels": len(voxels.keys), "has_truth": False}
    truth = true_classes(site, voxels)
    return counts if truth is None else counts | {"has_truth": True} | figures(voxels, truth)


@dataclass
class TrueClasses:
    nearest: np.ndarray  # (n,) label of the true class of each voxel, -1 where nothing is
    is_border: np.ndarray  # (n,) whether a surface of another class may be in the voxel
    is_inside: np.ndarray  # (n,) whether a surface of the class that the map gives the voxel is in it for certain


def true_classes(site, voxels):
    """The true class of each voxel; None without a truth."""
    building, alignment = read_true_building(site), building_from_map(site)
    if building is None or alignment is None or sorted(building.names) != sorted(voxels.names):
        return None
    reach_m = MAX_DISTANCE_VOXELS * voxels.resolution_m
    distances_m = class_distances_m(alignment.apply(voxels.centres_m()), building, reach_m)
    distances_m = distances_m[[building.names.index(name) for name in voxels.names]]
    nearest = np.argmin(distances_m, axis=0)
    is_there = np.isfinite(distances_m.min(axis=0))
    num_near = np.count_nonzero(distances_m <= HALF_DIAGONAL_VOXELS * voxels.resolution_m, axis=0)
    is_nearest_near = distances_m.min(axis=0) <= HALF_DIAGONAL_VOXELS * voxels.resolution_m
    own_m = distances_m[voxels.labels, np.arange(len(voxels.labels))]
    is_inside = own_m <= HALF_EDGE_VOXELS * voxels.resolution_m
    return TrueClasses(np.where(is_there, nearest, -1), num_near - is_nearest_near > 0, is_inside)


def figures(voxels, true):
    """A voxel on a border may be of either class; the figures off borders leave it out."""
    truth = true.nearest
    is_there, is_right = truth >= 0, voxels.labels == truth
    is_furniture = np.isin(truth, [i for i, name in enumerate(voxels.names) if name in FURNITURE])
    off_borders = is_furniture & ~true.is_border
    return {
        "num_nowhere": int(np.count_nonzero(~is_there)),
        "nowhere_percent": _percent(~is_there, np.ones(len(truth), bool)),
        "right_percent": _percent(is_right, is_there),
        "num_furniture_voxels": int(np.count_nonzero(is_furniture)),
        "furniture_right_percent": _percent(is_right, is_furniture),
        "furniture_right_percent_with_borders": _percent(is_right | true.is_inside, is_furniture),
        "num_furniture_voxels_off_borders": int(np.count_nonzero(off_borders)),
        "furniture_right_percent_off_borders": _percent(is_right, off_borders),
        "classes": {name: {"num_voxels": int(np.count_nonzero(truth == i)), "right_percent": _percent(is_right, truth == i)}
                    for i, name in enumerate(voxels.names) if (truth == i).any()},
        "confusion": confusion(voxels, truth),
    }  # fmt: skip


def confusion(voxels, truth):
    """True class -> class in the map -> voxels; without those that are none."""
    is_there, num = truth >= 0, len(voxels.names)
    counts = np.bincount(truth[is_there] * num + voxels.labels[is_there], minlength=num * num).reshape(num, num)
    return {name: {voxels.names[j]: int(counts[i, j]) for j in np.flatnonzero(counts[i])}
            for i, name in enumerate(voxels.names) if counts[i].any()}  # fmt: skip


def _percent(chosen, among):
    """Share of `among` that is chosen too; None of none."""
    num = np.count_nonzero(among)
    return 100 * float(np.count_nonzero(chosen & among)) / num if num else None


def class_distances_m(points_m, building, reach_m):
    """Distance (classes, n) of each point of the building's frame to the nearest surface of each class; infinity beyond reach_m."""
    result = np.full((len(building.names), len(points_m)), np.inf, np.float32)
    index = PointIndex(points_m)
    edges = np.array([[0, 0], [0, 1], [1, 0], [1, 1]])
    parts = [(label, box.centre_m + _box_ends_m(box), box_distances_m, box) for label, box in building.boxes]
    parts += [(label, rectangle.origin_m + edges @ rectangle.edges_m, rectangle_distances_m, rectangle) for label, rectangle in building.rectangles]
    for label, corners_m, distances_of, part in parts:
        near = index.within(corners_m.min(axis=0) - reach_m, corners_m.max(axis=0) + reach_m)
        found_m = distances_of(points_m[near], part)
        result[label, near] = np.minimum(result[label, near], np.where(found_m <= reach_m, found_m, np.inf))
    return result


def _box_ends_m(box):
    """The least and the largest corner of the upright range that holds a box, from its centre."""
    half_m = np.append(np.abs(box.corners_m() - box.centre_m[:2]).max(axis=0), box.half_size_m[2])
    return np.stack([-half_m, half_m])


def box_distances_m(points_m, box):
    """Distance to the faces of a box, from outside and from inside."""
    beyond_m = np.abs(box.to_own_axes(points_m)) - box.half_size_m
    return np.abs(np.linalg.norm(np.maximum(beyond_m, 0), axis=1) + np.minimum(beyond_m.max(axis=1), 0))


def rectangle_distances_m(points_m, rectangle):
    """Distance to a rectangle, or to a line or point where edges have no length."""
    offsets = points_m - rectangle.origin_m
    for edge in rectangle.edges_m:
        length2 = edge @ edge
        if length2 > 0:
            offsets = offsets - np.clip(offsets @ edge / length2, 0, 1)[:, None] * edge
    return np.linalg.norm(offsets, axis=1)


class PointIndex:
    """Finds the points in an upright range, by their order in x."""

    def __init__(self, points_m):
        self._order = np.argsort(points_m[:, 0], kind="stable")
        self._points_m = points_m[self._order]

    def within(self, low_m, high_m):
        """Indices of the points between two corners."""
        first, last = np.searchsorted(self._points_m[:, 0], low_m[0]), np.searchsorted(self._points_m[:, 0], high_m[0], side="right")
        points_m = self._points_m[first:last]
        return self._order[first:last][((points_m >= low_m) & (points_m <= high_m)).all(axis=1)]


@dataclass
class Rectangle:
    origin_m: np.ndarray
    edges_m: np.ndarray  # (2, 3), at right angles


@dataclass
class TrueBuilding:
    names: list  # of the classes
    boxes: list  # (label, UprightBox) of all solids
    rectangles: list  # (label, Rectangle): floors, ceilings and lamps
    things: list  # (class, UprightBox)


def read_true_building(site):
    """The truth of the recording's building; None of a recording that is not made up."""
    folder = truth_folder(site)
    path = folder / "boxes.json" if folder else None
    if path is None or not path.exists():
        return None
    truth = read_object(path, TRUTH, RECORD_AGAIN)
    boxes = [(entry["label"], _box(entry)) for entry in truth["boxes"]]
    rectangles = [(entry["label"], Rectangle(np.array(entry["origin_m"], float), np.array([*entry["edge_u_m"], *entry["edge_v_m"]], float)))
                  for entry in truth["rectangles"]]  # fmt: skip
    things = [(entry["class"], _box(entry)) for entry in truth.get("things", [])]
    _check(path, len(truth["labels"]), boxes, rectangles, things)
    return TrueBuilding(truth["labels"], boxes, rectangles, things)


def _box(entry):
    return UprightBox(np.array(entry["center_m"], float), np.array(entry["half_size_m"], float), float(entry["yaw_rad"]))


def _check(path, num_labels, boxes, rectangles, things):
    """Raises DataError on lists of numbers of another length and on labels of no class."""
    has_sizes = all(box.centre_m.shape == box.half_size_m.shape == (3,) for _, box in [*boxes, *things])
    has_sizes = has_sizes and all(part.origin_m.shape == (3,) and part.edges_m.shape == (6,) for _, part in rectangles)
    if not has_sizes or not all(0 <= label < num_labels for label, _ in [*boxes, *rectangles]):
        raise DataError(f"{path}: not a valid box or rectangle; {RECORD_AGAIN}")
    for _, part in rectangles:
        part.edges_m = part.edges_m.reshape(2, 3)


def building_from_map(site):
    """The rigid transform that aligns the trajectory with the true one, as evaluate aligns it; None without a truth."""
    path = site.made("map_frame", "trajectory")
    if path is None or not site.ground_truth.exists():
        return None
    estimate, truth = read_tum(path), read_truth(site.ground_truth)
    pairs = associate(estimate.times_ns, truth.times_ns, FRAME_GAP_NS)
    return umeyama(estimate.positions_m[pairs[:, 0]], truth.positions_m[pairs[:, 1]], with_scale=False)
