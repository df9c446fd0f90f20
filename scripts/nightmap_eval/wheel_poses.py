# SPDX-License-Identifier: Apache-2.0
"""Where the wheels alone say that the robot is, of frames/odometry.h5."""

import numpy as np

from nightmap_eval.artifacts import read_hdf5
from nightmap_eval.planar_poses import compose, inverse, planar, to_rows, to_trajectory
from nightmap_eval.trajectory import Trajectory, interpolated
from nightmap_site.checked_reading import using

MAX_GAP_NS = 500_000_000  # between the samples around a frame


def read_wheels(site, times_ns):
    """The robot's trajectory by the first odometry sensor, at those of the times that it has samples around. Its frame drifts.

    None without a sample."""
    path = site.made("frames", "odometry")
    if path is None:
        return None
    names = ("robot_from_sensor", "sample_offset", "time_ns", "value")
    mountings, offsets, sampled_ns, values = read_hdf5(path, *names)
    if np.size(sampled_ns) == 0:
        return None
    with using(path):
        end = int(np.ravel(offsets)[1])
        samples = to_trajectory(np.ravel(sampled_ns)[:end], values[:end])
        mounting = to_rows(Trajectory(np.zeros(1), mountings[:1, :3], mountings[:1, 3:]))
    _, at_times = interpolated(samples, times_ns, MAX_GAP_NS)
    if len(at_times) == 0:
        return None
    return to_trajectory(at_times.times_ns, compose(to_rows(planar(at_times)), inverse(mounting)))
