# SPDX-License-Identifier: Apache-2.0
"""A mapped site whose shards are the material of larger sites: its lists, true poses, camera and artifacts."""

import csv
from dataclasses import dataclass

import h5py
import numpy as np

import checkout  # noqa: F401  first: it makes the packages of scripts/ importable
from nightmap_eval.artifacts import read_hdf5
from nightmap_eval.sealed_hdf5 import HASH, sealed
from nightmap_eval.trajectory import interpolated, read_truth
from nightmap_site.checked_reading import read_object, read_text, using
from nightmap_site.script_errors import DataError
from nightmap_site.unit_lists import read_shards

MAX_TURN_RAD = np.radians(10)  # that the camera makes on top of its own motion where copies meet
MAX_GAP_NS = 500_000_000  # between the true poses around a frame


@dataclass
class Table:
    """The arrays and texts of an HDF5 artifact; a copy may have other arrays."""

    arrays: dict
    attributes: dict  # version and texts

    def __getitem__(self, name):
        return self.arrays[name]

    def with_arrays(self, **arrays):
        """The same with other values; the types stay."""
        return Table(self.arrays | {name: np.asarray(values, self.arrays[name].dtype).reshape(-1, self.arrays[name].shape[1])
                                    for name, values in arrays.items()}, self.attributes)  # fmt: skip

    def write(self, path):
        with sealed(path) as file:
            for name, value in self.attributes.items():
                file.attrs[name] = value
            for name, values in self.arrays.items():
                file.create_dataset(name, data=values, track_times=False)


def read_table(path):
    with h5py.File(path) as file:
        names = list(file)
        attributes = {name: value for name, value in file.attrs.items() if name != HASH}
    return Table(dict(zip(names, read_hdf5(path, *names), strict=True)), attributes)


def matrices(trajectory):
    """target_from_camera of each pose, 4 x 4."""
    poses = np.tile(np.eye(4), (len(trajectory), 1, 1))
    poses[:, :3, :3], poses[:, :3, 3] = trajectory.rotations(), trajectory.positions_m
    return poses


def heading_rad(world_from_camera):
    """Direction of the optical axis, in the plane."""
    return np.arctan2(world_from_camera[..., 1, 2], world_from_camera[..., 0, 2])


def turned(angle_rad):
    """The rotation about z, 3 x 3."""
    cos, sin = np.cos(angle_rad), np.sin(angle_rad)
    return np.array([[cos, -sin, 0], [sin, cos, 0], [0, 0, 1]])


class Source:
    """A site with frames, features, matches and odometry, and with true poses in a world whose z points up."""

    def __init__(self, folder):
        self.folder = folder
        self.names = read_shards(folder)
        self.rows, self.header = [], None  # of the list of frames of each shard
        for name in self.names:
            with using(folder / f"frames/shard_{name}.csv"):
                self.header, *rows = csv.reader(read_text(folder / f"frames/shard_{name}.csv").splitlines())
                self.rows.append(rows)
        self.first_frames = np.cumsum([0, *map(len, self.rows)])
        times_ns = np.array([int(row[1]) for rows in self.rows for row in rows])
        known, truth = interpolated(read_truth(folder / "frames/ground_truth.tum"), times_ns, MAX_GAP_NS)
        if len({row[3] for rows in self.rows for row in rows}) > 1:
            raise DataError(f"{folder}: several recordings, whose parts no motion joins; take a site of one")
        if len(known) < len(times_ns):
            raise DataError(f"{folder}/frames/ground_truth.tum: {len(times_ns) - len(known)} frames have no true pose; "
                            "take a site that has one for each")  # fmt: skip
        self.times_ns, self.poses = times_ns, matrices(truth)
        with using(folder / "frames/cameras.json"):
            [camera] = read_object(folder / "frames/cameras.json", {"cameras": [dict]})["cameras"]
        color = camera["color"]
        self.size_px = np.array([color["width"], color["height"]])
        self.focal_px, self.centre_px = np.array([color["fx"], color["fy"]]), np.array([color["cx"], color["cy"]])
        if any(color[name] != 0 for name in ("k1", "k2", "p1", "p2", "k3")):
            raise DataError(f"{folder}: the lens distorts; take a site with pictures that are free of it, as made-up ones are")

    def table(self, job, shard):
        return read_table(self.folder / job / f"shard_{self.names[shard]}.h5")

    def choose_unit(self, max_shards):
        """(first, last) of at most so many shards that lead farthest away and end with the heading that they begin with."""
        best, farthest_m = None, 0.0
        for first in range(len(self.names)):
            for last in range(first, min(first + max_shards, len(self.names))):
                begin, end = self.poses[self.first_frames[first]], self.poses[self.first_frames[last + 1] - 1]
                turn_rad = np.angle(np.exp(1j * (heading_rad(end) - heading_rad(begin))))
                way_m = np.linalg.norm((end - begin)[:2, 3])
                if abs(turn_rad) < MAX_TURN_RAD and way_m > farthest_m:
                    best, farthest_m = (first, last), way_m
        if best is None:
            raise DataError(f"{self.folder}: no {max_shards} shards end with the heading that they begin with; name the unit")
        return best
