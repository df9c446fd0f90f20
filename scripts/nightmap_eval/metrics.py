# SPDX-License-Identifier: Apache-2.0
"""Accuracy of a trajectory and of located queries against the truth.

ATE and RPE as defined by Sturm et al., A Benchmark for the Evaluation of RGB-D SLAM Systems
(IROS 2012). Every figure has its unit as suffix.
"""

import numpy as np

from nightmap_eval.trajectory import angles_deg, path_length_m, quaternion, umeyama

# Recall thresholds: translation in centimetres, rotation in degrees.
RECALL_THRESHOLDS = ((1, 1), (2, 2), (3, 3), (5, 5), (10, 5), (25, 10))
# A located query with a larger error counts as in a wrong place.
WRONG_CM = 50


def _rmse(values):
    return float(np.sqrt(np.mean(np.square(values))))


def absolute_errors(estimate, truth, alignment):
    """Translation (m) and rotation (degrees) error of each pose after the alignment."""
    offsets_m = alignment.apply(estimate.positions_m) - truth.positions_m
    translation_m = np.linalg.norm(offsets_m, axis=1)
    aligned = alignment.rotation @ estimate.rotations()
    rotation_deg = angles_deg(np.transpose(truth.rotations(), (0, 2, 1)) @ aligned)
    return translation_m, rotation_deg


def ate(estimate, truth, with_scale):
    """Absolute trajectory error of matched poses, and the alignment used (truth_from_map)."""
    alignment = umeyama(estimate.positions_m, truth.positions_m, with_scale)
    translation_m, rotation_deg = absolute_errors(estimate, truth, alignment)
    figures = {
        "ate_rmse_m": _rmse(translation_m),
        "ate_mean_m": float(np.mean(translation_m)),
        "ate_median_m": float(np.median(translation_m)),
        "ate_max_m": float(np.max(translation_m)),
        "rotation_rmse_deg": _rmse(rotation_deg),
        "rotation_median_deg": float(np.median(rotation_deg)),
        "rotation_max_deg": float(np.max(rotation_deg)),
    }
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
    steps = np.linalg.norm(np.diff(truth.positions_m, axis=0), axis=1)
    travelled = np.concatenate([[0.0], np.cumsum(steps)])
    later = np.searchsorted(travelled, travelled + distance_m - 1e-9)
    first = np.flatnonzero(later < len(travelled))
    pairs = np.stack([first, later[first]], axis=1)
    pairs = pairs[sequence_idxs[pairs[:, 0]] == sequence_idxs[pairs[:, 1]]]
    return pairs, travelled[pairs[:, 1]] - travelled[pairs[:, 0]]


def _summary(translation, rotation, suffix):
    if len(translation) == 0:
        return {"num_pairs": 0}
    return {
        "num_pairs": len(translation),
        f"translation_rmse_m{suffix}": _rmse(translation),
        f"translation_median_m{suffix}": float(np.median(translation)),
        f"rotation_rmse_deg{suffix}": _rmse(rotation),
        f"rotation_median_deg{suffix}": float(np.median(rotation)),
    }


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


def recall_percent(translation_m, rotation_deg, num_queries, max_cm, max_deg):
    """Percentage of all queries located within both thresholds. A query without a pose is not in
    the lists, so it counts as a failure."""
    if num_queries == 0:
        return None
    good = (np.asarray(translation_m) * 100 <= max_cm) & (np.asarray(rotation_deg) <= max_deg)
    return 100.0 * int(np.count_nonzero(good)) / num_queries


def _median(values):
    return float(np.median(values))


def _p90(values):
    """The smallest value that 90 % of the values do not exceed."""
    return float(np.sort(values)[int(np.ceil(0.9 * len(values))) - 1])


def _with_failures(statistic, values, num_queries):
    """The statistic over all queries, where a failure has infinite error; None when the result is infinite."""
    failures = np.full(num_queries - len(values), np.inf)
    padded = np.concatenate([np.asarray(values, dtype=float), failures])
    value = statistic(padded) if num_queries else np.inf
    return value if np.isfinite(value) else None


def query_summary(translation_m, rotation_deg, num_queries):
    """Figures of the located queries among num_queries queries with truth."""
    translation_cm = 100 * np.asarray(translation_m)
    figures = {
        "num_with_truth": num_queries,
        "num_located_with_truth": len(translation_m),
        "num_wrong": int(np.count_nonzero(translation_cm > WRONG_CM)),
    }
    for name, statistic in (("median", _median), ("p90", _p90)):
        for unit, values in (("translation_error_cm", translation_cm), ("rotation_error_deg", rotation_deg)):
            figures[f"{name}_{unit}"] = _with_failures(statistic, values, num_queries)
    if len(translation_m):
        figures["located_median_translation_error_cm"] = _median(translation_cm)
        figures["located_median_rotation_error_deg"] = _median(rotation_deg)
        figures["located_max_translation_error_cm"] = float(np.max(translation_cm))
    for max_cm, max_deg in RECALL_THRESHOLDS:
        figures[f"recall_{max_cm}cm_{max_deg}deg_percent"] = recall_percent(
            translation_m, rotation_deg, num_queries, max_cm, max_deg
        )
    return figures
