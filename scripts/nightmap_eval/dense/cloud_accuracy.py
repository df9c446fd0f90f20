# SPDX-License-Identifier: Apache-2.0
"""Distance of a point cloud to the exact surfaces of a synthetic building; binary PLY files as stages write them."""

import os

import numpy as np

from nightmap_eval.trajectory_errors import statistics
from nightmap_site.checked_reading import using

_TYPES = {
    "char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1", "short": "i2", "int16": "i2",
    "ushort": "u2", "uint16": "u2", "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4",
    "float": "f4", "float32": "f4", "double": "f8", "float64": "f8",
}  # fmt: skip


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


def _read_header(file):
    """(name, count, fields of numpy) of each element; a list is taken to be a triangle."""
    elements = []
    if file.readline().strip() != b"ply":
        raise ValueError("not a PLY file")
    for line in file:
        match line.decode("ascii", "replace").split():
            case ["format", "binary_little_endian", *_] | ["comment" | "obj_info", *_]:
                pass
            case ["element", name, count] if count.isdecimal() and len(count) < 19:
                elements.append((name, int(count), []))
            case ["property", "list", size, kind, name] if elements:
                elements[-1][2].extend([("num_" + name, "<" + _TYPES[size]), (name, "<" + _TYPES[kind], (3,))])
            case ["property", kind, name] if elements:
                elements[-1][2].append((name, "<" + _TYPES[kind]))
            case ["end_header"]:
                return elements
            case _:
                raise ValueError(f"not a valid line of the header of a binary_little_endian PLY: {line[:80]!r}")
    raise ValueError("truncated in the header")


def read_ply(path):
    """Vertices (n, 3) in metres and triangles (m, 3) of vertex indices (m = 0 for a cloud)."""
    with open(path, "rb") as file, using(path):
        elements = {name: _read_element(file, count, np.dtype(fields)) for name, count, fields in _read_header(file)}
        vertices = np.stack([elements["vertex"][axis] for axis in "xyz"], axis=1).astype(float)
        if not np.all(np.isfinite(vertices)):
            raise ValueError("NaN or infinity in a vertex")
        return vertices, _triangles(elements.get("face", ()), len(vertices))


def _read_element(file, count, row_type):
    left, row_bytes = os.fstat(file.fileno()).st_size - file.tell(), row_type.itemsize
    if row_bytes == 0 or count * row_bytes > left:  # before any memory is taken
        raise ValueError(f"truncated: {count} rows of {row_bytes} bytes, {left} bytes are left")
    return np.frombuffer(file.read(count * row_bytes), row_type)


def _triangles(faces, num_vertices):
    if len(faces) == 0:
        return np.zeros((0, 3), dtype=int)
    size, name, *_ = faces.dtype.names
    triangles = faces[name].astype(int).reshape(-1, 3)
    if np.any(faces[size] != 3) or triangles.min() < 0 or triangles.max() >= num_vertices:
        raise ValueError("a face is not a triangle, or names a vertex out of range")
    return triangles
