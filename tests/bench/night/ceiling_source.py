# SPDX-License-Identifier: Apache-2.0
"""A mapped site of an upward camera, whose way and tracks are the material of a night."""

import csv

import numpy as np

import checkout  # noqa: F401  first: it makes the packages of scripts/ importable
from nightmap_eval.trajectory import interpolated, read_truth
from nightmap_site.checked_reading import read_text, using
from nightmap_site.script_errors import DataError
from nightmap_site.unit_lists import read_shards

from night.source import MAX_GAP_NS, read_table

MAX_AHEAD_RAD, MAX_ASIDE_M = 0.03, 0.1  # between the ends of the part of the way that is copied
ABOUT = 0.8  # of the farthest
SAME_PX = 1.0  # of a track, where two shards meet


def turn_of(angles_rad):
    """Rotations in the plane, N x 2 x 2."""
    cos, sin = np.cos(angles_rad), np.sin(angles_rad)
    return np.stack([np.stack([cos, -sin], -1), np.stack([sin, cos], -1)], -2)


def wrapped(angles_rad):
    return np.angle(np.exp(1j * np.asarray(angles_rad)))


def moved(pose, poses):
    """`pose` (x, y, heading) times each of `poses`."""
    return np.c_[poses[:, :2] @ turn_of(pose[2]).T + pose[:2], wrapped(poses[:, 2] + pose[2])]


class Source:
    """A mapped site of one upward camera: its frames, robot's true poses, and tracks joined over its shards."""

    def __init__(self, folder):
        self.folder, self.rows = folder, []
        names = read_shards(folder)
        for name in names:
            with using(folder / f"frames/shard_{name}.csv"):
                self.header, *rows = csv.reader(read_text(folder / f"frames/shard_{name}.csv").splitlines())
                self.rows += rows
        times_ns = np.array([int(row[1]) for row in self.rows])
        known, truth = interpolated(read_truth(folder / "frames/robot_truth.tum"), times_ns, MAX_GAP_NS)
        if len(known) < len(times_ns):
            raise DataError(f"{folder}/frames/robot_truth.tum: frames have no true pose; take a site that has one for each")
        ahead = truth.rotations()[:, :2, 0]
        self.step_ns = int(np.median(np.diff(times_ns)))
        self.poses = np.c_[truth.positions_m[:, :2], np.arctan2(ahead[:, 1], ahead[:, 0])]
        self.height_m = float(truth.positions_m[0, 2])
        self.shards = [read_table(folder / f"matches/shard_{name}.h5") for name in names]
        self._join()

    def _join(self):
        """One row per sighting of any frame; a track keeps the id that it has in the first shard."""
        parts, last = [], None
        for shard in self.shards:
            counts = np.diff(shard["first_sighting"][:, 0])
            frames = np.repeat(shard["frame_idx"][:, 0], counts)
            part = [frames, shard["track_id"][:, 0].copy(), shard["px"], shard["raw_px"]]
            if last is not None:
                shared = frames == shard["frame_idx"][0, 0]
                renamed = same_tracks(last, [column[shared] for column in part])
                part[1] = np.array([renamed.get(track, track) for track in part[1].tolist()])
                part = [column[~shared] for column in part]
            ends = part[0] == part[0][-1]
            last = [column[ends] for column in part]
            parts.append(part)
        self.frames, self.tracks, self.px, self.raw_px = map(np.concatenate, zip(*parts, strict=True))
        pairs = zip(self.shards[::-1], strict=True)  # the first shard that has a track describes it
        self.descriptors = {track: row for (shard,) in pairs
                            for track, row in zip(shard["born_track_id"][:, 0].tolist(), shard["descriptor"], strict=True)}  # fmt: skip

    def choose_unit(self, max_frames):
        """(first, last) frame of the longest part, of at most so many, of those that lead about farthest straight ahead."""
        ahead_m = np.zeros((len(self.poses), max_frames))
        for first, pose in enumerate(self.poses):
            others = self.poses[first : first + max_frames]
            steps = (others[:, :2] - pose[:2]) @ turn_of(pose[2])
            fits = (np.abs(wrapped(others[:, 2] - pose[2])) < MAX_AHEAD_RAD) & (np.abs(steps[:, 1]) < MAX_ASIDE_M)
            ahead_m[first, : len(others)] = np.where(fits, steps[:, 0], 0)
        if ahead_m.max() <= 0:
            raise DataError(f"{self.folder}: no {max_frames} frames lead straight ahead; name the unit")
        parts = np.argwhere(ahead_m >= ABOUT * ahead_m.max())
        first, more = parts[np.argmax(parts[:, 1])]
        return int(first), int(first + more)


def same_tracks(before, after):
    """Later id -> earlier id of tracks at one pixel; columns are frame, id, pixel, pixel of the picture."""
    renamed = {}
    away_px = np.linalg.norm(before[3][:, None] - after[3][None], axis=2)
    for i in np.flatnonzero(away_px.min(axis=1) <= SAME_PX):
        j = int(np.argmin(away_px[i]))
        if np.argmin(away_px[:, j]) == i:
            renamed[int(after[1][j])] = int(before[1][i])
    return renamed
