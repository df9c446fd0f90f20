# SPDX-License-Identifier: Apache-2.0
"""Whether a filter's covariances are honest: NEES of its poses and NIS of its innovations against their 95 % bounds.

Both are chi-square distributed where the filter's model holds (Bar-Shalom, Li, Kirubarajan, Estimation with Applications to
Tracking and Navigation, 5.4). Values above the bounds come from covariances that are too small.
"""

from dataclasses import dataclass

import numpy as np
from scipy.special import chdtri

from nightmap_eval.planar_poses import compose, inverse, to_rows, wrapped_rad
from nightmap_eval.trajectory import associate, travelled_m
from nightmap_eval.trajectory_errors import SAME_NS

POSE_DEGREES = 3
LEAST_SIGMA = 5e-5  # m or rad: the start is exact by definition, and the filter holds it within 1e-5


@dataclass
class FrameErrors:
    """Errors of what the filter said at each frame. The first frame with a true pose has none: it holds the truth's frame."""

    times_ns: np.ndarray  # (n,)
    travelled_m: np.ndarray  # (n,) way by the truth
    errors: np.ndarray  # (n, 3) x, y (m), heading (rad) in the map
    covariances: np.ndarray  # (n, 3, 3) that the filter stated

    def nees(self):
        """(mask of the frames with an uncertainty, their normalized estimation errors squared)."""
        is_judged = np.linalg.eigvalsh(self.covariances)[:, 0] > LEAST_SIGMA**2
        return is_judged, squared_mahalanobis(self.errors[is_judged], self.covariances[is_judged])


def squared_mahalanobis(errors, covariances):
    """e^T C^-1 e of each row."""
    if len(errors) == 0:
        return np.zeros(0)
    return np.einsum("ni,ni->n", errors, np.linalg.solve(covariances, errors[..., None])[..., 0])


def errors_then(ceiling_map, truth):
    """FrameErrors of the frames with a true pose; truth is planar."""
    pairs = associate(truth.times_ns, ceiling_map.frame_time_ns, SAME_NS)
    said, true = ceiling_map.frame_pose[pairs[:, 1]], to_rows(truth.select(pairs[:, 0]))
    map_from_truth = compose(said[:1], inverse(true[:1]))
    errors = said - compose(map_from_truth, true)
    errors[:, 2] = wrapped_rad(errors[:, 2])
    return FrameErrors(truth.times_ns[pairs[:, 0]], travelled_m(true[:, :2]), errors, ceiling_map.frame_covariance[pairs[:, 1]])


def nees_figures(frame_errors):
    _, nees = frame_errors.nees()
    figures = {"num_frames": len(nees)}
    if len(nees):
        figures |= {"mean": float(np.mean(nees))} | shares(nees, np.full(len(nees), POSE_DEGREES))
    return figures


def nis_figures(ceiling_map):
    """Frames without a residual are not judged."""
    is_judged = ceiling_map.frame_num_residuals > 0
    nis, degrees = ceiling_map.frame_nis[is_judged], ceiling_map.frame_num_residuals[is_judged]
    figures = {"num_frames": len(nis)}
    if len(nis):
        figures |= {"mean_per_degree_of_freedom": float(nis.sum() / degrees.sum())} | shares(nis, degrees)
    return figures


def quantile(probability, degrees):
    """The value that a chi-square variable stays below with this probability."""
    return chdtri(degrees, 1 - probability)


def bounds(degrees):
    """(lower, upper) ends of the interval that holds 95 % of the values, as many below as above; arrays for an array."""
    return quantile(0.025, degrees), quantile(0.975, degrees)


def shares(values, degrees):
    """Share of the values within their 95 % bounds, below them and above them (%)."""
    lower, upper = bounds(degrees)
    below, above = np.mean(values < lower), np.mean(values > upper)
    return {"within_percent": 100 * float(1 - below - above), "below_percent": 100 * float(below),
            "above_percent": 100 * float(above)}  # fmt: skip
