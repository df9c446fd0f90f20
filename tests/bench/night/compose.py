# SPDX-License-Identifier: Apache-2.0
"""Composes a site of any number of frames out of a real one: a row of copies of some of its shards, along which the way leads twice.

Each copy looks different, as the bytes of its descriptors have an order of their own; within a copy nothing changes. A real motion
of the source leads from the last frame of a copy to the first of the next, which, like some after it, sees the points of the former
behind its own features. The second visit is a recording of its own with fresh noise. Shards are made one at a time.
"""

import csv
import shutil
from dataclasses import dataclass

import numpy as np
from stage_run import Programs  # first: it makes the packages of scripts/ importable

from nightmap_eval.trajectory import Trajectory, quaternion
from nightmap_site.script_errors import DataError

from night import copies
from night.source import MAX_TURN_RAD, Source, heading_rad, read_table, turned

NUM_VISITS = 2
NUM_JOINED = 4  # described frames of a copy that see the last one of the copy before: adjust may drop some
JOBS = ("features", "matches", "odometry")
SIGNALS = ("acceleration.h5",)  # of the source's frames, which map_frame asks for


@dataclass
class Place:
    """A shard of the composed site."""

    visit: int
    copy: int  # in the row; both visits see the same
    shard: int  # of the source
    first_frame: int
    number: int


class Row:
    """Poses of the copies: next_from_this is a motion in the plane, the same for each."""

    def __init__(self, source, first, last):
        begin, end = source.first_frames[first], source.first_frames[last + 1] - 1
        reference = source.table("features", last)
        described = reference["frame_idx"][copies.is_described(reference), 0]
        if described[-1] != end or len(described) < 2:
            raise DataError(f"{source.folder}: shard {source.names[last]} does not end with a described frame after another")
        start, before, stop = source.poses[begin], source.poses[described[-2]], source.poses[end]
        ahead = stop @ np.linalg.inv(before) @ stop  # one more step like the last one
        turn_rad = np.angle(np.exp(1j * (heading_rad(ahead) - heading_rad(start))))
        self.this_from_next = np.eye(4)  # a copy turns only as much as the camera cannot at one step
        self.this_from_next[:3, :3] = turned(0 if abs(turn_rad) < MAX_TURN_RAD else turn_rad)
        self.this_from_next[:2, 3] = (ahead[:3, 3] - self.this_from_next[:3, :3] @ start[:3, 3])[:2]
        shard = source.table("features", first)
        joined = np.flatnonzero(copies.is_described(shard))[:NUM_JOINED]
        self.cameras_from_last = {frame: np.linalg.inv(self.this_from_next @ source.poses[begin + frame]) @ stop for frame in joined}

    def world_from_copy(self, copy):
        return np.linalg.matrix_power(self.this_from_next, copy)


class Composer:
    """A site of about `num_frames` frames: both visits have half of them, up to whole shards."""

    def __init__(self, source, unit, num_frames, programs, seed=0):
        self.source, self.programs, self.seed = source, programs, seed
        self.first, self.last = unit
        self.row = Row(source, *unit)
        self.begin = source.first_frames[self.first]
        self.unit_frames = int(source.first_frames[self.last + 1] - self.begin)
        step_ns = source.times_ns[self.begin + 1] - source.times_ns[self.begin]
        self.unit_ns = int(source.times_ns[self.begin + self.unit_frames - 1] - source.times_ns[self.begin] + step_ns)
        self.places = self._places(num_frames / NUM_VISITS)
        self.visit_frames = self.places[-1].first_frame + self._size(self.last_shard) - self.places[len(self) // 2].first_frame
        self.num_copies = self.places[-1].copy + 1

    def __len__(self):
        return len(self.places)

    @property
    def last_shard(self):
        return self.places[-1].shard

    @property
    def num_frames(self):
        return NUM_VISITS * self.visit_frames

    def _size(self, shard):
        return len(self.source.rows[shard])

    def _places(self, visit_frames):
        places, frame = [], 0
        for visit in range(NUM_VISITS):
            copy, shard, end = 0, self.first, frame + visit_frames
            while frame + self._size(shard) / 2 <= end or not places:
                places.append(Place(visit, copy, shard, frame, len(places)))
                frame += self._size(shard)
                copy, shard = (copy, shard + 1) if shard < self.last else (copy + 1, self.first)
            visit_frames = frame  # the second visit ends where the first does
        return places

    def truth(self):
        """The true poses of all frames."""
        poses = [self.row.world_from_copy(place.copy) @ self.source.poses[self._frames_of(place)] for place in self.places]
        times_ns = [self._times_ns(place) for place in self.places]
        poses = np.concatenate(poses)
        return Trajectory(np.concatenate(times_ns), poses[:, :3, 3], np.array([quaternion(pose[:3, :3]) for pose in poses]))

    def copy_of_frames(self):
        """The copy that each frame is in; both visits see the same."""
        return np.repeat([place.copy for place in self.places], [self._size(place.shard) for place in self.places])

    def _frames_of(self, place):
        return slice(*self.source.first_frames[place.shard : place.shard + 2])

    def _times_ns(self, place):
        return self.source.times_ns[self._frames_of(place)] + self._part(place) * self.unit_ns

    def _part(self, place):
        """Number of the copy in both visits."""
        return place.visit * self.num_copies + place.copy

    def write(self, folder):
        """Writes the site's artifacts, and links in folder/data that lead to `data`, the recordings of the source."""
        for job in ("frames", *JOBS):
            (folder / job).mkdir(parents=True)
        for name in ("cameras.json", *SIGNALS):
            shutil.copyfile(self.source.folder / "frames" / name, folder / "frames" / name)
        for place in self.places:
            self._write_frames(folder, place)
            self._features(place).write(self._path(folder, "features", place))
            self._write_motion(folder, place)
        truth = self.truth()
        write_tum(folder / "frames/ground_truth.tum", truth)
        return truth

    @staticmethod
    def _path(folder, job, place, ending="h5"):
        return folder / job / f"shard_{place.number:04}.{ending}"

    def _write_frames(self, folder, place):
        rows = []
        for number, (time_ns, row) in enumerate(zip(self._times_ns(place), self.source.rows[place.shard], strict=True)):
            cells = [f"{self._part(place)}/{cell}" if name.endswith("_path") and cell else cell
                     for name, cell in zip(self.source.header[4:], row[4:], strict=True)]  # fmt: skip
            rows.append([place.first_frame + number, time_ns, row[2], place.visit, *cells])
        with open(self._path(folder, "frames", place, "csv"), "w", encoding="utf-8", newline="") as file:
            csv.writer(file, lineterminator="\n").writerows([self.source.header, *rows])

    def _shift(self, place):
        return place.first_frame - int(self.source.first_frames[place.shard])

    def _features(self, place):
        features = copies.shifted_features(self.source.table("features", place.shard), self._shift(place))
        order, is_joined, order_before = copies.permutation(self.seed, place.copy), None, None
        if place.shard == self.first and place.copy > 0:
            before = self.source.table("features", self.last)
            rng = np.random.default_rng(self.seed)  # the same points in each copy
            features, is_joined = copies.joined(features, before, self.row.cameras_from_last, self.source, rng)
            order_before = copies.permutation(self.seed, place.copy - 1)
        features = copies.repainted(features, order, is_joined, order_before)
        if place.visit == 0:
            return features
        return copies.noised(features, np.random.default_rng([self.seed, place.number]))

    def _write_motion(self, folder, place):
        """Pairs and odometry: the source's; those of the first shard of a visit and of the first joined one, by the programs; those
        of the other joined ones, which see the same, from that."""
        if place.shard != self.first:
            pairs, odometry = (self.source.table(job, place.shard) for job in JOBS[1:])
            shift = self._shift(place)
        elif place.copy == 0 or (place.copy, place.visit) == (1, 0):
            self._run_programs(folder, place)
            return
        else:
            joined = next(other for other in self.places if other.copy == 1)
            pairs, odometry = (read_table(self._path(folder, job, joined)) for job in JOBS[1:])
            shift = place.first_frame - joined.first_frame
        copies.shifted_pairs(pairs, shift).write(self._path(folder, "matches", place))
        copies.shifted_odometry(odometry, shift).write(self._path(folder, "odometry", place))

    def _run_programs(self, folder, place):
        given = self.places[max(0, place.number - 1) : place.number + 1]
        inputs = {"frames": [self._path(folder, "frames", other, "csv") for other in given],
                  "features": [self._path(folder, "features", other) for other in given],
                  "cameras": folder / "frames/cameras.json"}  # fmt: skip
        run = folder / "programs"
        self.programs.run("matches", inputs, {"pairs": "pairs.h5"}, run)
        self.programs.run("odometry", inputs | {"pairs": run / "pairs.h5"}, {"odometry": "odometry.h5"}, run)
        (run / "pairs.h5").rename(self._path(folder, "matches", place))
        (run / "odometry.h5").rename(self._path(folder, "odometry", place))
        shutil.rmtree(run)
        is_bridge = read_table(self._path(folder, "odometry", place))["edge_is_bridge"][0, 0]
        if place.copy > 0 and is_bridge:
            raise DataError(f"{self.source.folder}: no measured motion leads from shard {self.source.names[self.last]} to shard "
                            f"{self.source.names[self.first]} of the next copy; name another unit")  # fmt: skip


def link_data(folder, data, num_parts):
    """A folder of recordings for the frames of the composed site: no picture may be in two frames."""
    folder.mkdir()
    for part in range(num_parts):
        (folder / str(part)).symlink_to(data.resolve())


def write_tum(path, trajectory):
    numbers = np.c_[trajectory.positions_m, trajectory.quaternions]
    with open(path, "w", encoding="utf-8") as file:
        for time_ns, pose in zip(trajectory.times_ns.tolist(), numbers, strict=True):
            file.write(f"{time_ns // 10**9}.{time_ns % 10**9:09} {' '.join(f'{number:.9f}' for number in pose)}\n")
