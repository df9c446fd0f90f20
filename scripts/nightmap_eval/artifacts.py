# SPDX-License-Identifier: Apache-2.0
"""Readers of the artifacts under maps/<site>/, and the atomic writer of the scripts' outputs."""

import fcntl
import hashlib
import json
import os
import shutil
import tempfile
from contextlib import contextmanager
from pathlib import Path

import h5py
import numpy as np

from nightmap_eval.sealed_hdf5 import checked_array, checked_text
from nightmap_site.checked_reading import NUMBER, REMEDY, read_csv, read_object, read_text, using
from nightmap_site.script_errors import DataError, writing
from nightmap_site.unit_lists import read_shards, whole

BRIDGED, STARTED = 1, 2  # states of the odometry: a guessed pose; the start of a part that only a guess joins to what is before


def to_ints(rows, column, path):
    try:
        return np.array([int(row[column]) for row in rows], dtype=np.int64)
    except (ValueError, OverflowError) as error:
        raise DataError(f"{path}: column {column}: {error}; {REMEDY}") from None


def read_hdf5(path, *names):
    with _open_hdf5(path) as file:
        return [checked_array(path, file, name) for name in names]


def read_landmarks(path, *names):
    """Arrays of landmarks.h5, those of all regions one behind the other; offsets and indices of landmarks count on."""
    with _open_hdf5(path) as file:
        first = np.cumsum([0, *checked_array(path, file, "regions/num_landmarks").ravel()])
        parts = {name: [checked_array(path, file, f"region_{i}/{name}") for i in range(len(first) - 1)] for name in names}
        if "descriptors/landmark_idx" in parts:
            parts["descriptors/landmark_idx"] = [part + n for part, n in zip(parts["descriptors/landmark_idx"], first)]
        if "observations/offsets" in parts:
            counts = np.concatenate([np.diff(part, axis=0) for part in parts["observations/offsets"]])
            parts["observations/offsets"] = [np.zeros((1, 1), np.int64), np.cumsum(counts, axis=0)]
        return [np.concatenate(parts[name]) for name in names]


def read_sensor_ids(path):
    (offsets,) = read_hdf5(path, "sample_offset")
    with _open_hdf5(path) as file:
        return [checked_text(file, f"sensor_{i}") for i in range(len(offsets) - 1)]


@contextmanager
def _open_hdf5(path):
    try:
        with h5py.File(path) as file:
            yield file
    except (OSError, RuntimeError, KeyError, ValueError, TypeError, AttributeError) as error:
        raise DataError(f"{path}: {error}; {REMEDY}") from None


def shard_names(site):
    site.path("frames", "shards")  # refuses another list than the job wrote
    return whole(read_shards, site.folder)


class Frames:
    """The mapping frames of a site, in order; each row has the name of its shard."""

    def __init__(self, site):
        self.rows = []
        for name in shard_names(site):
            rows = read_csv(site.path("frames", "shard", name), ("frame_idx", "time_ns", "sequence_idx", "color_path"))
            self.rows += [row | {"shard": name} for row in rows]
        source = site.folder_of("frames")
        self.frame_idxs = to_ints(self.rows, "frame_idx", source)
        self.times_ns = to_ints(self.rows, "time_ns", source)
        self.sequence_idxs = to_ints(self.rows, "sequence_idx", source)
        if len(set(self.times_ns)) != len(self.rows):
            raise DataError(f"{source}: two frames with the same time_ns")

    def __len__(self):
        return len(self.rows)

    def by_index(self):
        """frame_idx -> row."""
        return dict(zip(self.frame_idxs.tolist(), self.rows))


def tracking_states(site, shard):
    """The frames of a shard, and their states by its odometry; none where the site has no odometry of shards."""
    path = site.made("odometry", "odometry", shard)
    if not path:
        return np.zeros(0, np.int64), np.zeros(0, np.int64)
    frame_idxs, states = read_hdf5(path, "frame_idx", "state")
    with using(path):
        if np.ravel(frame_idxs).shape != np.ravel(states).astype(int).shape:
            raise ValueError(f"{len(states)} states of {len(frame_idxs)} frames")
    return np.ravel(frame_idxs), np.ravel(states)


def bridged_frames(site):
    """Frames without a verified pair: odometry guessed their pose."""
    shards = [tracking_states(site, name) for name in shard_names(site)]
    return [idx for frame_idxs, states in shards for idx in frame_idxs[states == BRIDGED].tolist()]


def frames_apart(site):
    """Frames outside the largest part of the map: only guessed motion connects them to it."""
    path = site.made("pose_graph", "report")
    report = read_object(path, {"?parts": [{"runs": [[int]]}]}) if path else {}
    with using(path):
        runs = [run for part in report.get("parts", [])[1:] for run in part["runs"]]
        return sorted(idx for first, last in runs for idx in range(first, last + 1))


def num_unusable_frames(site):
    """Frames that the frames stage left out: missing, truncated, or of a wrong size."""
    path = site.made("frames", "report")
    report = read_object(path, {"?num_frames_unusable": int}) if path else {}
    return report.get("num_frames_unusable", 0)


APART = {"?ground_truths_apart": [{"file": str, "apart_s": NUMBER}]}


def truths_apart(site):
    """(file, least time to a frame in s, what is wrong) of each ground truth that the site config names and that fits no frame or query."""
    for path in filter(None, (site.made(job, "report") for job in ("frames", "queries"))):
        for truth in read_object(path, APART).get("ground_truths_apart", []):
            yield truth["file"], truth["apart_s"], (
                f"gives no frame a pose: the nearest of its times is {truth['apart_s']:.6g} s from a frame's; correct its times to the "
                "clock of the frames, or name another ground_truth (time_offset_s moves both)")  # fmt: skip


def _rounded(value):
    """Rounds to nine significant digits and twelve decimals: the last bits depend on the BLAS."""
    if isinstance(value, dict):
        return {key: _rounded(item) for key, item in value.items()}
    if isinstance(value, (list, tuple, np.ndarray)):
        return [_rounded(item) for item in value]
    if isinstance(value, (bool, np.bool_)):
        return bool(value)
    if isinstance(value, (float, np.floating)):
        return round(float(f"{value:.9g}"), 12) + 0.0  # + 0.0 turns a negative zero into zero
    if isinstance(value, np.integer):
        return int(value)
    return value


def to_json(value):
    """JSON text; raises DataError on NaN or infinity, which JSON lacks."""
    try:
        return json.dumps(_rounded(value), indent=2, allow_nan=False) + "\n"
    except ValueError:
        raise DataError("a metric is NaN or infinite; nothing was written") from None


def hash_if_there(path):
    """SHA-256 of a file, as hex digits; None when it is missing."""
    return hashlib.sha256(Path(path).read_bytes()).hexdigest() if Path(path).exists() else None


def write_atomic(path, content):
    """Writes text or bytes in a folder of this run, flushes to disk and renames: readers see the old or the new file.

    Raises DataError when the path holds anything but a plain file."""
    path = Path(path)
    if path.exists() and not path.is_file():
        raise DataError(f"{path}: is no plain file; give the path of a file to make")
    path.parent.mkdir(parents=True, exist_ok=True)
    with writing(path), WritingFolder(path.parent) as folder:
        temporary = folder / path.name
        with open(temporary, "wb") as file:
            file.write(content.encode() if isinstance(content, str) else content)
            file.flush()
            os.fsync(file.fileno())
        os.replace(temporary, path)


def put_between(path, begin, end, text):
    before, has_begin, rest = read_text(path, "correct it").partition(begin)
    _, has_end, after = rest.partition(end)
    if not has_begin or not has_end:
        raise DataError(f"{path}: no markers {begin} and {end}")
    write_atomic(path, f"{before}{begin}\n{text}{end}{after}")


def _lock(path, how):
    """A descriptor that holds the lock of a folder; None when the folder is gone or another process holds the lock."""
    try:
        descriptor = os.open(path, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW | os.O_CLOEXEC)
    except OSError:
        return None
    try:
        fcntl.flock(descriptor, how)
        return descriptor
    except OSError:
        os.close(descriptor)
        return None


def _remove_left_behind(parent, prefix):
    for path in parent.glob(f"{prefix}*"):
        if "." in path.name.removeprefix(prefix):
            continue  # it belongs to a host with a longer name
        descriptor = _lock(path, fcntl.LOCK_EX | fcntl.LOCK_NB)
        if descriptor is not None:
            shutil.rmtree(path, ignore_errors=True)
            os.close(descriptor)


class WritingFolder:
    """Like pipeline/base/writing_folder.h: `.writing.<host>.<random>` in a folder, removed with its content at the end of `with`.

    The next run of a script or stage on this host removes the folder of a killed run, whose lock is free."""

    def __init__(self, parent):
        prefix = f".writing.{os.uname().nodename}."
        _remove_left_behind(Path(parent), prefix)
        while True:
            self.path = Path(tempfile.mkdtemp(prefix=prefix, dir=parent))
            self._descriptor = _lock(self.path, fcntl.LOCK_EX)
            if self.path.exists():  # otherwise another run removed it before the lock was held
                break

    def remove(self):
        shutil.rmtree(self.path, ignore_errors=True)
        if self._descriptor is not None:
            os.close(self._descriptor)
            self._descriptor = None

    def __enter__(self):
        return self.path

    def __exit__(self, *_):
        self.remove()
