# SPDX-License-Identifier: Apache-2.0
"""Errors of located queries, each taken twice.

GLOBAL: after one rigid alignment of the whole map trajectory to the reference. What a user of the map
as a whole sees: the bend of the map counts as an error of the query.
LOCAL: after a rigid alignment on the map frames near the query. What localization itself adds to the
map around the query; a robot that compares a picture with its surroundings sees this.

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

    A few neighbours often stand on a line, which leaves positions alone free to turn about it. The
    lever weighs the two kinds of noise: a degree is taken to be as uncertain as two centimetres."""
    centres = trajectory.positions_m[:, None]
    axes = np.transpose(trajectory.rotations(), (0, 2, 1))
    return np.concatenate([centres, centres + LEVER_M * axes], axis=1).reshape(-1, 3)


def near_frames(position_m, map_reference, radius_m=LOCAL_RADIUS_M):
    """Rows of the map frames within the radius of a position, but never fewer than the
    MIN_LOCAL_FRAMES nearest."""
    distances_m = np.linalg.norm(map_reference.positions_m - position_m, axis=1)
    nearest = np.argsort(distances_m, kind="stable")
    count = max(MIN_LOCAL_FRAMES, int(np.count_nonzero(distances_m <= radius_m)))
    return np.sort(nearest[:count])


def local_errors(queries, query_reference, map_frames, map_reference, radius_m=LOCAL_RADIUS_M):
    """Translation (m) and rotation (degrees) error of each query, the map aligned anew for each on the
    frames whose reference lies within the radius of the query's reference: which frames these are does
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


# The two ways by the name they have in metrics.json.
PROTOCOLS = {"global": global_errors, "local": local_errors}
