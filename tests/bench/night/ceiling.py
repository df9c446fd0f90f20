# SPDX-License-Identifier: Apache-2.0
"""Composes what an upward camera saw in a night of any number of pictures, out of a real site's tracks of corners: copies of a part of
its way are the edges of a closed way on a lattice, which the robot drives twice.

Each copy looks different, as the bytes of its descriptors have an order of their own. Where copies meet all tracks end, and at a
corner the robot turns on the spot and sees nothing it knows: only its wheels lead from one copy to the next. Wheels and pixels have
fresh noise in each copy of each lap, those of the second lap have other descriptors too.
"""

import csv
from dataclasses import dataclass

import numpy as np

import checkout  # noqa: F401  first: it makes the packages of scripts/ importable
from nightmap_eval.trajectory import Trajectory
from nightmap_site.checked_reading import read_text

from night.ceiling_source import moved, turn_of, wrapped
from night.compose import write_tum
from night.source import read_table

NUM_LAPS = 2
TRACK_BITS = 20  # a track's id ends with its number in the frame that it begins in
TURN_RAD = 0.08  # from picture to picture, on the spot
NOISE_PX, FLIPPED_BITS = 0.15, 0.05  # the latter is a share, of the second lap
# Errors of the wheels: share of the distance; metres and radians after 1 m; radians after a turn of 1 rad; radians per metre.
WHEELS = {"scale": 0.004, "distance": 0.02, "heading": 0.0175, "turn": 0.01, "bias": 0.001}


def closed_way(num):
    """Vertices of a closed way on a lattice with about `num` edges, in order: along the first row, to and fro, and back."""
    sizes = [(rows, max(2, round(num / rows))) for rows in range(2, max(3, round(2 * np.sqrt(num))), 2)]
    rows, columns = min(sizes, key=lambda size: abs(size[0] * size[1] - num) + 0.5 * abs(size[0] - size[1]))
    way = [(column, 0) for column in range(columns)]
    for row in range(1, rows):
        inner = [(column, row) for column in range(1, columns)]
        way += inner[::-1] if row % 2 else inner
    return np.array([*way, *((0, row) for row in range(rows - 1, 0, -1))])


@dataclass
class Tracks:
    """Sightings of the unit's frames, ordered by frame and track."""

    frames: np.ndarray  # counted from the unit's first
    tracks: np.ndarray  # counted by the frame in which they begin
    px: np.ndarray
    raw_px: np.ndarray
    born: np.ndarray  # per track: its first frame and its number there
    descriptors: np.ndarray


def tracks_of(source, first, last):
    inside = (source.frames >= first) & (source.frames <= last)
    frames, ids = source.frames[inside] - first, source.tracks[inside]
    order = np.lexsort((ids, frames))
    _, begin, of = np.unique(ids[order], return_index=True, return_inverse=True)
    by_birth = np.argsort(begin)  # sightings are ordered by frame, so the first one of a track tells its birth
    rank = np.empty(len(begin), int)
    rank[by_birth] = np.arange(len(begin))
    births = frames[order][begin[by_birth]]
    numbers = np.arange(len(births)) - np.searchsorted(births, births)
    tracks = rank[of]
    again = np.lexsort((tracks, frames[order]))
    rows = order[again]
    descriptors = np.array([source.descriptors[track] for track in ids[order][begin[by_birth]].tolist()])
    return Tracks(frames[rows], tracks[again], source.px[inside][rows], source.raw_px[inside][rows], np.c_[births, numbers], descriptors)


class CeilingNight:
    """A site of about `num_pictures` pictures: two laps of a closed way of copies."""

    def __init__(self, source, unit, num_pictures, seed=0):
        self.source, self.seed, (self.first, self.last) = source, seed, unit
        self.unit = tracks_of(source, *unit)
        self.unit_poses = source.poses[self.first : self.last + 1]
        way = closed_way(num_pictures / NUM_LAPS / len(self.unit_poses))
        self.num_copies = len(way)
        self._place(way)

    def _place(self, way):
        """True poses of all pictures, and the first picture of each part (a copy of a lap)."""
        start, before, end = self.unit_poses[[0, -2, -1]]
        step_m = np.linalg.norm(end[:2] - before[:2])
        chord = end[:2] + step_m * np.array([np.cos(end[2]), np.sin(end[2])]) - start[:2]
        copies = []
        for vertex, after in zip(way, np.roll(way, -1, axis=0), strict=True):
            edge = after - vertex
            turn_rad = np.arctan2(edge[1], edge[0]) - np.arctan2(chord[1], chord[0])
            shift = vertex * np.linalg.norm(chord) - turn_of(turn_rad) @ start[:2]
            copies.append(moved(np.r_[shift, turn_rad], self.unit_poses))
        parts = []
        for lap in range(NUM_LAPS):
            parts += [np.concatenate([copy, on_the_spot(copy[-1], copies[(k + 1) % len(copies)][0])]) for k, copy in enumerate(copies)]
        self.sizes = [len(part) for part in parts]
        self.firsts = np.cumsum([0, *self.sizes])
        self.poses = np.concatenate(parts)
        self.times_ns = int(self.source.rows[0][1]) + self.source.step_ns * np.arange(len(self.poses))

    @property
    def num_frames(self):
        return len(self.poses)

    @property
    def lap_frames(self):
        return self.num_frames // NUM_LAPS

    def truth(self):
        half = self.poses[:, 2] / 2
        zero = np.zeros(len(half))
        return Trajectory(self.times_ns, np.c_[self.poses[:, :2], zero + self.source.height_m], np.c_[zero, zero, np.sin(half), np.cos(half)])

    def write(self, folder):
        """Writes frames and matches of the site, and its truth, which it returns. Paths are relative to folder/data/PART."""
        for job in ("frames", "matches"):
            (folder / job).mkdir(parents=True)
        (folder / "frames/cameras.json").write_text(read_text(self.source.folder / "frames/cameras.json"))
        self._wheels().write(folder / "frames/odometry.h5")
        for part in range(len(self.sizes)):
            self._write_frames(folder / f"frames/shard_{part:04}.csv", part)
            self._tracks(part).write(folder / f"matches/shard_{part:04}.h5")
        truth = self.truth()
        write_tum(folder / "frames/robot_truth.tum", truth)
        return truth

    def _write_frames(self, path, part):
        """A picture on the spot, where nothing is known, is that of the last frame under another path."""
        rows, first = [], self.firsts[part]
        for number in range(self.sizes[part]):
            on_spot = max(0, number + 1 - len(self.unit_poses))
            row = self.source.rows[self.first + number - on_spot]
            cells = [f"{part}/{on_spot * './'}{cell}" if name.endswith("_path") and cell else cell
                     for name, cell in zip(self.source.header[4:], row[4:], strict=True)]  # fmt: skip
            rows.append([first + number, self.times_ns[first + number], row[2], 0, *cells])
        with open(path, "w", encoding="utf-8", newline="") as file:
            csv.writer(file, lineterminator="\n").writerows([self.source.header, *rows])

    def _tracks(self, part):
        lap, copy = divmod(part, self.num_copies)
        rng = np.random.default_rng([self.seed, 1, part])
        unit, first, shared = self.unit, int(self.firsts[part]), int(part > 0)
        noise_px = rng.normal(0, NOISE_PX, unit.px.shape)
        ids = (first + unit.born[:, 0] << TRACK_BITS) + unit.born[:, 1]
        counts = np.zeros(shared + self.sizes[part], int)
        np.add.at(counts, shared + unit.frames, 1)
        descriptors = unit.descriptors[:, np.random.default_rng([self.seed, 2, copy]).permutation(unit.descriptors.shape[1])]
        if lap > 0:
            flipped = rng.random((len(descriptors), 8 * descriptors.shape[1])) < FLIPPED_BITS
            descriptors = descriptors ^ np.packbits(flipped, axis=1)
        frames = np.arange(first - shared, first + self.sizes[part])
        return self.source.shards[0].with_arrays(
            born_track_id=ids, descriptor=descriptors, first_sighting=np.cumsum([0, *counts]), frame_idx=frames,
            is_redetected=np.zeros(len(frames)), median_displacement_px=np.zeros((len(frames), 2)), px=unit.px + noise_px,
            raw_px=unit.raw_px + noise_px, time_ns=self.times_ns[frames], track_id=ids[unit.tracks])  # fmt: skip

    def _wheels(self):
        """A sample per picture, of wheels that measure a little wrong."""
        rng = np.random.default_rng([self.seed, 3])
        steps = np.einsum("nji,nj->ni", turn_of(self.poses[:-1, 2]), np.diff(self.poses[:, :2], axis=0))
        turns = wrapped(np.diff(self.poses[:, 2]))
        way_m = np.linalg.norm(steps, axis=1)
        normal = rng.standard_normal((3, len(turns)))
        scale = 1 + WHEELS["scale"] + WHEELS["distance"] * normal[0] / np.sqrt(np.maximum(way_m, 1e-3))
        turns = turns + WHEELS["bias"] * way_m + WHEELS["heading"] * np.sqrt(way_m) * normal[1]
        turns += WHEELS["turn"] * np.sqrt(np.abs(turns)) * normal[2]
        headings = np.r_[0, np.cumsum(turns)]
        places = np.cumsum(np.einsum("nij,nj->ni", turn_of(headings[:-1]), steps * scale[:, None]), axis=0)
        table = read_table(self.source.folder / "frames/odometry.h5")
        return table.with_arrays(time_ns=self.times_ns, value=np.c_[np.r_[np.zeros((1, 2)), places], wrapped(headings)],
                                 sample_offset=[0, len(headings)], range_offset=np.zeros(len(headings) + 1))  # fmt: skip


def on_the_spot(before, after):
    """Poses between these two, a step apart in heading; none where the robot goes straight on."""
    turn_rad = wrapped(after[2] - before[2])
    share = np.linspace(0, 1, max(1, int(np.ceil(abs(turn_rad) / TURN_RAD))) + 1)[1:-1, None]
    return np.c_[before[:2] + share * (after[:2] - before[:2]), wrapped(before[2] + share * turn_rad)]
