# SPDX-License-Identifier: Apache-2.0
"""Where the wheels alone say that the robot is, of frames/odometry.h5."""

import numpy as np

from nightmap_eval.artifacts import read_hdf5, read_sensor_ids
from nightmap_eval.planar_poses import compose, inverse, planar, to_rows, to_trajectory
from nightmap_eval.trajectory import Trajectory, interpolated
from nightmap_site.checked_reading import read_object, using

MAX_GAP_NS = 500_000_000  # between the samples around a frame


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
