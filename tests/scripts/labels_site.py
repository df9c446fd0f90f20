# SPDX-License-Identifier: Apache-2.0
"""A small site with labelled voxels and things, and the made-up building that they are of, for the tests of labels and things."""

import json
import shutil
from unittest import mock

import numpy as np

import fake_site
from fake_site import rotation_about
from nightmap_eval.things import UprightBox
from nightmap_eval.sealed_hdf5 import sealed
from nightmap_site.site import Site

NAMES = ["none", "wall", "floor", "table", "chair", "poster"]
COLORS = ["#000000", "#808080", "#c0a080", "#0000ff", "#00ff00", "#ff00ff"]
RESOLUTION_M = 0.05
MAP_YAW_RAD, MAP_M = 0.5, np.array([1.0, -2.0, 0.0])  # fake_site.write_site turns and moves the building so

# Far enough apart that no voxel is near two of them; nobody saw the far chair.
TABLE = UprightBox(np.array([2.0, 0, 0.7]), np.array([0.6, 0.4, 0.3]), 0.3)
CHAIR = UprightBox(np.array([-1.0, 1, 0.7]), np.array([0.25, 0.25, 0.4]), 0)
FAR_CHAIR = UprightBox(np.array([40.0, 0, 0.7]), np.array([0.25, 0.25, 0.4]), 0)
WALL = UprightBox(np.array([0, -3.0, 1.0]), np.array([2.0, 0.1, 0.6]), 0)
BOXES = (("table", TABLE), ("chair", CHAIR), ("wall", WALL))


def write_configs(folder):
    shutil.copytree(fake_site.CHECKOUT / "configs", folder, ignore=shutil.ignore_patterns("sites"))


def write_site(root):
    """Folders maps/hall and configs, and the truth of the recordings below root."""
    write_configs(root / "configs")
    site_dir = root / "maps" / "hall"
    fake_site.write_site(site_dir)
    (site_dir / "config" / "site").mkdir(parents=True)
    (site_dir / "config" / "profile.toml").write_text('profile = "labels"\nimports = []\n')
    (site_dir / "config" / "site" / "hall.toml").write_text('root = "made_up"\n')
    write_truth(root / "made_up" / "truth", BOXES, [("table", TABLE), ("chair", CHAIR), ("chair", FAR_CHAIR)])
    return site_dir


def opened(root):
    with mock.patch("nightmap_site.site.CONFIGS", root / "configs"):
        return Site(root / "maps" / "hall", root)


def _box(box):
    return {"center_m": box.centre_m.tolist(), "half_size_m": box.half_size_m.tolist(), "yaw_rad": box.heading_rad, "piece": 0}


def write_truth(folder, boxes, things):
    folder.mkdir(parents=True, exist_ok=True)
    floor = {"origin_m": [-3, -3, 0], "edge_u_m": [6, 0, 0], "edge_v_m": [0, 6, 0], "label": NAMES.index("floor")}
    truth = {"labels": NAMES, "boxes": [_box(box) | {"label": NAMES.index(name)} for name, box in boxes],
             "things": [_box(box) | {"label": NAMES.index(name), "class": name} for name, box in things], "rectangles": [floor]}  # fmt: skip
    (folder / "boxes.json").write_text(json.dumps(truth))


def face_points(box):
    """Points on all faces of a box, closer than voxels."""
    sides = [np.linspace(-half_m, half_m, int(half_m / 0.01)) for half_m in box.half_size_m]
    points = []
    for axis in range(3):
        for sign in (-1, 1):
            grid = np.meshgrid(*[np.array([sign * box.half_size_m[i]]) if i == axis else sides[i] for i in range(3)], indexing="ij")
            points.append(np.stack(grid, axis=-1).reshape(-1, 3))
    points = np.concatenate(points)
    return np.column_stack([points[:, :2] @ box.axes(), points[:, 2]]) + box.centre_m


def floor_points():
    x, y = np.meshgrid(np.arange(-2.9, 2.9, 0.02), np.arange(-2.5, 2.9, 0.02))
    return np.column_stack([x.ravel(), y.ravel(), np.full(x.size, 0.01)])


def in_map(points_m):
    return points_m @ rotation_about([0, 0, 1], MAP_YAW_RAD).T + MAP_M


def thing_box(box):
    """A box of the building in the map."""
    return UprightBox(in_map(box.centre_m[None])[0], box.half_size_m, box.heading_rad + MAP_YAW_RAD)


def keys_of(points_m):
    return np.unique(np.floor(in_map(points_m) / RESOLUTION_M).astype(np.int32), axis=0)


def perfect_parts():
    """Points of the building and the class they have."""
    return [(face_points(box), name) for name, box in BOXES] + [(floor_points(), "floor")]


def write_voxels(site_dir, parts, names=NAMES):
    """parts: (points of the building, class) each. All votes of a voxel are for its class."""
    keys = [keys_of(points) for points, _ in parts]
    labels = np.concatenate([np.full(len(part), names.index(name), np.uint8) for part, (_, name) in zip(keys, parts)])
    keys, first = np.unique(np.concatenate(keys), axis=0, return_index=True)
    write_votes(site_dir, keys, np.arange(len(keys) + 1), labels[first], np.ones(len(keys)), names)


def write_votes(site_dir, keys, offsets, votes, weights, names=NAMES):
    folder = site_dir / "voxel_labels"
    folder.mkdir(exist_ok=True)
    with sealed(folder / "voxels.h5") as file:
        file["resolution_m"] = np.array([[RESOLUTION_M]])
        file["key"] = np.asarray(keys, np.int32)
        file["vote_offset"] = np.asarray(offsets, np.int64)[:, None]
        file["vote_label"] = np.asarray(votes, np.uint8)[:, None]
        file["vote_weight"] = np.asarray(weights, np.float32)[:, None]
    legend = [{"label": i, "name": name, "color": COLORS[i], "num_voxels": 0} for i, name in enumerate(names)]
    (folder / "legend.json").write_text(json.dumps({"format": "nightmap_legend", "version": 1, "classes": legend}))


def thing_entry(name, class_name, box, **changes):
    """A line of things.json, of a box in the map frame."""
    return {"name": name, "class": class_name, "x_m": box.centre_m[0], "y_m": box.centre_m[1], "heading_rad": box.heading_rad,
            "bottom_m": box.centre_m[2] - box.half_size_m[2], "size_m": (2 * box.half_size_m).tolist(), "num_views": 7,
            "confidence": 0.9} | changes  # fmt: skip


def write_things(site_dir, *entries):
    (site_dir / "things").mkdir(exist_ok=True)
    content = {"format": "nightmap_things", "version": 1, "things": list(entries)}
    (site_dir / "things" / "things.json").write_text(json.dumps(content))
