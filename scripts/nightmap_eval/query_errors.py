# SPDX-License-Identifier: Apache-2.0
"""Errors of located queries by two protocols.

GLOBAL: after one rigid alignment of the whole map trajectory to the reference. A user of the whole map sees
this error: it includes the distortion of the map.
LOCAL: after a rigid alignment on the map frames near the query. A robot that compares a picture with its
surroundings sees this error: it is the part that localization itself adds to the map around the query.

The reference is the truth, or another map of the same frames. Poses of the queries never take part in
an alignment. Trajectories are target_from_camera; those of an estimate and its reference are matched
row by row.
"""

import numpy as np

from nightmap_eval.metrics import absolute_errors
from nightmap_eval.trajectory import umeyama

LOCAL_RADIUS_M = 2.0
MIN_LOCAL_FRAMES = 3
LEVER_M = 1.0


def global_errors(queries, query_reference, map_frames, map_reference):
    """Translation (m) and rotation (degrees) error of each query in the map aligned as a whole.

    Raises DataError when the map has fewer than 3 frames or never moved."""
    alignment = umeyama(map_frames.positions_m, map_reference.positions_m, with_scale=False)
    return absolute_errors(queries, query_reference, alignment)


def _pose_points_m(trajectory):
    """Each camera's centre and the points LEVER_M along its axes (4n, 3).

    The centres of a few neighbours often lie on a line, about which an alignment of centres alone could turn.
    The lever weighs the two kinds of noise: one degree counts as much as two centimetres."""
    centres = trajectory.positions_m[:, None]
    axes = np.transpose(trajectory.rotations(), (0, 2, 1))
    return np.concatenate([centres, centres + LEVER_M * axes], axis=1).reshape(-1, 3)


def near_frames(position_m, map_reference, radius_m=LOCAL_RADIUS_M):
    """Rows of the map frames within the radius of a position, at least the MIN_LOCAL_FRAMES
    nearest."""
    distances_m = np.linalg.norm(map_reference.positions_m - position_m, axis=1)
    nearest = np.argsort(distances_m, kind="stable")
    count = max(MIN_LOCAL_FRAMES, int(np.count_nonzero(distances_m <= radius_m)))
    return np.sort(nearest[:count])


def local_errors(queries, query_reference, map_frames, map_reference, radius_m=LOCAL_RADIUS_M):
    """Translation (m) and rotation (degrees) error of each query. The map is aligned for each query on the
    frames whose reference lies within the radius of the query's reference, so the choice of frames does
    not depend on the estimate. Raises DataError when the map has no frames."""
    translation_m, rotation_deg = np.zeros(len(queries)), np.zeros(len(queries))
    for i, position_m in enumerate(query_reference.positions_m):
        rows = near_frames(position_m, map_reference, radius_m)
        alignment = umeyama(
            _pose_points_m(map_frames.select(rows)),
            _pose_points_m(map_reference.select(rows)),
            with_scale=False,
        )
        translation_m[i : i + 1], rotation_deg[i : i + 1] = absolute_errors(
            queries.select([i]), query_reference.select([i]), alignment
        )
    return translation_m, rotation_deg


# The two protocols by their names in metrics.json.
PROTOCOLS = {"global": global_errors, "local": local_errors}
