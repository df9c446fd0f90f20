# SPDX-License-Identifier: Apache-2.0
"""Checks of the camera's way through the map: speed, the floor under it."""

import numpy as np

from nightmap_eval.artifacts import Frames
from nightmap_eval.trajectory import read_tum
from nightmap_eval.verdict import check
from nightmap_site.checked_reading import NUMBER, read_object

FLOOR = {"?floor_source": str, "?camera_height_m": NUMBER, "?below_floor_percent": NUMBER, "?floor_warnings": [str]}


def checks(site):
    yield from _speed_checks(site)
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


def _speed_checks(site):
    speeds_m_per_s = speeds(read_tum(site.path("map_frame", "trajectory")), Frames(site))
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
