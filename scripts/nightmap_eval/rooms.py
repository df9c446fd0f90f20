# SPDX-License-Identifier: Apache-2.0
"""Rooms and walls of an occupancy grid, as areas, points and polygons in the map frame.

Rooms follow from the clearance of the free floor, as in "distance transform" of Bormann et al. 2016, "Room segmentation:
survey, implementation, and analysis": floor that is wider than any door is the core of a room, and cores grow to where the
floor between them is narrowest."""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import distance_transform_edt, find_objects, label, maximum

from nightmap_eval.grid import FREE, OCCUPIED
from nightmap_eval.polygons import polygons_of_labels

# Doors are 0.7 to 1.1 m wide, and a map lacks up to two cells of a jamb on each side.
MAX_DOOR_M = 1.3
# A door is narrower than both its rooms by this factor: one of 0.9 m parts corridors of 1.4 m and more.
MAX_DOOR_TO_ROOM = 0.65
MIN_ROOM_M2 = 1.0
# Cells that stand alone on the floor and span no more than this are furniture, a column, or a speck that was not seen: they bound no room.
MAX_ISLAND_M = 1.0
NEXT_TO = np.ones((3, 3), dtype=bool)


@dataclass
class Room:
    """area_m2 is free floor: what stands on it is a hole. centre_m (x, y) is the middle of the largest free place in the room.
    width_m >= height_m are the sides of the smallest rectangle around it."""

    number: int
    area_m2: float
    centre_m: tuple
    polygons: list
    width_m: float
    height_m: float


def find_rooms(grid):
    """Labels (rows, columns), 0 none, and a Room for each label 1, 2, ..., by area, largest first, then by place.

    A narrowing up to MAX_DOOR_M wide parts two rooms if it is also narrower than MAX_DOOR_TO_ROOM of the widest place of each.
    Rooms below MIN_ROOM_M2 join the neighbour behind their widest opening; without one they are none. Unknown cells bound a room
    like walls. Deterministic."""
    labels = np.zeros(grid.cells.shape, dtype=np.int32)
    free = grid.cells == FREE
    if not free.any():
        return labels, []
    window = find_objects(free.astype(np.uint8))[0]
    free = np.pad(free[window], 1)
    floor = with_islands(free, grid.resolution_m)
    clearance = np.maximum(distance_transform_edt(floor) - 0.5, 0)  # from the middle of a cell to the border of what blocks
    min_cells = MIN_ROOM_M2 / grid.resolution_m**2
    parts = cores(floor, clearance, MAX_DOOR_M / 2 / grid.resolution_m, min_cells)
    grow(parts, floor, clearance)
    parts = merged(parts, clearance, free, min_cells)
    parts[~free] = 0
    labels[window] = by_area(parts)[1:-1, 1:-1]
    return labels, measured(labels, grid)


def find_walls(grid):
    """Polygons around the occupied cells, in the map frame in metres, by place."""
    occupied = (grid.cells == OCCUPIED).astype(np.int32)
    return [polygon.moved(grid.from_cells) for polygons in polygons_of_labels(occupied) for polygon in polygons]


def with_islands(free, resolution_m):
    """The free cells, and all that stands alone among them and is small."""
    blocked, _ = label(~free, NEXT_TO)
    small = [False] + [max(s.stop - s.start for s in window) * resolution_m <= MAX_ISLAND_M for window in find_objects(blocked)]
    small[blocked[0, 0]] = False  # the frame around the window
    return free | np.array(small)[blocked]


def cores(floor, clearance, min_clearance, min_cells):
    """Labels of the places wider than a door, and of parts of the floor of at least `min_cells` without any."""
    labels, num = label(clearance > min_clearance)
    areas, _ = label(floor)
    num_cells = np.bincount(areas.ravel())
    narrow = num_cells >= min_cells
    narrow[np.unique(areas[labels > 0])] = False
    narrow[0] = False
    further = np.where(narrow, num + np.cumsum(narrow), 0)[areas]
    return np.where(labels > 0, labels, further).astype(np.int32)


def grow(labels, floor, clearance):
    """Grows labels in place over the floor: wider places first, at one width by steps over sides of cells, never through what
    is not floor. `labels` has a frame of cells that are not floor."""
    flat, width = labels.reshape(-1), labels.shape[1]
    steps = np.array([[-width], [-1], [1], [width]])
    levels = np.where(floor, (2 * clearance).astype(np.int32), 0).reshape(-1)
    waiting = np.flatnonzero((levels > 0) & (flat == 0))
    waiting = waiting[np.argsort(-levels[waiting], kind="stable")]
    bounds = np.flatnonzero(np.diff(levels[waiting], prepend=-1))
    for front in np.split(waiting, bounds[1:]):
        level = levels[front[0]] if front.size else 0
        while front.size:
            around = flat[front + steps]
            claims = np.where(around > 0, around, np.iinfo(np.int32).max).min(axis=0)
            won = claims < np.iinfo(np.int32).max
            flat[front[won]] = claims[won]
            near = np.unique(front[won] + steps)
            front = near[(flat[near] == 0) & (levels[near] >= level)]


def openings(labels, clearance):
    """(half width in cells, one label, other label) of all neighbours, widest first, then by label."""
    found = []
    for one, other in ((np.s_[:, :-1], np.s_[:, 1:]), (np.s_[:-1], np.s_[1:])):
        a, b = labels[one], labels[other]
        at = (a != b) & (a > 0) & (b > 0)
        found.append(np.stack([np.minimum(a, b)[at], np.maximum(a, b)[at], np.minimum(clearance[one], clearance[other])[at]], axis=1))
    rows = np.concatenate(found)
    rows = rows[np.lexsort((rows[:, 1], rows[:, 0], -rows[:, 2]))]
    _, first = np.unique(rows[:, :2], axis=0, return_index=True)
    return [(half, int(a), int(b)) for a, b, half in rows[np.sort(first)]]


def merged(labels, clearance, free, min_cells):
    """Labels without parts that no door parts, and without small ones."""
    num = int(labels.max())
    parent = list(range(num + 1))
    widest = np.array(maximum(clearance, labels, np.arange(num + 1)))
    num_cells = np.bincount(labels[free], minlength=num + 1)

    def root(part):
        while parent[part] != part:
            part = parent[part]
        return part

    def join(part, other):
        parent[max(part, other)] = kept = min(part, other)
        widest[kept] = max(widest[part], widest[other])
        num_cells[kept] = num_cells[part] + num_cells[other]

    pairs = openings(labels, clearance)
    for half, a, b in pairs:
        a, b = root(a), root(b)
        if a != b and half > MAX_DOOR_TO_ROOM * min(widest[a], widest[b]):
            join(a, b)
    for half, a, b in pairs:
        a, b = root(a), root(b)
        if a != b and min(num_cells[a], num_cells[b]) < min_cells:
            join(a, b)
    roots = np.array([root(part) for part in range(num + 1)])
    roots[num_cells[roots] < min_cells] = 0
    return roots[labels]


def by_area(labels):
    """The labels numbered from 1, largest first, then by their first cell."""
    numbers, first, num_cells = np.unique(labels, return_index=True, return_counts=True)
    first, num_cells, numbers = first[numbers > 0], num_cells[numbers > 0], numbers[numbers > 0]
    order = np.lexsort((first, -num_cells))
    numbered = np.zeros(int(labels.max()) + 1, dtype=np.int32)
    numbered[numbers[order]] = np.arange(1, len(order) + 1)
    return numbered[labels]


def measured(labels, grid):
    num_cells = np.bincount(labels.ravel())
    rooms = []
    for number, (window, polygons) in enumerate(zip(find_objects(labels), polygons_of_labels(labels)), 1):
        width, height = sides(np.concatenate([polygon.outer for polygon in polygons]))
        row, column = middle(np.pad(labels[window] == number, 1))
        x, y = grid.from_cells(column - 0.5 + window[1].start, row - 0.5 + window[0].start)
        rooms.append(Room(number, float(num_cells[number] * grid.resolution_m**2), (float(x), float(y)),
                          [polygon.moved(grid.from_cells) for polygon in polygons],
                          width * grid.resolution_m, height * grid.resolution_m))  # fmt: skip
    return rooms


def middle(inside):
    """Row and column of the cell farthest from all that is not inside; of several, the one nearest to the centre of mass."""
    clearance = distance_transform_edt(inside)
    rows, columns = np.nonzero(clearance == clearance.max())
    centre = [np.mean(values) for values in np.nonzero(inside)]
    nearest = np.argmin((rows - centre[0]) ** 2 + (columns - centre[1]) ** 2)
    return int(rows[nearest]), int(columns[nearest])


def sides(points):
    """Longer and shorter side of the smallest rectangle around points (n, 2), of those turned by steps of half a degree."""
    angles = np.deg2rad(np.arange(0, 90, 0.5))
    directions = np.stack([np.cos(angles), np.sin(angles)])
    along, across = points @ directions, points @ np.stack([-directions[1], directions[0]])
    lengths, widths = np.ptp(along, axis=0), np.ptp(across, axis=0)
    best = int(np.argmin(np.round(lengths * widths, 6)))
    return float(max(lengths[best], widths[best])), float(min(lengths[best], widths[best]))
