# SPDX-License-Identifier: Apache-2.0
"""Ranges of beams in a plane: to columns, and in a tunnel between two places. Metres and radians; inf where a beam hits nothing. Pure."""

import numpy as np
from nightmap_eval.planar_poses import wrapped_rad

HALF_WIDTH_M = 1.2  # of a tunnel
PILLAR_M = 0.15  # radius of the pillars at its walls
PILLARS_APART_M = (0.8, 2.5)
FINE_M, GAP_M = 0.01, 0.3  # points behind a gate: their distance when filled up, and up to which two lie on one wall


def to_columns(poses, angles_rad, columns):
    """(poses, angles): the nearest of the columns (x, y, radius) on each beam."""
    headings_rad = poses[:, 2:] + angles_rad
    x, y = np.cos(headings_rad), np.sin(headings_rad)
    nearest_m = np.full(x.shape, np.inf)
    for column in columns:
        apart = column[:2] - poses[:, :2]
        along_m = x * apart[:, :1] + y * apart[:, 1:]
        inside_m2 = column[2] ** 2 - (y * apart[:, :1] - x * apart[:, 1:]) ** 2
        range_m = along_m - np.sqrt(np.maximum(inside_m2, 0))
        nearest_m = np.where((inside_m2 > 0) & (range_m > 0), np.minimum(nearest_m, range_m), nearest_m)
    return nearest_m


def filled_up(points_m):
    """Points in order of the beams, with those in between where two lie on one wall."""
    apart_m = np.linalg.norm(np.diff(points_m, axis=0), axis=1)
    shares = np.arange(0, 1, FINE_M / GAP_M)[:, None, None]
    between = points_m[:-1] + shares * np.diff(points_m, axis=0)
    return np.concatenate([between[:, apart_m < GAP_M].reshape(-1, 2), points_m])


class Tunnel:
    """Straight from the pose `begin` to `end`, between two walls. Before it lie the points that `behind` saw, after it those `ahead`."""

    def __init__(self, begin, end, behind_m, ahead_m, seed):
        way_m = end[:2] - begin[:2]
        self.begin_m, self.length_m, self.heading_rad = begin[:2], np.linalg.norm(way_m), np.arctan2(way_m[1], way_m[0])
        along_m = np.cumsum(np.random.default_rng([seed, 3]).uniform(*PILLARS_APART_M, round(self.length_m / PILLARS_APART_M[0])))
        along_m = along_m[along_m < self.length_m - PILLAR_M]
        sides_m = HALF_WIDTH_M * (-1) ** np.arange(len(along_m))
        self.pillars = np.column_stack([along_m, sides_m, np.full(len(along_m), PILLAR_M)])
        behind_m, ahead_m = (filled_up(self.in_tunnel(points_m)) for points_m in (behind_m, ahead_m))
        self.behind_m, self.ahead_m = behind_m[behind_m[:, 0] < 0], ahead_m[ahead_m[:, 0] > self.length_m]

    def in_tunnel(self, points_m):
        cos, sin = np.cos(self.heading_rad), np.sin(self.heading_rad)
        return (points_m - self.begin_m) @ np.array([[cos, -sin], [sin, cos]])

    def ranges_m(self, poses, angles_rad):
        """(poses, angles): ranges of beams of a robot in the tunnel."""
        local = np.column_stack([self.in_tunnel(poses[:, :2]), poses[:, 2] - self.heading_rad])
        return np.array([self.of_one(pose, angles_rad) for pose in local])

    def of_one(self, pose, angles_rad):
        directions_rad = pose[2] + angles_rad
        with np.errstate(divide="ignore"):
            wall_m = np.maximum((HALF_WIDTH_M - pose[1]) / np.sin(directions_rad), (-HALF_WIDTH_M - pose[1]) / np.sin(directions_rad))
        hit_m = pose[0] + wall_m * np.cos(directions_rad)
        outside_m = np.minimum(*(seen_m(pose, points_m, angles_rad) for points_m in (self.behind_m, self.ahead_m)))
        ranges_m = np.where((hit_m >= 0) & (hit_m <= self.length_m), wall_m, outside_m)
        return np.minimum(ranges_m, to_columns(pose[None], angles_rad, self.pillars)[0])


def seen_m(pose, points_m, angles_rad):
    """Range of the nearest of the points on each of the beams, which are evenly all around."""
    apart = points_m - pose[:2]
    bearings_rad = wrapped_rad(np.arctan2(apart[:, 1], apart[:, 0]) - pose[2] - angles_rad[0]) % (2 * np.pi)
    beams = np.round(bearings_rad / (2 * np.pi) * len(angles_rad)).astype(int) % len(angles_rad)
    ranges_m = np.full(len(angles_rad), np.inf)
    np.minimum.at(ranges_m, beams, np.linalg.norm(apart, axis=1))
    return ranges_m
