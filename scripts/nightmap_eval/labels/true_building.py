# SPDX-License-Identifier: Apache-2.0
"""Things that stand in a made-up building, with its classes, and how the map lies in it (truth/boxes.json)."""

from dataclasses import dataclass

import numpy as np

from nightmap_eval.floor_accuracy import RECORD_AGAIN, truth_folder
from nightmap_eval.labels.things import UprightBox
from nightmap_eval.trajectory import FRAME_GAP_NS, associate, read_truth, read_tum, umeyama
from nightmap_site.checked_reading import NUMBER, read_object
from nightmap_site.script_errors import DataError

BOX = {"center_m": [NUMBER], "half_size_m": [NUMBER], "yaw_rad": NUMBER, "label": int}
RECTANGLE = {"origin_m": [NUMBER], "edge_u_m": [NUMBER], "edge_v_m": [NUMBER], "label": int}
TRUTH = {"labels": [str], "boxes": [BOX], "rectangles": [RECTANGLE], "?things": [BOX | {"class": str}]}


@dataclass
class Rectangle:
    origin_m: np.ndarray
    edges_m: np.ndarray  # (2, 3), at right angles


@dataclass
class TrueBuilding:
    names: list  # of the classes
    boxes: list  # (label, UprightBox) of all solids
    rectangles: list  # (label, Rectangle): floors, ceilings and lamps
    things: list  # (class, UprightBox)


def read_true_building(site):
    """The truth of the recording's building; None of a recording that is not made up."""
    folder = truth_folder(site)
    path = folder / "boxes.json" if folder else None
    if path is None or not path.exists():
        return None
    truth = read_object(path, TRUTH, RECORD_AGAIN)
    boxes = [(entry["label"], _box(entry)) for entry in truth["boxes"]]
    rectangles = [(entry["label"], Rectangle(np.array(entry["origin_m"], float), np.array([*entry["edge_u_m"], *entry["edge_v_m"]], float)))
                  for entry in truth["rectangles"]]  # fmt: skip
    things = [(entry["class"], _box(entry)) for entry in truth.get("things", [])]
    _check(path, len(truth["labels"]), boxes, rectangles, things)
    return TrueBuilding(truth["labels"], boxes, rectangles, things)


def _box(entry):
    return UprightBox(np.array(entry["center_m"], float), np.array(entry["half_size_m"], float), float(entry["yaw_rad"]))


def _check(path, num_labels, boxes, rectangles, things):
    """Raises DataError on lists of numbers of another length and on labels of no class."""
    has_sizes = all(box.centre_m.shape == box.half_size_m.shape == (3,) for _, box in [*boxes, *things])
    has_sizes = has_sizes and all(part.origin_m.shape == (3,) and part.edges_m.shape == (6,) for _, part in rectangles)
    if not has_sizes or not all(0 <= label < num_labels for label, _ in [*boxes, *rectangles]):
        raise DataError(f"{path}: not a valid box or rectangle; {RECORD_AGAIN}")
    for _, part in rectangles:
        part.edges_m = part.edges_m.reshape(2, 3)


def building_from_map(site):
    """The rigid transform that aligns the trajectory with the true one, as evaluate aligns it; None without a truth."""
    path = site.made("map_frame", "trajectory")
    if path is None or not site.ground_truth.exists():
        return None
    estimate, truth = read_tum(path), read_truth(site.ground_truth)
    pairs = associate(estimate.times_ns, truth.times_ns, FRAME_GAP_NS)
    return umeyama(estimate.positions_m[pairs[:, 0]], truth.positions_m[pairs[:, 1]], with_scale=False)
