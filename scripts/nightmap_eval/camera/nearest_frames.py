# SPDX-License-Identifier: Apache-2.0
"""Frames of the map that look from where a picture was located: whoever sees both side by side sees whether it is right."""

import numpy as np

from nightmap_eval.artifacts import Frames
from nightmap_eval.located_queries import read_located
from nightmap_eval.trajectory import read_tum, rotation_matrices

DEG_PER_M = 30  # a view that is turned by this shows about as much else as one from a metre away


class NearestFrames:
    def __init__(self, site):
        keyframes, frames = read_tum(site.path("map_frame", "keyframes")), Frames(site)
        path_at = {time_ns: row["color_path"] for time_ns, row in zip(frames.times_ns, frames.rows)}
        self.keyframes = keyframes.select([i for i, time_ns in enumerate(keyframes.times_ns) if int(time_ns) in path_at])
        self.color_paths = [path_at[int(time_ns)] for time_ns in self.keyframes.times_ns]
        self.views = self.keyframes.rotations()[:, :, 2]

    def near(self, position_m, quaternion, count):
        """color_path of the `count` keyframes whose place and direction of view are the nearest."""
        distances_m = np.linalg.norm(self.keyframes.positions_m - position_m, axis=1)
        cosines = self.views @ rotation_matrices(quaternion[None])[0][:, 2]
        apart = distances_m + np.degrees(np.arccos(np.clip(cosines, -1, 1))) / DEG_PER_M
        return [self.color_paths[i] for i in np.argsort(apart, kind="stable")[:count]]


def nearest_frames(site, count):
    """query_idx -> color_path of the nearest keyframes, of the located pictures; empty without a map."""
    path = site.made("localize", "queries")
    if not path or not site.made("map_frame", "keyframes"):
        return {}
    frames = NearestFrames(site)
    rows, times_ns, located = read_located(path)
    poses = {int(time_ns): i for i, time_ns in enumerate(located.times_ns)}
    found = {}
    for row, time_ns in zip(rows, times_ns):
        pose = poses.get(int(time_ns))
        if pose is not None:
            found[int(row["query_idx"])] = frames.near(located.positions_m[pose], located.quaternions[pose], count)
    return found
