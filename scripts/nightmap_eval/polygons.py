# SPDX-License-Identifier: Apache-2.0
"""Polygons around regions of a label image: exact on the borders of cells, then simplified without breaking them."""

from dataclasses import dataclass, field

import numpy as np
from scipy.ndimage import find_objects, label

TOLERANCE_CELLS = 0.5
STEPS = np.array([(1, 0), (0, 1), (-1, 0), (0, -1)])  # x, y of the four directions of a border, each left of the one before


@dataclass
class Polygon:
    """Rings (n, 2) of corners, the first not repeated at the end: the outer one counterclockwise, holes clockwise."""

    outer: np.ndarray
    holes: list = field(default_factory=list)

    def area(self):
        """In squares of the unit of the corners."""
        return sum(signed_area(ring) for ring in (self.outer, *self.holes))

    def moved(self, from_cells):
        """The polygon with from_cells(x, y) of its corners, in float."""
        rings = [from_cells(*ring.T.astype(float)) for ring in (self.outer, *self.holes)]
        return Polygon(rings[0], rings[1:])


def signed_area(ring):
    """Positive for a counterclockwise ring."""
    x, y = (ring - ring[0]).T
    return (np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1))) / 2


def polygons_of_labels(labels, tolerance_cells=TOLERANCE_CELLS):
    """For each label 1, 2, ... of an image (rows, columns) its polygons, by place: one for each part that is connected over sides of cells.

    Corners are (column, row), (0, 0) the lower left one of the first cell. A polygon is valid: its rings meet in single points at most,
    and no ring meets itself. Borders of cells are simplified: steps of one cell to slants, then as Douglas and Peucker 1973 do, within
    `tolerance_cells`. A ring that would cross another or itself stays as it was."""
    parts, labels_of_parts = parts_of_labels(labels)
    polygons = [[] for _ in range(int(labels.max(initial=0)))]
    rings_of_parts = [[] for _ in labels_of_parts]
    for part, ring in rings_of(parts):
        rings_of_parts[part - 1].append(ring)
    for number, rings in zip(labels_of_parts, simplified(rings_of_parts, tolerance_cells)):
        polygons[number - 1].append(Polygon(rings[0], rings[1:]))
    return polygons


def parts_of_labels(labels):
    """An image of the parts of all labels that are connected over sides of cells, from 1, and the label of each part."""
    parts, labels_of_parts = np.zeros(labels.shape, dtype=np.int32), []
    for number, window in enumerate(find_objects(labels), 1):
        if window is None:
            continue
        own, num = label(labels[window] == number)
        parts[window][own > 0] = own[own > 0] + len(labels_of_parts)
        labels_of_parts += [number] * num
    return parts, labels_of_parts


def border_edges(parts):
    """Sides of cells that bound their part, each with the part at its left: owner, direction, x and y of its start."""
    padded = np.pad(parts, 1)
    inner, found = padded[1:-1, 1:-1], []
    neighbours = (padded[:-2, 1:-1], padded[1:-1, 2:], padded[2:, 1:-1], padded[1:-1, :-2])
    starts = ((0, 0), (1, 0), (1, 1), (0, 1))  # x, y of the start of the lower, right, upper, left side
    for direction, (other, (dx, dy)) in enumerate(zip(neighbours, starts)):
        rows, columns = np.nonzero((inner != other) & (inner > 0))
        found.append((inner[rows, columns], np.full(len(rows), direction), columns + dx, rows + dy))
    return [np.concatenate(values) for values in zip(*found)]


def rings_of(parts):
    """(part, ring) of all borders: simple rings of corners, in the order of their first edges. The outer one of a part has its lowest edge: it is the first."""
    owner, direction, x, y = border_edges(parts)
    width = parts.shape[1] + 1
    keys = (y * width + x) * 4 + direction  # a place and a direction have one edge: one cell is left of it
    order = np.argsort(keys)
    end = (y + STEPS[direction, 1]) * width + x + STEPS[direction, 0]
    successor = np.full(len(keys), -1)
    for turn in (3, 0, 1):  # right, straight, left: the last that exists holds, so that a border stays with its cell
        wanted = end * 4 + (direction + turn) % 4
        at = np.minimum(np.searchsorted(keys, wanted, sorter=order), len(keys) - 1)
        exists = keys[order[at]] == wanted
        successor[exists] = order[at][exists]
    starts, nexts, seen = (y * width + x).tolist(), successor.tolist(), bytearray(len(keys))
    owners, rings = [], []
    for first in range(len(nexts)):
        if not seen[first]:
            path, edge = [], first
            while not seen[edge]:
                seen[edge] = 1
                path.append(starts[edge])
                edge = nexts[edge]
            found = simple_rings(path)
            rings += found
            owners += [int(owner[first])] * len(found)
    return zip(owners, corners(rings, width))


def simple_rings(ring):
    """A closed path that touches itself in points, cut there into rings that do not; the first has the path's start, if met only once."""
    if len(set(ring)) == len(ring):
        return [ring]
    path, places, rings = [], {}, []
    for place in ring:
        if place in places:
            first = places[place]
            rings.append(path[first:])
            for left in path[first:]:
                del places[left]
            del path[first:]
        places[place] = len(path)
        path.append(place)
    return [path, *rings]


def corners(rings, width):
    """Corners (x, y) of rings of places y * width + x, one step apart."""
    if not rings:
        return []
    places = np.array([place for ring in rings for place in ring])
    sizes = np.array([len(ring) for ring in rings])
    ends = np.cumsum(sizes)
    at = np.arange(len(places))
    before, after = at - 1, at + 1
    before[ends - sizes], after[ends - 1] = ends - 1, ends - sizes
    turns = places - places[before] != places[after] - places
    num_corners = np.add.reduceat(turns.astype(int), ends - sizes)
    return np.split(np.stack([places % width, places // width], axis=1)[turns], np.cumsum(num_corners)[:-1])


def simplified(groups, tolerance_cells):
    """Groups of rings, each ring simplified; rings of one group do not cross themselves or each other."""
    for cells in groups:
        exact = [2 * ring for ring in cells]  # halves of cells, so that all is exact in integers
        touched = touching_points(exact)
        rings = [simplified_ring(ring, touched, 2 * tolerance_cells) for ring in exact]
        rings = [ring if ring is old or signed_area(ring) * signed_area(old) > 0 else old for ring, old in zip(rings, exact)]
        while True:
            changed = {i for i, ring in enumerate(rings) if ring is not exact[i]}
            crossing = changed and changed & crossing_rings(rings)
            if not crossing:
                break
            for i in crossing:
                rings[i] = exact[i]
        yield [ring / 2 for ring in rings]


def touching_points(rings):
    """Corners (x, y) that several rings share."""
    if len(rings) == 1:
        return set()
    points, counts = np.unique(np.concatenate(rings), axis=0, return_counts=True)
    return set(map(tuple, points[counts > 1].tolist()))


def with_anchors(ring, touched):
    """The ring with a further point half a cell before and behind each touched corner, and whether each point is one of these three."""
    points, fixed = [], []
    for before, point, after in zip(np.roll(ring, 1, axis=0), ring, np.roll(ring, -1, axis=0)):
        if tuple(point) in touched:
            points += [point + np.sign(before - point), point, point + np.sign(after - point)]
            fixed += [True] * 3
        else:
            points.append(point)
            fixed.append(False)
    points, fixed = np.array(points), np.array(fixed)
    new = np.any(points != np.roll(points, 1, axis=0), axis=1)
    return points[new], fixed[new]


def without_steps(ring, fixed):
    """The ring and `fixed` with the middle of each step, one cell high, instead of its two corners: slanted walls become straight."""
    along = np.roll(ring, -1, axis=0) - ring
    before, after = np.roll(along, 1, axis=0), np.roll(along, -1, axis=0)
    opposite = (before[:, 0] * along[:, 1] - before[:, 1] * along[:, 0]) * (along[:, 0] * after[:, 1] - along[:, 1] * after[:, 0]) < 0
    step = opposite & (np.abs(along).sum(axis=1) == 2) & ~fixed & ~np.roll(fixed, -1)
    points = np.stack([ring, ring + along // 2], axis=1).reshape(-1, 2)
    chosen = np.stack([~step & ~np.roll(step, 1), step], axis=1).reshape(-1)
    return points[chosen], np.stack([fixed, np.zeros_like(step)], axis=1).reshape(-1)[chosen]


def simplified_ring(exact, touched, tolerance):
    """Douglas-Peucker, all chords at once. The first corner stays, and touched ones with their neighbours."""
    if len(exact) <= 4:
        return exact
    ring, fixed = without_steps(*(with_anchors(exact, touched) if touched else (exact, np.zeros(len(exact), dtype=bool))))
    path = np.vstack([ring, ring[:1]]).astype(float)
    kept = np.append(fixed, True)
    kept[0] = True
    while True:
        ends = np.flatnonzero(kept)
        chord = np.minimum(np.cumsum(kept) - 1, len(ends) - 2)
        start, along = path[ends[:-1]], np.diff(path[ends], axis=0)
        squared = np.maximum(np.sum(along**2, axis=1), 1e-300)
        offset = path - start[chord]
        share = np.clip(np.sum(offset * along[chord], axis=1) / squared[chord], 0, 1)
        distance = np.sum((offset - share[:, None] * along[chord]) ** 2, axis=1)
        distance[kept] = 0
        farthest = np.maximum.reduceat(distance, ends[:-1])
        is_far = (distance > tolerance**2 + 1e-9) & (distance == farthest[chord])
        far = np.flatnonzero(is_far)
        if not len(far):
            return ring[kept[:-1]]
        kept[far[np.unique(chord[far], return_index=True)[1]]] = True


def crossing_rings(rings):
    """Set of the indices of rings that cross or touch themselves or another ring elsewhere than in a corner of both."""
    starts, ends = np.concatenate(rings), np.concatenate([np.roll(ring, -1, axis=0) for ring in rings])
    ring_of = np.repeat(np.arange(len(rings)), [len(ring) for ring in rings])
    low, high = np.minimum(starts, ends), np.maximum(starts, ends)
    order = np.argsort(low[:, 0], kind="stable")
    last = np.searchsorted(low[order, 0], high[order, 0], side="right")
    found = set()
    for begin in range(0, len(order), 4096):  # bounds the memory of the pairs
        own = np.arange(begin, min(begin + 4096, len(order)))
        counts = last[own] - own - 1
        first = np.repeat(own, counts)
        second = first + 1 + np.arange(len(first)) - np.repeat(np.cumsum(counts) - counts, counts)
        a, b = order[first], order[second]
        near = (low[a, 1] <= high[b, 1]) & (low[b, 1] <= high[a, 1])
        a, b = a[near], b[near]
        bad = meet(starts[a], ends[a], starts[b], ends[b], ring_of[a] == ring_of[b])
        found |= set(ring_of[a[bad]].tolist()) | set(ring_of[b[bad]].tolist())
    return found


def side(a, b, c):
    """Positive where c is left of a to b, in integers."""
    return np.sign((b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0]))


def meet(a, b, c, d, same_ring):
    """Whether segments a-b and c-d, whose boxes overlap, meet otherwise than in a common end."""
    c_at, d_at, a_at, b_at = side(a, b, c), side(a, b, d), side(c, d, a), side(c, d, b)
    touch = (c_at * d_at <= 0) & (a_at * b_at <= 0)
    joined = [np.all(p == q, axis=1) for p, q in ((a, c), (a, d), (b, c), (b, d))]
    num_joined = np.sum(joined, axis=0)
    folded = (c_at == 0) & (d_at == 0) & (np.sum((b - a) * (d - c), axis=1) * np.where(joined[0] | joined[3], 1, -1) > 0)
    follows = joined[1] | joined[2]
    return touch & ((num_joined == 0) | (num_joined > 1) | folded | (same_ring & ~follows))
