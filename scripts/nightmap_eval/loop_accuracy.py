# SPDX-License-Identifier: Apache-2.0
"""Compares loop closures with the truth: false accepted loops, and revisits that a loop closed."""

from collections import Counter

import numpy as np
from scipy.spatial import cKDTree

from nightmap_eval.artifacts import read_csv, read_hdf5
from nightmap_eval.trajectory import angles_deg, rotation_matrices, travelled_m
from nightmap_site.checked_reading import REMEDY, using
from nightmap_site.script_errors import DataError

MAX_ERROR_M, MAX_ERROR_DEG = 0.3, 10  # largest error of a true loop's relative pose
REVISIT_M, REVISIT_DEG = 0.5, 20  # a frame is a revisit within this distance of an earlier frame ...
REVISIT_PATH_M = 3  # ... that lies at least this much path back
REVISIT_FRAMES = 10  # a loop of a frame at most this many frames away closes a revisit


def read_loops(path):
    """Rows of loops.csv with frame_a and frame_b as numbers."""
    rows = read_csv(path, ("frame_a", "frame_b", "status", "reason"))
    for number, row in enumerate(rows, 2):
        try:
            row["frame_a"], row["frame_b"] = int(row["frame_a"]), int(row["frame_b"])
        except ValueError as error:
            raise DataError(f"{path}:{number}: {error}; {REMEDY}") from None
    return rows


def read_relative_poses(path):
    """(frame_a, frame_b) -> measured (rotation, translation) of b_from_a, of loops/loops.h5."""
    frames, poses = read_hdf5(path, "frame", "b_from_a")
    with using(path):
        rotations = rotation_matrices(poses[:, 3:])
        return {(a, b): (r, t) for (a, b), r, t in zip(frames.tolist(), rotations, poses[:, :3], strict=True)}


def loop_counts(rows):
    """Counts loops by status, and rejected loops by reason."""
    rejected = [row["reason"] for row in rows if row["status"] != "accepted"]
    return {"num_accepted": len(rows) - len(rejected), "num_rejected": len(rejected), "rejected_by_reason": dict(Counter(rejected))}


def is_true_loop(row, relative, rotation_of, position_of, max_error_m):
    """Whether the measured relative pose agrees with the truth."""
    a, b = row["frame_a"], row["frame_b"]
    if (a, b) not in relative:
        raise DataError(f"loops.csv of pose_graph names frames {a} and {b}, of which the job loops found no "
                        "loop; delete both files and run make again")
    rotation, translation = relative[a, b]
    true_rotation = rotation_of[b].T @ rotation_of[a]
    true_translation = rotation_of[b].T @ (position_of[a] - position_of[b])
    error_deg = angles_deg((rotation @ true_rotation.T)[None])[0]
    return np.linalg.norm(translation - true_translation) < max_error_m and error_deg < MAX_ERROR_DEG


def revisiting_frames(frame_idxs, truth):
    """Frames whose view the camera saw before, at least REVISIT_PATH_M of path back."""
    path_m, rotations, revisits = travelled_m(truth.positions_m), truth.rotations(), []
    num_earlier, places = np.searchsorted(path_m, path_m - REVISIT_PATH_M, side="right"), cKDTree(truth.positions_m)
    for i, frame_idx in enumerate(frame_idxs):
        near = np.array(places.query_ball_point(truth.positions_m[i], np.nextafter(REVISIT_M, 0)))  # itself, too
        turned = rotations[near[near < num_earlier[i]]].transpose(0, 2, 1) @ rotations[i]
        if len(turned) and angles_deg(turned).min() < REVISIT_DEG:
            revisits.append(int(frame_idx))
    return revisits


def near_any(frame_idxs, others, reach):
    """Whether one of `others` (ascending) lies within `reach` of each frame."""
    after = np.searchsorted(others, np.asarray(frame_idxs) - reach)
    return np.r_[others, np.inf][after] <= np.asarray(frame_idxs) + reach


def loop_metrics(rows, relative, frame_idxs, truth, max_error_m=MAX_ERROR_M):
    """`truth` are the true poses of the frames `frame_idxs` (ascending)."""
    rotation_of = dict(zip(frame_idxs.tolist(), truth.rotations()))
    position_of = dict(zip(frame_idxs.tolist(), truth.positions_m))
    accepted = [row for row in rows if row["status"] == "accepted"
                and row["frame_a"] in rotation_of and row["frame_b"] in rotation_of]  # fmt: skip
    is_true = [is_true_loop(row, relative, rotation_of, position_of, max_error_m) for row in accepted]
    revisits = revisiting_frames(frame_idxs, truth)
    closed = near_any(revisits, sorted(row["frame_b"] for row, good in zip(accepted, is_true) if good), REVISIT_FRAMES)
    return {
        "num_false_accepted": len(is_true) - sum(is_true),
        "num_revisiting_frames": len(revisits),
        "revisits_closed_percent": 100 * float(np.mean(closed)) if revisits else None,
    }
