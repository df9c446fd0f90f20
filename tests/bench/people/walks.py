# SPDX-License-Identifier: Apache-2.0
"""Ways of people through a room in which a camera moves. Pure; equal random streams give equal ways.

A way has a pose at each knot: at a place that the camera sees at that time, turned to it. From knot to knot a person walks, or
stands still in the world however the camera moves. Poses are world_from_person, with the axes of a camera: a person who
faces the camera has its rotation.
"""

from dataclasses import dataclass

import numpy as np
from nightmap_eval.trajectory import Trajectory, interpolated

KNOT_S = 1.2
RANGE = 1.5  # the farthest aims, of the nearest
TOO_NEAR_M = 0.5  # nobody waits for a camera to run through
FAR_M, FACING = 3.0, 0.5  # who sits is seen within this depth, and within 60 degrees (cosine) of where he looks
NUM_PLACES = 200
ASIDE = 0.8  # of the width of the picture beyond its edge: nobody there is seen


@dataclass
class View:
    """The camera, and its poses at the frames and at the knots."""

    fx: float
    fy: float
    cx: float
    cy: float
    width: int
    height: int
    nearest_m: float  # of aims
    frame_s: np.ndarray
    frames: Trajectory
    knots: Trajectory

    def aim(self, knot, u, v, z_m):
        """Position and quaternion of who is seen at a knot at this place, in shares of the picture."""
        ray = np.array([(u * self.width - self.cx) / self.fx, (v * self.height - self.cy) / self.fy, 1])
        return self.knots.positions_m[knot] + z_m * self.knots.rotations()[knot] @ ray, self.knots.quaternions[knot]


class Way:
    """Poses at the knots, from the start of the recording on. After its last knot the person has gone."""

    def __init__(self, poses):
        positions, quaternions = zip(*poses)
        self.knots = Trajectory(np.arange(len(poses)) * 10**9, np.array(positions), np.array(quaternions))

    def at(self, time_s):
        """Position and rotation at a time; None when the person has gone."""
        knot, share = int(time_s / KNOT_S), time_s / KNOT_S % 1
        if knot + 1 >= len(self.knots):
            return None
        smooth = share * share * (3 - 2 * share)
        _, pose = interpolated(self.knots, [knot * 10**9 + round(smooth * 1e9)], 10**9, same_ns=0)
        return pose.positions_m[0], pose.rotations()[0]

    def moves(self, times_s):
        """Whether the person is faster than 2 cm/s from the first of three times to the second, and on to the third: who stops
        or starts stands, and who turns back does not."""
        positions_m = [self.at(time_s)[0] for time_s in times_s if self.at(time_s) is not None]
        return bool(np.all(np.linalg.norm(np.diff(positions_m, axis=0), axis=1) > 0.02 * np.diff(times_s[:len(positions_m)])))


def poses_at(truth, times_ns):
    """The camera's poses at any times; outside of the truth's times, the nearest."""
    inside = np.clip(times_ns, truth.times_ns[0], truth.times_ns[-1])
    return interpolated(truth, inside, np.iinfo(np.int64).max, same_ns=0)[1]


def random_aim(view, knot, random):
    return view.aim(knot, random.uniform(0, 1), random.uniform(0.55, 0.75), random.uniform(1, RANGE) * view.nearest_m)


def wander(view, random):
    """At each knot a person pauses until the next, or walks to where the camera will see him then."""
    poses = [random_aim(view, 0, random)]
    for knot in range(1, len(view.knots)):
        between = (view.frame_s >= (knot - 1) * KNOT_S) & (view.frame_s <= knot * KNOT_S)
        far = np.linalg.norm(view.frames.positions_m[between] - poses[-1][0], axis=1) > TOO_NEAR_M
        pauses = random.random() < 0.5 and far.all()
        poses.append(poses[-1] if pauses else random_aim(view, knot, random))
    return Way(poses)


def sit(view, random):
    """Never moves, at the place that most frames see."""
    return Way([_place(view, len(view.knots), random)] * len(view.knots))


def leave(view, random):
    """Stands for the first third of the recording where most of its frames see him, then walks out of the picture for good."""
    num = max(1, round(len(view.knots) / 3))
    place = _place(view, num, random)
    u = random.choice([-ASIDE, 1 + ASIDE])
    return Way([place] * num + [view.aim(min(num, len(view.knots) - 1), u, 0.65, RANGE * view.nearest_m)])


def _place(view, num_knots, random):
    """The one of random aims at the first knots that most frames until then see."""
    aims = [random_aim(view, random.integers(num_knots), random) for _ in range(NUM_PLACES)]
    frames = view.frames.select(np.flatnonzero(view.frame_s <= num_knots * KNOT_S))
    return max(aims, key=lambda aim: _num_seeing(view, frames, *aim))


def _num_seeing(view, frames, position_m, quaternion):
    from_camera_m = position_m - frames.positions_m
    x, y, z = np.einsum("nij,ni->jn", frames.rotations(), from_camera_m)
    facing = from_camera_m @ Trajectory(None, None, quaternion[None]).rotations()[0][:, 2] / np.linalg.norm(from_camera_m, axis=1)
    z_or_one = np.where(z > TOO_NEAR_M, z, 1)
    u, v = view.fx * x / z_or_one + view.cx, view.fy * y / z_or_one + view.cy
    is_seen = (u >= 0) & (u < view.width) & (v >= 0) & (v < view.height) & (z > TOO_NEAR_M) & (z < FAR_M) & (facing > FACING)
    return np.count_nonzero(is_seen)
