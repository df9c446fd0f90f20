# SPDX-License-Identifier: Apache-2.0
"""A robot's planar way against its true one, which frames wrote as [robot_truth] of the site config says."""

from nightmap_eval.trajectory import associate, path_length_m, planar_umeyama, quaternion
from nightmap_eval.trajectory_errors import ate
from nightmap_site.script_errors import DataError

MAX_TRUTH_GAP_NS = 500_000_000  # between the true poses around a moment
SAME_NS = 1_000_000  # stamps of one moment in two files
TRUTH_REMEDY = "correct [robot_truth] of the site config, from which it is made, and run make again"


def robot_figures(estimate, truth, num_moments, moments):
    """(figures, rows of truth and of the estimate that are one moment, {"se3", "sim3": truth_from_map}). moments: what the
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
