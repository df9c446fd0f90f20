# SPDX-License-Identifier: Apache-2.0
"""Clouds of points for the 3-D view of the report: few enough for a page, and in the order in which the view draws them.

A packed cloud has blocks of space, cubes of block_m at whole multiples of it. A point is three uint16, its place in its block in
65535 parts of block_m, so it is off by at most block_m / 131070 along each axis. Within a block points are in the order of a hash of their
index in the file: the first n of a block are a uniform sample of it. The bytes, before zlib and base64: x of all points, y, z (uint16,
little-endian), then each column of a byte per point: red, green, blue or the index of the class; and where the surface faces (facings)."""

import base64
import zlib
from dataclasses import dataclass

import numpy as np

from nightmap_eval.ply import vertex_chunks
from nightmap_eval.trajectory import MAX_POSITION_M
from nightmap_site.checked_reading import using

MAX_POINTS, MAX_LABELLED = 1_200_000, 800_000
CHUNK = 1 << 19
BLOCK_M, PARTS = 4.0, 65535
MAX_BLOCKS = 8192  # each is drawn by a call of its own
SPACING_CELL_M = 0.1
INNER_PERCENT, NUM_OUTLINE = (0.5, 99.5), 400
COLORS, CLASSES, NORMAL = ("red", "green", "blue"), ("label",), ("nx", "ny", "nz")
FACING_DEG = 30, 10  # steps of elevation and azimuth
NO_FACING = 255


@dataclass
class PackedCloud:
    blocks: list  # x, y, z of the lower corner in blocks, number of points
    block_m: float
    spacing_m: float  # between neighbours on a surface, about
    num_in_file: int
    num_points: int
    columns: list  # names, of a byte per point each
    text: str  # base64
    outline_m: np.ndarray  # (n, 3): a few of the points, without the outermost

    def head(self):
        """The part that JSON says."""
        return {"blocks": self.blocks, "block_m": self.block_m, "spacing_m": round(self.spacing_m, 4), "columns": self.columns,
                "num_points": self.num_points, "num_in_file": self.num_in_file}  # fmt: skip


def hashes(indices):
    """A well mixed number of 64 bits for each (splitmix64: Steele, Lea and Flood 2014)."""
    with np.errstate(over="ignore"):
        mixed = (indices.astype(np.uint64) + np.uint64(1)) * np.uint64(0x9E3779B97F4A7C15)
        mixed = (mixed ^ (mixed >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
        mixed = (mixed ^ (mixed >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
        return mixed ^ (mixed >> np.uint64(31))


def facings(normals):
    """The direction of each unit vector in steps of FACING_DEG: 36 * (steps above straight down) + steps from x; NO_FACING of a zero."""
    x, y, z = normals.T
    up = np.rint((np.degrees(np.arcsin(np.clip(z, -1, 1))) + 90) / FACING_DEG[0])
    around = np.rint(np.degrees(np.arctan2(y, x)) / FACING_DEG[1]) % 36
    return np.where(np.linalg.norm(normals, axis=1) > 0.5, 36 * up + around, NO_FACING)


def read_sample(path, columns, most=MAX_POINTS):
    """(number of points in the file, points (n, 3) as float64, values (n, len(columns) + 1), hashes (n,)) of at most `most` points of a
    PLY file, chosen by the hash of their index. The last value is where the surface faces."""
    count, chunks = vertex_chunks(path, CHUNK)
    limit = np.uint64(min(2**64 - 1, (most * 2**64) // max(count, 1)))
    parts, first = [], 0
    for rows in chunks:
        order = hashes(np.arange(first, first + len(rows)))
        kept = np.flatnonzero(order <= limit)
        first += len(rows)
        with using(path):
            rows = rows[kept]
            points_m = np.column_stack([rows[axis].astype(float) for axis in "xyz"])
            if not np.all(np.abs(points_m) <= MAX_POSITION_M):  # also refuses NaN
                raise ValueError("NaN, infinity or a coordinate out of range in a vertex")
            normals = np.column_stack([rows[name] if name in rows.dtype.names else np.zeros(len(rows)) for name in NORMAL])
            if not np.all(np.isfinite(normals)):
                raise ValueError("NaN or infinity in a normal")
            parts.append((points_m, np.column_stack([*(rows[name] for name in columns), facings(normals)]), order[kept]))
    if not parts:
        return 0, np.zeros((0, 3)), np.zeros((0, len(columns) + 1)), np.zeros(0, np.uint64)
    points_m, values, order = map(np.concatenate, zip(*parts))
    if len(order) > most:  # the limit keeps about as many
        kept = np.sort(np.argpartition(order, most)[:most])
        points_m, values, order = points_m[kept], values[kept], order[kept]
    return count, points_m, values, order


def pack(points_m, values, order, columns, num_in_file):
    """values: (n, len(columns)) of 0 .. 255; order: the hash of each point. columns: names, the last of them "facing"."""
    block_m = BLOCK_M
    cells, firsts, counts = _cells(points_m, block_m)
    while len(firsts) > MAX_BLOCKS:
        block_m *= 2
        cells, firsts, counts = _cells(points_m, block_m)
    rows = np.lexsort((order, cells))
    corners = np.floor(points_m[firsts] / block_m)
    lows_m = np.repeat(corners, counts, axis=0) * block_m
    places = np.clip(np.rint((points_m[rows] - lows_m) * (PARTS / block_m)), 0, PARTS).astype("<u2")
    data = places.T.tobytes() + values[rows].T.astype(np.uint8).tobytes()
    blocks = [[*map(int, corner), int(count)] for corner, count in zip(corners, counts)]
    return PackedCloud(blocks, block_m, spacing_m(points_m), num_in_file, len(points_m), list(columns), encoded(data),
                       outline(points_m, order))  # fmt: skip


def encoded(data):
    return base64.b64encode(zlib.compress(data, 6)).decode()


def _cells(points_m, edge_m):
    """The number of each point's cube, in the order of x, y, z; of each cube a point and the number of points."""
    keys = np.floor(points_m / edge_m).astype(np.int64)
    order = np.lexsort(keys.T[::-1])
    begins = np.ones(len(keys), bool)
    begins[1:] = np.any(np.diff(keys[order], axis=0) != 0, axis=1)
    cells = np.empty(len(keys), np.int64)
    cells[order] = np.cumsum(begins) - 1
    return cells, order[begins], np.diff(np.append(np.flatnonzero(begins), len(keys)))


def spacing_m(points_m):
    """About the distance of neighbours, by how many share a small cube that a surface passes."""
    if len(points_m) == 0:
        return SPACING_CELL_M
    return float(SPACING_CELL_M / np.sqrt(max(1.0, np.median(_cells(points_m, SPACING_CELL_M)[2]))))


def outline(points_m, order):
    low_m, high_m = np.percentile(points_m, INNER_PERCENT, axis=0)
    inner = np.flatnonzero(np.all((points_m >= low_m) & (points_m <= high_m), axis=1))
    return points_m[inner[np.argsort(order[inner])[:NUM_OUTLINE]]]


def color_cloud(path):
    """The cloud in its colors; None for an empty file."""
    count, points_m, values, order = read_sample(path, COLORS)
    return pack(points_m, values, order, (*COLORS, "facing"), count) if len(points_m) else None


def class_cloud(path, index_of):
    """The cloud with the index of the class of each point. index_of: label -> 0 .. 255; 255 where it is not there."""
    count, points_m, values, order = read_sample(path, CLASSES, MAX_LABELLED)
    if not len(points_m):
        return None
    labels, inverse = np.unique(values[:, 0], return_inverse=True)
    indices = np.array([index_of.get(int(label), 255) for label in labels])[inverse]
    return pack(points_m, np.column_stack([indices, values[:, 1]]), order, (*CLASSES, "facing"), count)
