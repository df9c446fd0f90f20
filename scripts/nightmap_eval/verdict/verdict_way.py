# SPDX-License-Identifier: Apache-2.0
"""Checks of the camera's way through the map: speed, agreement with the odometry, the floor under it."""

import math

import numpy as np

from nightmap_eval.artifacts import BRIDGED, STARTED, Frames, bridged_frames, frames_apart, shard_names, tracking_states
from nightmap_eval.trajectory import angles_deg, read_tum, travelled_m
from nightmap_eval.verdict.verdict import check, escaped, unknown
from nightmap_site.checked_reading import NUMBER, read_object, using

APART_NS = 1_000_000_000  # over less the noise of two poses passes for motion: some recorders write each frame twice, 1 ms apart
FLOOR = {"?floor_source": str, "?camera_height_m": NUMBER, "?below_floor_percent": NUMBER, "?floor_warnings": [str],
         "?gravity_source": str, "?up_odds": NUMBER, "?up_warning": str}


def checks(site):
    trajectory = read_tum(site.path("map_frame", "trajectory"))
    yield from _speed_checks(site, trajectory)
    yield from _odometry_checks(site, trajectory)
    floor = read_object(site.path("map_frame", "report"), FLOOR)
    yield from _up_checks(floor)
    yield from _floor_checks(floor)


def _up_checks(floor):
    reason = "of what was seen, for the direction of up and for the next likely: z of the map is wrong if it is that one"
    if "up_odds" in floor:
        yield check("direction of up", floor["up_odds"], "times as likely", (10, math.inf), reason,
                    escaped(floor.get("up_warning", "")))  # fmt: skip
    elif floor.get("gravity_source") == "camera attitude":
        yield unknown("direction of up", reason, "no surface was seen: z of the map is up only if the camera was held level", matters=True)


def _floor_checks(floor):
    if "floor_source" not in floor:  # the way of a robot's laser, whose z is 0
        return
    height, below = "above what was taken for the floor; robots and people carry cameras so", "of the measured points: nothing is below a floor"
    if floor.get("floor_source") == "floor plane":
        yield check("camera height", floor.get("camera_height_m", 0.0), "m", (0.15, 2.5), height, "the camera is {value:.2f} m above what "
                    "was taken for the floor: a table, a counter or another storey? Is depth_units_per_m right?")  # fmt: skip
        yield check("below the floor", floor.get("below_floor_percent", 0.0), "%", (0, 3), below,
                    "{value:.1f} % of what was seen lies below what was taken for the floor: it may be a table or a counter "
                    "(map_frame.floor_min_camera_height_m)")  # fmt: skip
    elif floor.get("floor_source") != "given trajectory":
        yield unknown("camera height", height, "no floor was seen")
        yield unknown("below the floor", below, "no floor was seen")
    warnings = floor.get("floor_warnings", [])
    yield check("warnings of the floor", len(warnings), "", (0, 0), "of map_frame", escaped("; ".join(warnings)))


def _odometry_checks(site, trajectory):
    if not site.has("odometry") or site.pipeline.jobs["odometry"].unit != "shard":
        return
    turns_deg = np.concatenate([np.zeros(0), *(_turns_of_shard(site, name, trajectory) for name in shard_names(site))])
    if len(turns_deg):
        yield check("odometry against the map", float(np.quantile(turns_deg, 0.9)), "deg", (0, 5), "between frames a second apart; loops and "
                    "the adjustment move these by less than the odometry's own error, a degree or two",
                    "the map turns frames a second apart by {value:.1f} deg against what odometry measured: false loops, what moves, or a "
                    "wrong camera bend it", usable=(0, 20))  # fmt: skip


def _turns_of_shard(site, name, trajectory):
    path = site.made("odometry", "trajectory", name)
    if not path:
        return np.zeros(0)
    odometry, (_, states) = read_tum(path), tracking_states(site, name)
    with using(path):
        return disagreement_deg(odometry, states if len(states) else np.zeros(len(odometry)), trajectory)


def disagreement_deg(odometry, states, trajectory):
    """By how much the turns from each frame to the one a second later differ, where the odometry measured the motion between them."""
    _, own, others = np.intersect1d(odometry.times_ns, trajectory.times_ns, return_indices=True)
    is_measured = states[own] != BRIDGED
    own, others = own[is_measured], others[is_measured]
    parts = np.cumsum(states == STARTED)[own]
    times_ns = odometry.times_ns[own]
    later = np.searchsorted(times_ns, times_ns + APART_NS)
    first = np.flatnonzero(later < len(times_ns))
    first = first[parts[first] == parts[later[first]]]
    turns = [np.swapaxes(rotations[first], 1, 2) @ rotations[later[first]]
             for rotations in (odometry.rotations()[own], trajectory.rotations()[others])]  # fmt: skip
    return angles_deg(np.swapaxes(turns[0], 1, 2) @ turns[1])


def _speed_checks(site, trajectory):
    frames = Frames(site)
    guessed = np.isin(frames.frame_idxs, [*bridged_frames(site), *frames_apart(site)])
    is_measured = ~np.isin(trajectory.times_ns, frames.times_ns[guessed])
    speeds_m_per_s = speeds(trajectory.select(np.flatnonzero(is_measured)), frames)
    if len(speeds_m_per_s):
        yield check("speed", float(np.quantile(speeds_m_per_s, 0.98)), "m/s", (0, 3), "the fastest fiftieth of the way: people walk at "
                    "1.5 m/s, and robots indoors are slower",
                    "the camera moves at {value:.1f} m/s: are the frames in the order of recording, are their times right, and "
                    "depth_units_per_m?", usable=(0, 6))  # fmt: skip


def speeds(trajectory, frames):
    """Length of the way over the second from each frame on, per time, within each sequence; m/s."""
    sequence_of = dict(zip(frames.times_ns.tolist(), frames.sequence_idxs.tolist()))
    sequences = np.array([sequence_of.get(time_ns, -1) for time_ns in trajectory.times_ns.tolist()])
    ways = (trajectory.select(np.flatnonzero(sequences == idx)) for idx in np.unique(sequences[sequences >= 0]))
    found = [np.zeros(0)]
    for way in ways:
        ways_m = travelled_m(way.positions_m)
        later = np.searchsorted(way.times_ns, way.times_ns + APART_NS)
        first = np.flatnonzero(later < len(way))
        later = later[first]
        found.append((ways_m[later] - ways_m[first]) / ((way.times_ns[later] - way.times_ns[first]) / 1e9))
    return np.concatenate(found)
