# SPDX-License-Identifier: Apache-2.0
"""Places of the map that a person should look at: where surfaces are thick, rays contradict, landmarks are uncertain, or motion was guessed."""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import label, maximum_position

from nightmap_eval.artifacts import Frames, bridged_frames, frames_apart
from nightmap_eval.ways import way_of

MAX_PLACES = 6
MIN_M2 = 0.4  # a place that is smaller is no place to look at
# Field -> (from which value on a place is bad, whether larger is worse, words). Depth cameras are exact to 1 or 2 cm within 4 m, and
# a wall that was drawn twice is thicker. A laser draws a wall one or two cells of 5 cm thick. Held-out rays agree but for edges and glass. Queries are asked for within 5 to 10 cm.
LIMITS = {
    "thickness of surfaces": (4, True, "surfaces are up to {:.1f} cm thick"),
    "held-out rays that agree": (70, False, "only {:.0f} % of the held-out rays agree with the cloud"),
    "uncertainty of landmarks": (10, True, "landmarks are uncertain by {:.0f} cm"),
    "walls drawn twice": (50, True, "{:.0f} % of the walls are drawn twice: the robot's way did not meet itself again"),
    "thickness of walls": (25, True, "walls are {:.0f} cm thick: scans of this place do not agree"),
}


@dataclass
class Place:
    floor: int
    x_m: float
    y_m: float
    said: str


def places_to_look_at(site, plan, fields):
    """(places, names of what was judged). The worst first: guessed motion, then each field's by area."""
    judged = (["motion"] if site.has("odometry") and site.has_camera() else []) + [name for name in LIMITS if any(field.name == name for field in fields)]
    found = guessed(site, plan)
    for name in LIMITS:
        places = [place for field in fields if field.name == name for place in bad_parts(field)]
        found += [place for _, place in sorted(places, key=lambda item: -item[0])]
    return found[:MAX_PLACES], judged


def bad_parts(field):
    """(area, place) of each part of a field that hangs together and is beyond its limit; the place is its worst cell."""
    limit, is_larger_worse, words = LIMITS[field.name]
    badness = field.values - limit if is_larger_worse else limit - field.values
    parts, _ = label(np.nan_to_num(badness, nan=-1) > 0, np.ones((3, 3)))
    areas_m2 = np.bincount(parts.ravel()) * field.resolution_m**2
    large = [number for number in range(1, len(areas_m2)) if areas_m2[number] >= MIN_M2]
    for number, (row, column) in zip(large, maximum_position(badness, parts, large)):
        area_m2 = float(areas_m2[number])
        x_m, y_m = (field.origin_m[axis] + (cell + 0.5) * field.resolution_m for axis, cell in enumerate((column, row)))
        yield area_m2, Place(field.floor, float(x_m), float(y_m), words.format(field.values[row, column]))


def guessed(site, plan):
    """The middle of each run of frames whose motion was guessed, and of each part that only guessed motion joins to the map."""
    way = way_of(site)
    if way is None or not site.has_camera():
        return []
    frames, places = Frames(site), []
    row_of_time = {int(time_ns): row for row, time_ns in enumerate(way.times_ns)}
    row_of_frame = {int(idx): row_of_time.get(int(time_ns)) for idx, time_ns in zip(frames.frame_idxs, frames.times_ns)}
    for idxs, words in ((bridged_frames(site), "matched no other: their poses are guesses"),
                        (frames_apart(site), "hang together with the rest only by guessed motion")):  # fmt: skip
        for run in np.split(np.array(idxs, dtype=int), np.nonzero(np.diff(idxs) > 1)[0] + 1) if idxs else []:
            row = row_of_frame.get(int(run[len(run) // 2]))
            if row is not None:
                x_m, y_m, z_m = way.positions_m[row].tolist()
                frames_said = f"frame {run[0]}" if len(run) == 1 else f"frames {run[0]} to {run[-1]}"
                places.append((len(run), Place(int(plan.numbers_at([z_m])[0]), x_m, y_m, f"{frames_said} {words}")))
    return [place for _, place in sorted(places, key=lambda item: -item[0])]
