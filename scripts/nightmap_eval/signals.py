# SPDX-License-Identifier: Apache-2.0
"""Reads frames/scans.h5 and frames/odometry.h5: the samples of each sensor, and scans as a table of directions."""

from dataclasses import dataclass

import h5py
import numpy as np

from nightmap_eval.artifacts import read_hdf5
from nightmap_site.checked_reading import using

FULL_TURN_RAD = 2 * np.pi


@dataclass(frozen=True)
class Samples:
    """Of one sensor. values: (n, 3), see signals_io.h. ranges_m: of each scan; empty of odometry. is_upside_down: its z points down."""

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
    with using(path), h5py.File(path) as file:
        ids = [file.attrs[f"sensor_{i}"] for i in range(len(offsets) - 1)]
        per_scan = np.split(ranges_m, range_offsets[1:-1]) if len(ranges_m) else []
        ids = [name.decode() if isinstance(name, bytes) else name for name in ids]
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
