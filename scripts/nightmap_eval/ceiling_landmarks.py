# SPDX-License-Identifier: Apache-2.0
"""Errors of the landmarks of a ceiling: where the ray of each one's last sighting truly ends, against where the map has it."""

import numpy as np

from nightmap_eval.ceiling_consistency import squared_mahalanobis
from nightmap_eval.chi_square import quantile
from nightmap_eval.trajectory import interpolated
from nightmap_eval.true_ceiling import rays_of, read_camera

MAX_CAMERA_GAP_NS = 500_000_000  # between the true poses of the camera around a sighting
ELLIPSOID_PROBABILITY = 0.95


def true_landmarks(ceiling_map, ceiling, camera):
    """(rows of the landmarks whose sighting has a true end, these points (n, 3) in the building)."""
    # A time stands once in a trajectory; several landmarks were seen last in one frame.
    times_ns, frame_of = np.unique(ceiling_map.landmark_last_time_ns, return_inverse=True)
    known, poses = interpolated(ceiling.building_from_camera, times_ns, MAX_CAMERA_GAP_NS)
    row_of_frame = np.full(len(times_ns), -1)
    row_of_frame[known] = np.arange(len(known))
    rows = np.flatnonzero(row_of_frame[frame_of] >= 0) if len(times_ns) else np.zeros(0, int)
    poses = poses.select(row_of_frame[frame_of[rows]])
    rays = rays_of(camera, ceiling_map.landmark_last_raw_px[rows])
    points_m = ceiling.cast(poses.positions_m, np.einsum("nij,nj->ni", poses.rotations(), rays))
    has_end = np.isfinite(points_m[:, 0])
    return rows[has_end], points_m[has_end]


def landmark_figures(site, ceiling_map, ceiling, alignments):
    """Errors in the frames of the named alignments (building_from_map), and the share that the map's ellipsoids hold."""
    rows, true_m = true_landmarks(ceiling_map, ceiling, read_camera(site))
    figures = {"num_judged": len(rows), "num_without_true_point": len(ceiling_map.landmark_position_m) - len(rows)}
    if len(rows) == 0:
        return figures
    limit = quantile(ELLIPSOID_PROBABILITY, 3)
    for name, building_from_map in alignments.items():
        errors_m = ceiling_map.landmark_position_m[rows] - inverse_apply(building_from_map, true_m)
        distances_m = np.linalg.norm(errors_m, axis=1)
        squared = squared_mahalanobis(errors_m, ceiling_map.landmark_covariance_m2[rows])
        figures[name] = {
            "error_median_m": float(np.median(distances_m)),
            "error_p90_m": float(np.percentile(distances_m, 90)),
            "error_max_m": float(np.max(distances_m)),
            "height_error_median_m": float(np.median(np.abs(errors_m[:, 2]))),
            "inside_percent": 100 * float(np.mean(squared <= limit)),
        }
    return figures


def inverse_apply(alignment, points_m):
    """Points of the target frame in the source frame of an alignment."""
    return (np.asarray(points_m) - alignment.translation_m) @ alignment.rotation / alignment.scale
