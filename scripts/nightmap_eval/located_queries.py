# SPDX-License-Identifier: Apache-2.0
"""Reads the results of the localize stage: every query, and the poses of the located ones."""

from nightmap_eval.artifacts import read_csv, to_ints
from nightmap_eval.trajectory import MAX_POSITION_M, make_trajectory
from nightmap_site.checked_reading import REMEDY
from nightmap_site.script_errors import DataError

QUERY_COLUMNS = ("query_idx", "time_ns", "color_path", "status", "reason")
VERDICTS = ("located", "ambiguous", "not_in_map", "no_features", "unreadable")
POSE_COLUMNS = ("tx_m", "ty_m", "tz_m", "qx", "qy", "qz", "qw")


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
