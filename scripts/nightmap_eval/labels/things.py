# SPDX-License-Identifier: Apache-2.0
"""Reads the things of a map, things.json (pipeline/io/things_io.h)."""

from dataclasses import dataclass

import numpy as np

from nightmap_eval.labels.box_overlap import UprightBox
from nightmap_site.checked_reading import NUMBER, REMEDY, read_object
from nightmap_site.script_errors import DataError

VIEW = {"time_ns": int, "color_path": str, "rectangle_px": [int]}
THING = {"name": str, "class": str, "x_m": NUMBER, "y_m": NUMBER, "heading_rad": NUMBER, "bottom_m": NUMBER, "size_m": [NUMBER],
         "num_views": int, "confidence": NUMBER, "?best_view": VIEW}  # fmt: skip


@dataclass
class Thing:
    name: str
    class_name: str
    box: UprightBox  # in the map frame; its x axis points out of the front
    num_views: int
    confidence: float  # of its class, 0 .. 1
    color_path: str  # of the picture that shows it best; "" without one
    rectangle_px: tuple  # left, top, and behind the last column and row


def read_things(site):
    """The things that the job `things` found; None where it did not run."""
    path = site.made("things", "things")
    if path is None:
        return None
    content = read_object(path, {"format": str, "version": int, "things": [THING]})
    if (content["format"], content["version"]) != ("nightmap_things", 1):
        raise DataError(f"{path}: not a list of things of this version; {REMEDY}")
    return [_thing(path, entry) for entry in content["things"]]


def _thing(path, entry):
    view = entry.get("best_view", {"color_path": "", "rectangle_px": [0, 0, 1, 1]})
    size_m = np.array(entry["size_m"], float)
    if size_m.shape != (3,) or not (size_m > 0).all() or len(view["rectangle_px"]) != 4:
        raise DataError(f"{path}: thing '{entry['name'][:80]}': not a valid size or rectangle; {REMEDY}")
    centre_m = np.array([entry["x_m"], entry["y_m"], entry["bottom_m"] + size_m[2] / 2], float)
    box = UprightBox(centre_m, size_m / 2, float(entry["heading_rad"]))
    return Thing(entry["name"], entry["class"], box, entry["num_views"], float(entry["confidence"]), view["color_path"],
                 tuple(view["rectangle_px"]))  # fmt: skip
