# SPDX-License-Identifier: Apache-2.0
"""Scores the map of a composed site against its exact truth, in arrays: trajectory and loops."""

import numpy as np

import checkout  # noqa: F401  first: it makes the packages of scripts/ importable
from nightmap_eval.artifacts import read_hdf5
from nightmap_eval.loop_accuracy import MAX_ERROR_M, REVISIT_DEG, REVISIT_FRAMES, REVISIT_M
from nightmap_eval.query_errors import WRONG_CM, local_errors, read_located
from nightmap_eval.trajectory import Trajectory, angles_deg, associate, quaternion, read_truth, read_tum, rotation_matrices
from nightmap_eval.trajectory_errors import ate, distance_pairs, relative_errors

from night.source import matrices

RPE_M = 10.0
MAX_ERROR_DEG = 5.0  # of a true loop
SAME_NS = 1_000_000  # stamps of one query in two files


def motion_errors(estimate, true, visits):
    """RMSE of the motion over 10 m of one visit: metres and degrees."""
    steps, _ = distance_pairs(true, visits, RPE_M)
    return tuple(float(np.sqrt(np.mean(errors**2))) for errors in relative_errors(estimate, true, steps))


def trajectory_figures(path, truth, visit_frames):
    """Errors of a trajectory in the TUM format: ATE after an alignment in SE(3), motion, and how many frames have no pose."""
    found = read_tum(path)
    pairs = associate(found.times_ns, truth.times_ns, 0)
    estimate, true = found.select(pairs[:, 0]), truth.select(pairs[:, 1])
    figures, _ = ate(estimate, true, False)
    rpe_m, rpe_deg = motion_errors(estimate, true, pairs[:, 1] // visit_frames)
    return {"num_without": len(truth) - len(pairs), "ate_m": figures["ate_rmse_m"], "rpe_m": rpe_m, "rpe_deg": rpe_deg}


def chained_odometry(paths):
    """The way of shards in order, by odometry alone; times count up."""
    poses = []
    for path in paths:
        frames, local, edge_frames, edges = read_hdf5(path, "frame_idx", "shard_from_camera", "edge_frame", "edge_b_from_a")
        local, b_from_a, start = matrices_of(local), matrices_of(edges[:1])[0], np.eye(4)
        if poses:  # the first edge leads from the last frame before to one of this shard
            start = poses[-1][-1] @ np.linalg.inv(local[edge_frames[0, 1] - frames[0, 0]] @ b_from_a)
        poses.append(start @ local)
    poses = np.concatenate(poses)
    return Trajectory(np.arange(len(poses)), poses[:, :3, 3], np.array([quaternion(pose[:3, :3]) for pose in poses]))


def odometry_errors(paths, truth):
    """Motion errors of the first visit, whose shards these are, by odometry alone."""
    estimate = chained_odometry(paths)
    true = truth.select(np.arange(len(estimate)))
    return motion_errors(Trajectory(true.times_ns, estimate.positions_m, estimate.quaternions), true, np.zeros(len(true)))


def matrices_of(poses):
    return matrices(Trajectory(np.arange(len(poses)), poses[:, :3], poses[:, 3:]))


def relative_poses(trajectory, source, target):
    """True rotations and translations of target_from_source between these frames."""
    rotations = trajectory.rotations()
    back = np.transpose(rotations[target], (0, 2, 1))
    return back @ rotations[source], np.einsum("nij,nj->ni", back, trajectory.positions_m[source] - trajectory.positions_m[target])


def pair_errors(frames, b_from_a, truth):
    """Errors (m, degrees) of the measured relative poses of pairs of frames."""
    rotations, steps_m = relative_poses(truth, *frames.T)
    errors_deg = angles_deg(rotation_matrices(b_from_a[:, 3:]) @ np.transpose(rotations, (0, 2, 1)))
    return np.linalg.norm(b_from_a[:, :3] - steps_m, axis=1), errors_deg


def true_pairs(frames, b_from_a, truth):
    errors_m, errors_deg = pair_errors(frames, b_from_a, truth)
    return (errors_m < MAX_ERROR_M) & (errors_deg < MAX_ERROR_DEG)


def loop_figures(loops, graph, truth, visit_frames):
    """Loops that pose_graph accepted: their number, how many disagree with the truth, and the share of the second visit's
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


def shown(true, copy):
    """Rows of the true poses whose view some frame of the copy had, by the measure of a revisit."""
    rows, rotations = [], copy.rotations()
    for row, (position_m, rotation) in enumerate(zip(true.positions_m, true.rotations(), strict=True)):
        near = np.linalg.norm(copy.positions_m - position_m, axis=1) < REVISIT_M
        if np.any(angles_deg(np.transpose(rotations[near], (0, 2, 1)) @ rotation) < REVISIT_DEG):
            rows.append(row)
    return rows


def query_figures(queries, query_truth, trajectory, truth, first_copy):
    """Queries whose view the first copy shows: their number, how many were located, the median error (m) of these against
    the map around them, and how many are in a wrong place. first_copy: which of the true poses are of that copy. (A query of
    another place may show a room that is furnished like one of the copy, where it is no error of the map.)"""
    _, _, located = read_located(queries)
    copy = truth.select(np.flatnonzero(first_copy))
    true = read_truth(query_truth)
    true = true.select(shown(true, copy))
    pairs = associate(located.times_ns, true.times_ns, SAME_NS)
    found = read_tum(trajectory)
    frames = associate(found.times_ns, copy.times_ns, 0)
    errors_m, _ = local_errors(located.select(pairs[:, 0]), true.select(pairs[:, 1]), found.select(frames[:, 0]), copy.select(frames[:, 1]))
    return {"num_queries": len(true), "num_located": len(errors_m), "median_m": float(np.median(errors_m)) if len(errors_m) else np.nan,
            "num_wrong": int(np.sum(errors_m > WRONG_CM / 100))}  # fmt: skip
