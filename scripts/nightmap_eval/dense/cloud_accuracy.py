# SPDX-License-Identifier: Apache-2.0
"""Distance of a point cloud to the exact surfaces of a synthetic building."""

import numpy as np

from nightmap_eval.trajectory_errors import statistics


def _segment_distances2(points, start, end):
    direction = end - start
    length2 = direction @ direction
    t = np.zeros(len(points))
    if length2 > 0:
        t = np.clip((points - start) @ direction / length2, 0, 1)
    return np.sum((points - start - t[:, None] * direction) ** 2, axis=1)


def _triangle_distances2(points, corners):
    a, b, c = corners
    edges = ((a, b), (b, c), (c, a))
    result = np.min([_segment_distances2(points, p, q) for p, q in edges], axis=0)
    normal = np.cross(b - a, c - a)
    area2 = normal @ normal
    if area2 > 0:
        inside = np.all([(points - p) @ np.cross(normal, q - p) >= 0 for p, q in edges], axis=0)
        result[inside] = ((points[inside] - a) @ normal) ** 2 / area2
    return result


def _blocks(points_m, cell_m=0.5):
    """Indices of the points in each occupied cell of a coarse grid."""
    _, cell = np.unique(np.floor(points_m / cell_m), axis=0, return_inverse=True)
    order = np.argsort(cell, kind="stable")
    return np.split(order, np.flatnonzero(np.diff(cell[order])) + 1)


def _block_distances2(points, corners, lows, highs):
    """Tries triangles in the order of the distance between their bounding box and that of the points, until no
    point can get a smaller distance."""
    gap = np.maximum(np.maximum(lows - points.max(axis=0), points.min(axis=0) - highs), 0)
    bound2, best = np.sum(gap**2, axis=1), np.full(len(points), np.inf)
    for i in np.argsort(bound2, kind="stable"):
        if bound2[i] >= best.max():
            break
        best = np.minimum(best, _triangle_distances2(points, corners[i]))
    return best


def distances_m(points_m, vertices_m, triangles):
    """Distance of each point to the nearest triangle, exactly."""
    corners, result = vertices_m[triangles], np.full(len(points_m), np.inf)
    lows, highs = corners.min(axis=1), corners.max(axis=1)
    for block in _blocks(points_m):
        result[block] = _block_distances2(points_m[block], corners, lows, highs)
    return np.sqrt(result)


def sample(points_m, max_points):
    """At most max_points points, spread evenly over the list."""
    if len(points_m) <= max_points:
        return points_m
    return points_m[np.linspace(0, len(points_m) - 1, max_points).astype(int)]


def cloud_metrics(points_m, building_from_map, vertices_m, triangles, max_points=20000):
    """Figures of the distance from the cloud, in the building's frame, to the building's surfaces."""
    chosen = sample(points_m, max_points)
    figures = {"num_points": len(points_m), "num_sampled_points": len(chosen)}
    if len(chosen) == 0:
        return figures
    errors = distances_m(building_from_map.apply(chosen), vertices_m, triangles)
    return figures | statistics(errors, "surface_distance_{}_m", "median", "p90", "max")
