# SPDX-License-Identifier: Apache-2.0
"""Poses of a robot on a floor: x, y (m) and heading (rad) in rows of three."""

import numpy as np

from nightmap_eval.artifacts import read_hdf5, read_sensor_ids
from nightmap_eval.trajectory import Similarity, Trajectory, interpolated
from nightmap_site.checked_reading import read_object, using

MAX_GAP_NS = 500_000_000  # between the samples around a frame


def headings_rad(trajectory):
    """Headings (n,): the direction of each pose's x axis from above."""
    rotations = trajectory.rotations()
    return np.arctan2(rotations[:, 1, 0], rotations[:, 0, 0])


def planar(trajectory):
    """The trajectory without height, roll and pitch."""
    return to_trajectory(trajectory.times_ns, to_rows(trajectory))


def to_rows(trajectory):
    """Rows x, y, heading of the poses of a trajectory."""
    return np.column_stack([trajectory.positions_m[:, :2], headings_rad(trajectory)])


def to_trajectory(times_ns, rows):
    x, y, half_rad = rows[:, 0], rows[:, 1], rows[:, 2] / 2
    zero = np.zeros(len(rows))
    return Trajectory(np.asarray(times_ns, np.int64), np.column_stack([x, y, zero]),
                      np.column_stack([zero, zero, np.sin(half_rad), np.cos(half_rad)]))  # fmt: skip


def compose(first, second):
    """Rows of a_from_b * b_from_c, of rows a_from_b and b_from_c; either may be one row for all."""
    first, second = np.atleast_2d(first), np.atleast_2d(second)
    cos, sin = np.cos(first[:, 2]), np.sin(first[:, 2])
    return np.column_stack([first[:, 0] + cos * second[:, 0] - sin * second[:, 1],
                            first[:, 1] + sin * second[:, 0] + cos * second[:, 1],
                            first[:, 2] + second[:, 2]])  # fmt: skip


def inverse(rows):
    """Rows of b_from_a, of rows a_from_b."""
    rows = np.atleast_2d(rows)
    cos, sin = np.cos(rows[:, 2]), np.sin(rows[:, 2])
    return np.column_stack([-cos * rows[:, 0] - sin * rows[:, 1], sin * rows[:, 0] - cos * rows[:, 1], -rows[:, 2]])


def wrapped_rad(angles_rad):
    """The same directions in [-pi, pi)."""
    return (np.asarray(angles_rad) + np.pi) % (2 * np.pi) - np.pi


def first_pose_alignment(estimate, truth):
    """truth_from_map that puts the first estimated pose on the first true one (both planar, row by row)."""
    x, y, heading = compose(to_rows(truth.select([0])), inverse(to_rows(estimate.select([0]))))[0]
    rotation = np.array([[np.cos(heading), -np.sin(heading), 0], [np.sin(heading), np.cos(heading), 0], [0, 0, 1]])
    return Similarity(1.0, rotation, np.array([x, y, 0]))


def read_wheels(site, times_ns):
    """The robot's trajectory by the sensor that the report of the odometry stage names, the first without a report, at those of the times
    that it has samples around. Its frame drifts. None without a sample."""
    path = site.made("frames", "odometry")
    if path is None:
        return None
    names = ("robot_from_sensor", "sample_offset", "time_ns", "value")
    mountings, offsets, sampled_ns, values = read_hdf5(path, *names)
    if np.size(sampled_ns) == 0:
        return None
    report = site.made("odometry", "report")
    name = read_object(report, {"?odometry_sensor": str}).get("odometry_sensor") if report else None
    with using(path):
        sensor = read_sensor_ids(path).index(name) if name else 0
        part = slice(*np.ravel(offsets)[[sensor, sensor + 1]])
        samples = to_trajectory(np.ravel(sampled_ns)[part], values[part])
        mounting = to_rows(Trajectory(np.zeros(1), mountings[[sensor], :3], mountings[[sensor], 3:]))
    _, at_times = interpolated(samples, times_ns, MAX_GAP_NS)
    if len(at_times) == 0:
        return None
    return to_trajectory(at_times.times_ns, compose(to_rows(planar(at_times)), inverse(mounting)))
