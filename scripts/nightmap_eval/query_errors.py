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

from nightmap_eval.artifacts import read_csv, to_ints
from nightmap_eval.trajectory import MAX_POSITION_M, make_trajectory, umeyama
from nightmap_eval.trajectory_errors import absolute_errors
from nightmap_site.checked_reading import REMEDY
from nightmap_site.script_errors import DataError

# Recall thresholds: translation in centimetres, rotation in degrees.
RECALL_THRESHOLDS = ((1, 1), (2, 2), (3, 3), (5, 5), (10, 5), (25, 10))
# A located query with a larger error counts as in a wrong place.
WRONG_CM = 50
LOCAL_RADIUS_M = 2.0
MIN_LOCAL_FRAMES = 3
LEVER_M = 1.0
QUERY_COLUMNS = ("query_idx", "time_ns", "color_path", "status", "reason")
VERDICTS = ("located", "ambiguous", "not_in_map", "no_features", "unreadable")
POSE_COLUMNS = ("tx_m", "ty_m", "tz_m", "qx", "qy", "qz", "qw")


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
        alignment = umeyama(*(_pose_points_m(frames.select(rows)) for frames in (map_frames, map_reference)), with_scale=False)
        translation_m[i : i + 1], rotation_deg[i : i + 1] = absolute_errors(queries.select([i]), query_reference.select([i]), alignment)
    return translation_m, rotation_deg


# The two protocols by their names in metrics.json.
PROTOCOLS = {"global": global_errors, "local": local_errors}


def recall_percent(translation_m, rotation_deg, num_queries, max_cm, max_deg):
    """Percentage of all queries located within both thresholds. A query without a pose is not in
    the lists, so it counts as a failure."""
    if num_queries == 0:
        return None
    good = (np.asarray(translation_m) * 100 <= max_cm) & (np.asarray(rotation_deg) <= max_deg)
    return 100.0 * int(np.count_nonzero(good)) / num_queries


# p90: the smallest value that 90 % of the values do not exceed.
STATISTICS = {"median": np.median, "p90": lambda values: np.sort(values)[int(np.ceil(0.9 * len(values))) - 1]}


def _with_failures(statistic, values, num_queries):
    """The statistic over all queries, where a failure has infinite error; None when the result is infinite."""
    failures = np.full(num_queries - len(values), np.inf)
    padded = np.concatenate([np.asarray(values, dtype=float), failures])
    value = float(statistic(padded)) if num_queries else np.inf
    return value if np.isfinite(value) else None


def query_summary(translation_m, rotation_deg, num_queries):
    """Figures of the located queries among num_queries queries with truth."""
    translation_cm = 100 * np.asarray(translation_m)
    figures = {
        "num_with_truth": num_queries,
        "num_located_with_truth": len(translation_m),
        "num_wrong": int(np.count_nonzero(translation_cm > WRONG_CM)),
    }
    for name, statistic in STATISTICS.items():
        for unit, values in (("translation_error_cm", translation_cm), ("rotation_error_deg", rotation_deg)):
            figures[f"{name}_{unit}"] = _with_failures(statistic, values, num_queries)
    if len(translation_m):
        figures["located_median_translation_error_cm"] = float(np.median(translation_cm))
        figures["located_median_rotation_error_deg"] = float(np.median(rotation_deg))
        figures["located_max_translation_error_cm"] = float(np.max(translation_cm))
    for max_cm, max_deg in RECALL_THRESHOLDS:
        figures[f"recall_{max_cm}cm_{max_deg}deg_percent"] = recall_percent(
            translation_m, rotation_deg, num_queries, max_cm, max_deg
        )
    return figures


def refuse_mapped_queries(names, map_names):
    """Raises DataError when a picture is both a query and a mapping frame: COLMAP identifies pictures by name,
    so it would take the query for an image of its map."""
    both = sorted(set(names) & set(map_names))
    if both:
        raise DataError(
            f"{both[0]}: this query is also a mapping frame ({len(both)} such queries); the comparison with "
            "COLMAP needs queries that were not mapped: hold them out or leave them out of the site's queries"
        )


def read_located(path):
    """Rows of localize/queries.csv, and the located ones as a trajectory (map_from_camera)."""
    rows = read_csv(path, QUERY_COLUMNS + POSE_COLUMNS)
    times_ns, poses = to_ints(rows, "time_ns", path), []
    to_ints(rows, "query_idx", path)
    for row, time_ns in zip(rows, times_ns):
        if row["status"] not in VERDICTS:
            raise DataError(f"{path}: query {row['query_idx']}: unknown status {row['status']}; {REMEDY}")
        if row["status"] == "located":
            try:
                values = [float(row[name]) for name in POSE_COLUMNS]
            except ValueError as error:
                raise DataError(f"{path}: query {row['query_idx']}: {error}; {REMEDY}") from None
            if not all(abs(value) <= MAX_POSITION_M for value in values):  # also rejects NaN
                raise DataError(f"{path}: query {row['query_idx']}: a pose out of range; {REMEDY}")
            poses.append((int(time_ns), values[:3], values[3:]))
    return rows, times_ns, make_trajectory(poses, path)
