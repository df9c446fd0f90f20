# SPDX-License-Identifier: Apache-2.0
"""Errors of a trajectory against the truth.

ATE and RPE as defined by Sturm et al., A Benchmark for the Evaluation of RGB-D SLAM Systems
(IROS 2012). Every figure has its unit as suffix.
"""

import numpy as np

from nightmap_eval.trajectory import angles_deg, associate, path_length_m, planar_umeyama, quaternion, travelled_m, umeyama
from nightmap_site.script_errors import DataError

STATISTICS = {"rmse": lambda values: np.sqrt(np.mean(np.square(values))), "mean": np.mean, "median": np.median,
              "p90": lambda values: np.percentile(values, 90), "max": np.max}  # fmt: skip
MAX_TRUTH_GAP_NS = 500_000_000  # between the true poses around a moment
SAME_NS = 1_000_000  # stamps of one moment in two files
TRUTH_REMEDY = "correct [robot_truth] of the site config, from which it is made, and run make again"


def statistics(values, name, *kinds):
    """Figures of these kinds; name: of a figure, with {} for the kind."""
    return {name.format(kind): float(STATISTICS[kind](values)) for kind in kinds}


def absolute_errors(estimate, truth, alignment):
    """Translation (m) and rotation (degrees) error of each pose after the alignment."""
    offsets_m = alignment.apply(estimate.positions_m) - truth.positions_m
    translation_m = np.linalg.norm(offsets_m, axis=1)
    aligned = alignment.rotation @ estimate.rotations()
    rotation_deg = angles_deg(np.transpose(truth.rotations(), (0, 2, 1)) @ aligned)
    return translation_m, rotation_deg


def coverage(frames, estimate, num_unusable, guessed=(), more=None):
    """Counts of the recording's frames with and without a pose. guessed: frames whose pose does not count; more: further figures."""
    located = set(estimate.times_ns.tolist())
    missing = [int(i) for i, time_ns in zip(frames.frame_idxs, frames.times_ns) if int(time_ns) not in located]
    num_without = len({*missing, *guessed})
    return {"num_frames": len(frames) + num_unusable,
            "num_frames_with_pose": len(frames) - num_without,
            "num_frames_without_pose": num_without + num_unusable,
            "num_frames_unusable": num_unusable,
            "frames_without_pose": missing,
            **(more or {}),
            "path_length_m": path_length_m(estimate.positions_m)}  # fmt: skip


def absolute_figures(estimate, truth, alignment):
    """Figures of the absolute errors after an alignment (truth_from_map)."""
    translation_m, rotation_deg = absolute_errors(estimate, truth, alignment)
    return {**statistics(translation_m, "ate_{}_m", "rmse", "mean", "median", "max"),
            **statistics(rotation_deg, "rotation_{}_deg", "rmse", "median", "max")}  # fmt: skip


def ate(estimate, truth, with_scale, align=umeyama):
    """Absolute trajectory error of matched poses, and the alignment used (truth_from_map)."""
    alignment = align(estimate.positions_m, truth.positions_m, with_scale)
    figures = absolute_figures(estimate, truth, alignment)
    if with_scale:
        figures["scale"] = alignment.scale
    return figures, alignment


def relative_errors(estimate, truth, pairs):
    """Error of the motion from pose i to pose j: translation (m) and rotation (degrees)."""
    i, j = np.asarray(pairs, dtype=int).reshape(-1, 2).T

    def motions(trajectory):
        rotations = trajectory.rotations()
        inverse = np.transpose(rotations[i], (0, 2, 1))
        steps = trajectory.positions_m[j] - trajectory.positions_m[i]
        return inverse @ rotations[j], np.einsum("nij,nj->ni", inverse, steps)

    estimate_rotations, estimate_steps = motions(estimate)
    truth_rotations, truth_steps = motions(truth)
    back = np.transpose(truth_rotations, (0, 2, 1))
    translation_m = np.linalg.norm(estimate_steps - truth_steps, axis=1)
    return translation_m, angles_deg(back @ estimate_rotations)


def frame_pairs(frame_idxs, sequence_idxs):
    """Pairs of neighbours in the list whose frames follow each other in one sequence."""
    follows = (np.diff(frame_idxs) == 1) & (np.diff(sequence_idxs) == 0)
    first = np.flatnonzero(follows)
    return np.stack([first, first + 1], axis=1)


def distance_pairs(truth, sequence_idxs, distance_m):
    """Pairs each pose with the first later one of its sequence at least distance_m of path ahead.

    Returns the pairs and the path length between them."""
    travelled = travelled_m(truth.positions_m)
    later = np.searchsorted(travelled, travelled + distance_m - 1e-9)
    first = np.flatnonzero(later < len(travelled))
    pairs = np.stack([first, later[first]], axis=1)
    pairs = pairs[sequence_idxs[pairs[:, 0]] == sequence_idxs[pairs[:, 1]]]
    return pairs, travelled[pairs[:, 1]] - travelled[pairs[:, 0]]


def _summary(translation, rotation, suffix):
    if len(translation) == 0:
        return {"num_pairs": 0}
    return {"num_pairs": len(translation), **statistics(translation, f"translation_{{}}_m{suffix}", "rmse", "median"),
            **statistics(rotation, f"rotation_{{}}_deg{suffix}", "rmse", "median")}  # fmt: skip


def rpe_per_frame(estimate, truth, frame_idxs, sequence_idxs):
    pairs = frame_pairs(frame_idxs, sequence_idxs)
    return _summary(*relative_errors(estimate, truth, pairs), "")


def rpe_per_metre(estimate, truth, sequence_idxs):
    """Relative error over about one metre of path, divided by the path's length."""
    pairs, lengths_m = distance_pairs(truth, sequence_idxs, 1.0)
    translation_m, rotation_deg = relative_errors(estimate, truth, pairs)
    return _summary(translation_m / lengths_m, rotation_deg / lengths_m, "_per_m")


def trajectory_metrics(estimate, truth, frame_idxs, sequence_idxs):
    """All figures of matched poses (estimate[i] belongs to truth[i]), and the SE(3) alignment."""
    se3, alignment = ate(estimate, truth, with_scale=False)
    sim3, _ = ate(estimate, truth, with_scale=True)
    figures = {
        "num_pairs": len(estimate),
        "truth_path_length_m": path_length_m(truth.positions_m),
        "alignment_is_unique": alignment.is_unique,
        "truth_from_map_m_q": [*alignment.translation_m, *quaternion(alignment.rotation)],
        "se3": se3,
        "sim3": sim3,
        "rpe_per_frame": rpe_per_frame(estimate, truth, frame_idxs, sequence_idxs),
        "rpe_per_metre": rpe_per_metre(estimate, truth, sequence_idxs),
    }
    return figures, alignment


def robot_figures(estimate, truth, num_moments, moments):
    """A robot's planar way against its true one, which frames wrote as [robot_truth] of the site config says:
    (figures, rows of truth and of the estimate that are one moment, {"se3", "sim3": truth_from_map}). moments: what the
    poses are of, "scans" or "frames"; num_moments: all of them, with or without a true pose. A moment with a true pose and no
    estimate has no error; it is counted as missing."""
    pairs = associate(truth.times_ns, estimate.times_ns, SAME_NS)
    if len(pairs) < 3:
        raise DataError(f"{len(pairs)} {moments} have an estimated and a true pose, of {num_moments} {moments} and {len(truth)} with a "
                        "true one; check [robot_truth] and the clocks of the site config")  # fmt: skip
    matched, matched_truth = estimate.select(pairs[:, 1]), truth.select(pairs[:, 0])
    se3, alignment = ate(matched, matched_truth, False, planar_umeyama)
    sim3, scaling = ate(matched, matched_truth, True, planar_umeyama)
    num_missing = len(truth) - len(pairs)
    figures = {
        f"num_{moments}_with_truth": len(truth),
        "num_missing": num_missing,
        "missing_percent": 100 * num_missing / len(truth),
        "truth_path_length_m": path_length_m(truth.positions_m),
        "alignment_is_unique": alignment.is_unique,
        "truth_from_map_m_q": [*alignment.translation_m, *quaternion(alignment.rotation)],
        "se3": se3,
        "sim3": sim3,
    }
    return figures, pairs, {"se3": alignment, "sim3": scaling}
