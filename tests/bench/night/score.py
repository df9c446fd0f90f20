# SPDX-License-Identifier: Apache-2.0
"""Scores the map of a composed site against its exact truth, in arrays: trajectory and loops."""

import numpy as np

from nightmap_eval.artifacts import read_hdf5
from nightmap_eval.loop_accuracy import MAX_ERROR_M, REVISIT_FRAMES
from nightmap_eval.query_errors import WRONG_CM, local_errors, read_located
from nightmap_eval.trajectory import angles_deg, associate, read_truth, read_tum, rotation_matrices
from nightmap_eval.trajectory_errors import ate, distance_pairs, relative_errors

RPE_M = 10.0
MAX_ERROR_DEG = 5.0  # of a true loop
SAME_NS = 1_000_000  # stamps of one query in two files


def trajectory_figures(path, truth, visit_frames):
    """Errors of a trajectory in the TUM format: ATE after an alignment in SE(3), RMSE of the motion over 10 m of one visit, and how
    many frames have no pose."""
    found = read_tum(path)
    pairs = associate(found.times_ns, truth.times_ns, 0)
    estimate, true = found.select(pairs[:, 0]), truth.select(pairs[:, 1])
    figures, _ = ate(estimate, true, False)
    steps, _ = distance_pairs(true, pairs[:, 1] // visit_frames, RPE_M)
    translation_m, rotation_deg = relative_errors(estimate, true, steps)
    return {"num_without": len(truth) - len(pairs), "ate_m": figures["ate_rmse_m"],
            "rpe_m": float(np.sqrt(np.mean(translation_m**2))), "rpe_deg": float(np.sqrt(np.mean(rotation_deg**2)))}  # fmt: skip


def relative_poses(trajectory, source, target):
    """True rotations and translations of target_from_source between these frames."""
    rotations = trajectory.rotations()
    back = np.transpose(rotations[target], (0, 2, 1))
    return back @ rotations[source], np.einsum("nij,nj->ni", back, trajectory.positions_m[source] - trajectory.positions_m[target])


def true_pairs(frames, b_from_a, truth):
    """Whether the relative pose of each pair of frames agrees with the truth."""
    rotations, steps_m = relative_poses(truth, *frames.T)
    errors_deg = angles_deg(rotation_matrices(b_from_a[:, 3:]) @ np.transpose(rotations, (0, 2, 1)))
    return (np.linalg.norm(b_from_a[:, :3] - steps_m, axis=1) < MAX_ERROR_M) & (errors_deg < MAX_ERROR_DEG)


def loop_figures(loops, graph, truth, visit_frames):
    """Of the loops that pose_graph accepted: their number, how many disagree with the truth, and the share of the second visit's
    frames (each has its like in the first) that a true loop with the first visit closes."""
    frames, b_from_a = read_hdf5(loops, "frame", "b_from_a")
    (is_accepted,) = read_hdf5(graph, "is_loop_accepted")
    accepted = np.flatnonzero(is_accepted[:, 0])
    frames = frames[accepted]
    is_true = true_pairs(frames, b_from_a[accepted], truth)
    closes = is_true & (frames[:, 0] < visit_frames) & (frames[:, 1] >= visit_frames)
    closing, revisits = np.unique(frames[closes, 1]), np.arange(visit_frames, len(truth))
    after = np.searchsorted(closing, revisits - REVISIT_FRAMES)
    ends = np.r_[closing, np.iinfo(np.int32).max]
    return {"num_accepted": len(frames), "num_false": int(np.sum(~is_true)),
            "closed_percent": 100 * float(np.mean(ends[after] <= revisits + REVISIT_FRAMES))}  # fmt: skip


def query_figures(queries, query_truth, trajectory, truth, first_copy):
    """Queries that were located, their median error (m) against the map around them, and how many are in a wrong place.
    first_copy: which of the true poses are of the copy that the queries were taken in."""
    rows, _, located = read_located(queries)
    true = read_truth(query_truth)
    pairs = associate(located.times_ns, true.times_ns, SAME_NS)
    found, copy = read_tum(trajectory), truth.select(np.flatnonzero(first_copy))
    frames = associate(found.times_ns, copy.times_ns, 0)
    errors_m, _ = local_errors(located.select(pairs[:, 0]), true.select(pairs[:, 1]), found.select(frames[:, 0]), copy.select(frames[:, 1]))
    return {"num_queries": len(rows), "num_located": len(located), "median_m": float(np.median(errors_m)) if len(errors_m) else None,
            "num_wrong": int(np.sum(errors_m > WRONG_CM / 100))}  # fmt: skip
