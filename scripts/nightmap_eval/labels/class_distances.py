# SPDX-License-Identifier: Apache-2.0
"""How far points are from the true surfaces of each class."""

import numpy as np

CELL_M = 0.25


def class_distances_m(points_m, building, reach_m):
    """Distance (classes, n) of each point of the building's frame to the nearest surface of each class; infinity beyond reach_m."""
    result = np.full((len(building.names), len(points_m)), np.inf, np.float32)
    index = PointIndex(points_m)
    for label, box in building.boxes:
        half_m = np.append(np.abs(box.corners_m() - box.centre_m[:2]).max(axis=0), box.half_size_m[2])
        _take_nearer(result[label], index.within(box.centre_m - half_m - reach_m, box.centre_m + half_m + reach_m),
                     lambda near, box=box: box_distances_m(points_m[near], box), reach_m)  # fmt: skip
    for label, rectangle in building.rectangles:
        corners_m = rectangle.origin_m + np.array([[0, 0], [0, 1], [1, 0], [1, 1]]) @ rectangle.edges_m
        _take_nearer(result[label], index.within(corners_m.min(axis=0) - reach_m, corners_m.max(axis=0) + reach_m),
                     lambda near, rectangle=rectangle: rectangle_distances_m(points_m[near], rectangle), reach_m)  # fmt: skip
    return result


def _take_nearer(nearest_m, near, distances_of, reach_m):
    found_m = distances_of(near)
    nearest_m[near] = np.where(found_m <= reach_m, np.minimum(nearest_m[near], found_m), nearest_m[near])


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
    """Finds the points in an upright range, by columns of cells over the plane."""

    def __init__(self, points_m):
        self._points_m = points_m
        cells = np.floor(points_m[:, :2] / CELL_M).astype(np.int64)
        self._low = cells.min(axis=0) if len(cells) else np.zeros(2, np.int64)
        self._size = cells.max(axis=0) - self._low + 1 if len(cells) else np.zeros(2, np.int64)
        columns = (cells - self._low) @ np.array([self._size[1], 1])
        self._order = np.argsort(columns, kind="stable")
        self._columns = columns[self._order]

    def within(self, low_m, high_m):
        """Indices of the points between two corners."""
        first = np.maximum(np.floor(low_m[:2] / CELL_M).astype(np.int64) - self._low, 0)
        last = np.minimum(np.floor(high_m[:2] / CELL_M).astype(np.int64) - self._low, self._size - 1)
        if (last < first).any():
            return np.zeros(0, np.int64)
        rows = np.arange(first[0], last[0] + 1) * self._size[1]
        starts = np.searchsorted(self._columns, rows + first[1])
        ends = np.searchsorted(self._columns, rows + last[1], side="right")
        near = np.concatenate([self._order[start:end] for start, end in zip(starts, ends)])
        points_m = self._points_m[near]
        return near[((points_m >= low_m) & (points_m <= high_m)).all(axis=1)]
