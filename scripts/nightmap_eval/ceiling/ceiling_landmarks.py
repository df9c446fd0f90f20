# SPDX-License-Identifier: Apache-2.0
"""Errors of the landmarks of a ceiling: where the ray of each one's last sighting truly ends, against where the map has it."""

import numpy as np

from nightmap_eval.ceiling.ceiling_consistency import squared_mahalanobis
from nightmap_eval.ceiling.chi_square import quantile
from nightmap_eval.ceiling.true_ceiling import rays_of, read_camera
from nightmap_eval.trajectory import interpolated
from nightmap_eval.trajectory_errors import statistics

MAX_CAMERA_GAP_NS = 500_000_000  # between the true poses of the camera around a sighting
ELLIPSOID_PROBABILITY = 0.95
# A track compares patches: an edge so near pulls its corner along, most of all in the last sighting before it hides the corner.
PIXEL_OFFSETS = ((0, 0), (5, 0), (-5, 0), (0, 5), (0, -5), (4, 4), (-4, 4), (4, -4), (-4, -4))
EDGE_STEP_M = 0.15


def true_landmarks(ceiling_map, ceiling, camera):
    """(rows of the landmarks whose sighting has a true end, these points (n, 3) in the building, mask of those at an edge).

    At an edge the ray passes a lintel or the frame of a doorway so closely that few pixels decide where it ends."""
    # A time stands once in a trajectory; several landmarks were seen last in one frame.
    times_ns, frame_of = np.unique(ceiling_map.landmark_last_time_ns, return_inverse=True)
    known, poses = interpolated(ceiling.building_from_camera, times_ns, MAX_CAMERA_GAP_NS)
    rows = np.flatnonzero(np.isin(frame_of, known))
    poses = poses.select(np.searchsorted(known, frame_of[rows]))
    pixels = ceiling_map.landmark_last_raw_px[rows]
    rays = (np.einsum("nij,nj->ni", poses.rotations(), rays_of(camera, pixels + offset)) for offset in PIXEL_OFFSETS)
    points_m, *around_m = (ceiling.cast(poses.positions_m, directions) for directions in rays)
    spread_m = np.max([np.linalg.norm(other_m - points_m, axis=1) for other_m in around_m], axis=0)
    has_end = np.isfinite(points_m[:, 0])
    return rows[has_end], points_m[has_end], ~(spread_m[has_end] < EDGE_STEP_M)


def landmark_figures(site, ceiling_map, ceiling, alignments):
    """Errors in the frames of the named alignments (building_from_map), and the share that the map's ellipsoids hold."""
    rows, true_m, is_at_edge = true_landmarks(ceiling_map, ceiling, read_camera(site))
    figures = {"num_judged": len(rows), "num_at_edge": int(is_at_edge.sum()),
               "num_without_true_point": len(ceiling_map.landmark_position_m) - len(rows)}  # fmt: skip
    if len(rows) == 0:
        return figures
    limit = quantile(ELLIPSOID_PROBABILITY, 3)
    for name, building_from_map in alignments.items():
        errors_m = ceiling_map.landmark_position_m[rows] - building_from_map.apply_inverse(true_m)
        distances_m = np.linalg.norm(errors_m, axis=1)
        squared = squared_mahalanobis(errors_m, ceiling_map.landmark_covariance_m2[rows])
        figures[name] = {
            **statistics(distances_m, "error_{}_m", "median", "p90", "max"),
            "error_max_off_edges_m": float(np.max(distances_m[~is_at_edge], initial=0)),
            "height_error_median_m": float(np.median(np.abs(errors_m[:, 2]))),
            "inside_percent": 100 * float(np.mean(squared <= limit)),
        }
    return figures
