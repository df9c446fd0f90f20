# SPDX-License-Identifier: Apache-2.0
"""Reads frames/scans.h5 and frames/odometry.h5: the samples of each sensor, and scans as a table of directions."""

import math
from dataclasses import dataclass

import numpy as np

from nightmap_eval.artifacts import read_hdf5, read_sensor_ids
from nightmap_site.checked_reading import using

FULL_TURN_RAD = 2 * np.pi
MAX_COMPARED = 360  # directions
MOVED_M, MAX_MOVED = 0.3, 0.5  # of a range; of the directions of two scans of about one place
MAX_HOLE_DEG = 2.0  # between directions of one sector, as in beam_fan.cc


@dataclass(frozen=True)
class Samples:
    """Samples of one sensor. values: (n, 3), see signals_io.h. ranges_m: of each scan; empty of odometry. is_upside_down: z points down."""

    sensor_id: str
    times_ns: np.ndarray
    values: np.ndarray
    ranges_m: list
    is_upside_down: bool = False

    def only(self, idxs):
        return Samples(self.sensor_id, self.times_ns[idxs], self.values[idxs], [self.ranges_m[idx] for idx in idxs], self.is_upside_down)


@dataclass(frozen=True)
class RangeTable:
    """Ranges (scans, directions): NaN where nothing was hit. is_measured: where a beam looked, outside of blind sectors. angles_rad: of
    the directions, evenly spaced; is_circle: whether the last is a neighbour of the first. scan_idxs: rows as scans of the sensor."""

    ranges_m: np.ndarray
    is_measured: np.ndarray
    angles_rad: np.ndarray
    is_circle: bool
    scan_idxs: np.ndarray


def read_sensors(path):
    """Samples of each sensor that has any; none without the file."""
    if path is None:
        return []
    names = ("sample_offset", "time_ns", "value", "range_offset", "range_m", "robot_from_sensor")
    offsets, times_ns, values, range_offsets, ranges_m, mountings = read_hdf5(path, *names)
    offsets, times_ns, range_offsets, ranges_m = map(np.ravel, (offsets, times_ns, range_offsets, ranges_m))
    ids = read_sensor_ids(path)
    with using(path):
        per_scan = np.split(ranges_m, range_offsets[1:-1]) if len(ranges_m) else []
        is_down = (mountings[:, 3] ** 2 + mountings[:, 4] ** 2 > 0.5).tolist()
        return [Samples(name, times_ns[begin:end], values[begin:end], per_scan[begin:end], down)
                for name, begin, end, down in zip(ids, offsets, offsets[1:], is_down) if end > begin]  # fmt: skip


def range_table(scans, max_scans):
    """The scans of a scanner, or so many evenly spread, in the directions of one that has as many beams as most."""
    counts = np.array([len(ranges_m) for ranges_m in scans.ranges_m])
    like = int(np.flatnonzero(counts == np.sort(counts)[len(counts) // 2])[0])
    start_rad, step_rad = scans.values[like, :2]
    angles_rad = start_rad + step_rad * np.arange(counts[like])
    rows = np.unique(np.linspace(0, len(counts) - 1, min(max_scans, len(counts))).astype(int))
    ranges_m = np.full((len(rows), len(angles_rad)), -1.0, np.float32)
    for row, scan in zip(ranges_m, rows.tolist()):
        beams = np.rint((angles_rad - scans.values[scan, 0]) / scans.values[scan, 1]).astype(int)
        exists = (beams >= 0) & (beams < counts[scan])
        row[exists] = scans.ranges_m[scan][beams[exists]]
    is_hit = (ranges_m > 0) & (ranges_m < scans.values[rows, 2][:, None])
    is_circle = len(angles_rad) * abs(step_rad) > FULL_TURN_RAD - abs(step_rad) / 2
    return RangeTable(np.where(is_hit, ranges_m, np.nan), ranges_m >= 0, angles_rad, is_circle, rows)


def of_one_place(ranges_m, other_m):
    """Whether two scans agree about, at one of the headings that the robot may have turned to."""
    shifts = np.arange(len(other_m))[:, None] + np.arange(len(other_m))
    turned_m = np.concatenate([other_m, other_m])[shifts[:: -(-len(other_m) // MAX_COMPARED)]]
    with np.errstate(invalid="ignore"):
        moved = np.count_nonzero(np.abs(turned_m - ranges_m) > MOVED_M, axis=1)
    both = np.count_nonzero(~np.isnan(turned_m) & ~np.isnan(ranges_m), axis=1)
    return bool((moved <= MAX_MOVED * both)[both >= len(other_m) // 4].any())


def sectors_text(table, is_inside):
    """From, to, counter-clockwise, in degrees, of the sectors that hold directions, with half a beam or more on each side."""
    order = np.argsort(table.angles_rad)
    angles_deg, inside = np.degrees(table.angles_rad[order]), is_inside[order]
    step_deg = abs(angles_deg[1] - angles_deg[0]) if len(angles_deg) > 1 else 1.0
    found = angles_deg[inside]
    starts = np.flatnonzero(np.diff(found, prepend=-np.inf) > step_deg + MAX_HOLE_DEG)
    sectors = [(part[0], part[-1]) for part in np.split(found, starts[1:])] if len(found) else []
    if table.is_circle and len(sectors) > 1 and sectors[0][0] + 360 - sectors[-1][1] <= step_deg + MAX_HOLE_DEG:
        sectors = [*sectors[1:-1], (sectors[-1][0], sectors[0][1] + 360)]
    sectors = [(math.floor(round(first - step_deg / 2, 6)), math.ceil(round(last + step_deg / 2, 6))) for first, last in sectors]
    return ", ".join(f"{first - 360:d}, {last - 360:d}" if last > 360 else f"{first:d}, {last:d}" for first, last in sectors)
