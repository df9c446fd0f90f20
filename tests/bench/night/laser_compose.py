# SPDX-License-Identifier: Apache-2.0
"""Composes the scans and wheels of a night out of those of one made-up site: copies of its building, a ring of them through which the
way leads twice.

Each copy is furnished with columns of its own beside the way. From where the robot ends in a copy, a straight tunnel leads to where it
begins in the next. Its walls have pillars, so that scans tell the way along it. It ends in open gates: there the robot sees what the
last scan of the copy before, or the first of the next one, saw of the walls behind the gate. Scans of the source have fresh noise of
ranges on top of theirs, each visit its own. The world is rigid: each place looks the same at both visits.
"""

from dataclasses import dataclass

import h5py
import numpy as np
from nightmap_eval.planar_poses import compose, inverse, to_rows, to_trajectory, wrapped_rad
from nightmap_eval.sealed_hdf5 import HASH, sealed
from nightmap_eval.trajectory import read_truth
from nightmap_site.checked_reading import using
from nightmap_site.script_errors import DataError

from night import rays

NUM_VISITS = 2
NOISE_M = 0.01  # fresh noise of a range
GAP_M = 8.0  # between the walls of two copies
NUM_COLUMNS, COLUMN_M = 12, (0.1, 0.3)  # of a copy: their number and radii
FREE_M, BESIDE_M = 0.4, 1.2  # a column stands so far from all of the way, and at most so far beside some of it
STEP_M, PERIOD_NS = 0.1, 100_000_000  # between scans in a tunnel
WHEELS_PER_SCAN = 2
WHEEL_SCALE = 1.01  # of the wheels in a tunnel, as synthesize makes them


class Log:
    """The samples of a signals file of one sensor."""

    def __init__(self, path):
        with using(path), h5py.File(path) as file:
            self.attributes = {name: value for name, value in file.attrs.items() if name != HASH}
            self.mounting = {name: file[name][()] for name in ("robot_from_sensor", "scan_duration_s") if name in file}
            self.time_ns, self.value = file["time_ns"][:].ravel(), file["value"][:]
            self.ranges_m = file["range_m"][:].reshape(len(self.time_ns), -1)  # scans of as many beams each
            if len(file["sample_offset"]) != 2:
                raise DataError(f"{path}: {len(file['sample_offset']) - 1} sensors; take a site of one")

    def write(self, path, time_ns, value, ranges_m):
        """`ranges_m`: the rows in parts, in order."""
        num_beams = self.ranges_m.shape[1]
        with sealed(path) as file:
            file.attrs.update(self.attributes)
            for name, data in self.mounting.items():
                file[name] = data
            file["sample_offset"] = np.array([[0], [len(time_ns)]], np.int64)
            file["time_ns"], file["value"] = time_ns[:, None], value
            file["range_offset"] = num_beams * np.arange(len(time_ns) + 1, dtype=np.int64)[:, None]
            ranges, at = file.create_dataset("range_m", (len(time_ns) * num_beams, 1), np.float32), 0
            for part in ranges_m:
                ranges[at : at + part.size] = part.reshape(-1, 1)
                at += part.size


class Source:
    """A mapped laser site: scans all around the robot, wheels, and a true pose of each scan."""

    def __init__(self, folder):
        self.scans, self.wheels = Log(folder / "frames/scans.h5"), Log(folder / "frames/odometry.h5")
        truth = read_truth(folder / "frames/robot_truth.tum")
        if not np.array_equal(truth.times_ns, self.scans.time_ns):
            raise DataError(f"{folder}/frames/robot_truth.tum: not one pose at each scan; take a made-up site")
        first, step, self.limit_m = self.scans.value[0]
        self.angles_rad = first + step * np.arange(self.scans.ranges_m.shape[1])
        if abs(len(self.angles_rad) * step - 2 * np.pi) > step:
            raise DataError(f"{folder}/frames/scans.h5: the scans do not look all around; take a site where they do")
        self.poses = to_rows(truth)
        points_m = np.concatenate([self.points_m(row) for row in range(len(self.poses))])
        self.low_m, self.high_m = points_m.min(axis=0), points_m.max(axis=0)

    def points_m(self, row):
        """Hits of a scan in order of the beams, in the site's frame."""
        x, y, heading = self.poses[row]
        ranges_m = self.scans.ranges_m[row]
        hit = ranges_m < self.limit_m
        angles_rad = heading + self.angles_rad[hit]
        return np.column_stack([x + ranges_m[hit] * np.cos(angles_rad), y + ranges_m[hit] * np.sin(angles_rad)])


def ring(num):
    """Rows and columns of `num` places, each beside the one before, and the last one near the first."""
    rows = 2 * max(1, round(np.sqrt(num) / 2))
    columns = -(-num // rows)
    places = [(row, column if row % 2 == 0 else columns - column) for row in range(rows) for column in range(1, columns)]
    return [*places, *((row, 0) for row in reversed(range(rows)))][:num]


@dataclass
class Leg:
    """A part of the way: the source's drive in a copy, or a tunnel. Times are from its begin."""

    time_ns: np.ndarray
    poses: np.ndarray  # of the scans, in the composed site
    wheel_ns: np.ndarray
    wheels: np.ndarray  # rows from the leg's begin
    wheels_at_end: np.ndarray
    duration_ns: int


class Composer:
    def __init__(self, source, num_scans):
        self.source = source
        extent_m = (source.high_m - source.low_m).max() + GAP_M
        steps = round(extent_m / STEP_M)  # about as many scans of a tunnel
        self.num_copies = max(2, round(num_scans / NUM_VISITS / (len(source.poses) + steps)))
        self.offsets_m = extent_m * np.array(ring(self.num_copies), float)[:, ::-1]
        self.columns = [self.furnish(copy) for copy in range(self.num_copies)]
        self.tunnels = [rays.Tunnel(self.end(copy), self.begin(copy + 1), self.source.points_m(-1) + self.offset_m(copy),
                                    self.source.points_m(0) + self.offset_m(copy + 1), copy)
                        for copy in range(self.num_copies)]  # fmt: skip
        self.legs = [leg for copy in range(self.num_copies) for leg in (self.drive(copy), self.tunnel(copy))] * NUM_VISITS

    def offset_m(self, copy):
        return self.offsets_m[copy % self.num_copies]

    def begin(self, copy):
        return self.source.poses[0] + [*self.offset_m(copy), 0]

    def end(self, copy):
        return self.source.poses[-1] + [*self.offset_m(copy), 0]

    def furnish(self, copy):
        """x, y, radius of the columns, in the source's frame. They stand beside the way, where they hide nothing behind them."""
        rng, way_m, columns = np.random.default_rng([copy, 1]), self.source.poses[:, :2], []
        while len(columns) < NUM_COLUMNS:
            radius_m = rng.uniform(*COLUMN_M)
            place_m = way_m[rng.integers(len(way_m))] + rng.uniform(-BESIDE_M, BESIDE_M, 2)
            if np.linalg.norm(way_m - place_m, axis=1).min() > FREE_M + radius_m:
                columns.append((*place_m, radius_m))
        return np.array(columns)

    def drive(self, copy):
        source = self.source
        start_ns, end_ns = source.scans.time_ns[[0, -1]]
        inside = (source.wheels.time_ns >= start_ns) & (source.wheels.time_ns <= end_ns)
        wheels = compose(inverse(source.wheels.value[inside][0]), source.wheels.value[inside])
        return Leg(source.scans.time_ns - start_ns, source.poses + [*self.offset_m(copy), 0],
                   source.wheels.time_ns[inside] - start_ns, wheels, wheels[-1], int(end_ns - start_ns) + PERIOD_NS)  # fmt: skip

    def tunnel(self, copy):
        """From the end of a copy to the begin of the next, without both; it turns on its way."""
        begin, end = self.end(copy), self.begin(copy + 1)
        motion = np.array([*(end - begin)[:2], wrapped_rad(end[2] - begin[2])])
        count = max(2, round(np.linalg.norm(motion[:2]) / STEP_M))
        fine = begin + np.linspace(0, 1, WHEELS_PER_SCAN * count + 1)[:, None] * motion
        wheels = compose(inverse(fine[0]), fine) * [WHEEL_SCALE, WHEEL_SCALE, 1]
        wheel_ns = np.arange(len(fine)) * (PERIOD_NS // WHEELS_PER_SCAN) - PERIOD_NS
        poses = fine[WHEELS_PER_SCAN:-1:WHEELS_PER_SCAN]
        return Leg(np.arange(len(poses)) * PERIOD_NS, poses, wheel_ns[1:-1], wheels[1:-1], wheels[-1], len(poses) * PERIOD_NS)

    def ranges(self):
        """The ranges of each leg's scans, one leg after the other."""
        source = self.source
        for number, leg in enumerate(self.legs):
            copy = number // 2 % self.num_copies
            if number % 2 == 0:
                local = leg.poses - [*self.offset_m(copy), 0]
                ranges_m = np.minimum(source.scans.ranges_m, rays.to_columns(local, source.angles_rad, self.columns[copy]))
            else:
                ranges_m = self.tunnels[copy].ranges_m(leg.poses, source.angles_rad)
            hit = ranges_m < source.limit_m
            noise_m = np.random.default_rng([number, 2]).normal(0, NOISE_M, ranges_m.shape)
            yield np.where(hit, np.maximum(ranges_m + noise_m, 0.01), source.limit_m).astype(np.float32)

    def write(self, folder):
        """frames/scans.h5 and odometry.h5. Returns the true poses of all scans."""
        (folder / "frames").mkdir(parents=True)
        times_ns, wheel_ns, wheels, now_ns, start = [], [], [], int(self.source.scans.time_ns[0]), np.zeros(3)
        for leg in self.legs:
            times_ns.append(now_ns + leg.time_ns)
            wheel_ns.append(now_ns + leg.wheel_ns)
            wheels.append(compose(start, leg.wheels))
            start, now_ns = compose(start, leg.wheels_at_end)[0], now_ns + leg.duration_ns
        times_ns, wheel_ns, wheels = map(np.concatenate, (times_ns, wheel_ns, wheels))
        scans = self.source.scans
        scans.write(folder / "frames/scans.h5", times_ns, np.repeat(scans.value[:1], len(times_ns), 0), self.ranges())
        self.source.wheels.write(folder / "frames/odometry.h5", wheel_ns, wheels, ())
        return to_trajectory(times_ns, np.concatenate([leg.poses for leg in self.legs]))
