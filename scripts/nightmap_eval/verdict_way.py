# SPDX-License-Identifier: Apache-2.0
"""Checks of the camera's way through the map: speed, agreement with the odometry, the floor under it."""

import numpy as np

from nightmap_eval.artifacts import Frames, shard_names
from nightmap_eval.trajectory import angles_deg, read_tum
from nightmap_eval.verdict import check
from nightmap_site.checked_reading import NUMBER, read_object

FLOOR = {"?floor_source": str, "?camera_height_m": NUMBER, "?below_floor_percent": NUMBER, "?floor_warnings": [str]}


def checks(site):
    trajectory = read_tum(site.path("map_frame", "trajectory"))
    yield from _speed_checks(site, trajectory)
    yield from _odometry_checks(site, trajectory)
    floor = read_object(site.path("map_frame", "report"), FLOOR)
    if floor.get("floor_source") != "floor plane":
        return
    height_m = floor.get("camera_height_m", 0.0)
    yield check("camera height", height_m, "m", (0.15, 2.5), "above what was taken for the floor; robots and people carry cameras so",
                "the camera is {value:.2f} m above what was taken for the floor: a table, a counter or another storey? Is "
                "depth_units_per_m right?")  # fmt: skip
    yield check("below the floor", floor.get("below_floor_percent", 0.0), "%", (0, 3), "of the measured points: nothing is below a floor",
                "{value:.1f} % of what was seen lies below what was taken for the floor: it may be a table or a counter "
                "(map_frame.floor_min_camera_height_m)")  # fmt: skip
    warnings = floor.get("floor_warnings", [])
    yield check("warnings of the floor", len(warnings), "", (0, 0), "of map_frame", "; ".join(warnings).replace("{", "{{").replace("}", "}}"))


def _odometry_checks(site, trajectory):
    if not site.has("odometry") or site.pipeline.jobs["odometry"].unit != "shard":
        return
    paths = filter(None, (site.made("odometry", "trajectory", name) for name in shard_names(site)))
    turns_deg = np.concatenate([np.zeros(0), *(disagreement_deg(read_tum(path), trajectory) for path in paths)])
    if len(turns_deg):
        yield check("odometry against the map", float(np.quantile(turns_deg, 0.9)), "deg", (0, 5), "between frames a second apart; loops and "
                    "the adjustment move these by less than the odometry's own error, a degree or two",
                    "the map turns frames a second apart by {value:.1f} deg against what odometry measured: false loops, what moves, or a "
                    "wrong camera bend it", usable=(0, 20))  # fmt: skip


def disagreement_deg(odometry, trajectory, apart_ns=1_000_000_000):
    """By how much the turns from each frame to the one a second later differ."""
    _, own, others = np.intersect1d(odometry.times_ns, trajectory.times_ns, return_indices=True)
    times_ns = odometry.times_ns[own]
    later = np.searchsorted(times_ns, times_ns + apart_ns)
    first = np.flatnonzero(later < len(times_ns))
    turns = [np.swapaxes(rotations[first], 1, 2) @ rotations[later[first]]
             for rotations in (odometry.rotations()[own], trajectory.rotations()[others])]  # fmt: skip
    return angles_deg(np.swapaxes(turns[0], 1, 2) @ turns[1])


def _speed_checks(site, trajectory):
    speeds_m_per_s = speeds(trajectory, Frames(site))
    if len(speeds_m_per_s):
        yield check("speed", float(np.quantile(speeds_m_per_s, 0.98)), "m/s", (0, 3), "the fastest fiftieth of the way: people walk at "
                    "1.5 m/s, and robots indoors are slower",
                    "the camera moves at {value:.1f} m/s: are the frames in the order of recording, are their times right, and "
                    "depth_units_per_m?", usable=(0, 6))  # fmt: skip


def speeds(trajectory, frames):
    """Between frames in succession, of one sequence, m/s."""
    sequence_of = dict(zip(frames.times_ns.tolist(), frames.sequence_idxs.tolist()))
    sequences = np.array([sequence_of.get(time_ns, -1) for time_ns in trajectory.times_ns.tolist()])
    steps_s, steps_m = np.diff(trajectory.times_ns) / 1e9, np.linalg.norm(np.diff(trajectory.positions_m, axis=0), axis=1)
    together = (np.diff(sequences) == 0) & (steps_s > 0)
    return steps_m[together] / steps_s[together]
