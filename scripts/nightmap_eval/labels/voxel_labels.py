# SPDX-License-Identifier: Apache-2.0
"""Reads the labelled voxels of a map (pipeline/dense/voxel_labels_io.h) with the names and colors of their classes."""

import re
from dataclasses import dataclass

import numpy as np

from nightmap_eval.artifacts import read_hdf5
from nightmap_site.checked_reading import REMEDY, read_object, using
from nightmap_site.script_errors import DataError

COLOR = re.compile(r"#[0-9a-f]{6}")
LEGEND = {"classes": [{"name": str, "color": str}]}


@dataclass
class VoxelLabels:
    """Voxel i is the cube [key, key + 1) * resolution_m of the map frame, and of the class that its votes most speak for."""

    resolution_m: float
    keys: np.ndarray  # (n, 3) int
    labels: np.ndarray  # (n,) int, of names and colors
    names: list
    colors: list  # "#rrggbb"

    def centres_m(self):
        return (self.keys + 0.5) * self.resolution_m


def read_voxel_labels(site):
    """The voxels that join_labels wrote; None without them."""
    path, legend = site.made("join_labels", "voxels"), site.made("join_labels", "legend")
    if path is None or legend is None:
        return None
    classes = read_object(legend, LEGEND)["classes"]
    if not all(COLOR.fullmatch(entry["color"]) for entry in classes):
        raise DataError(f"{legend}: a color is not #rrggbb; {REMEDY}")
    names, colors = ([entry[key] for entry in classes] for key in ("name", "color"))
    resolution_m, keys, offsets, votes, weights = read_hdf5(path, "resolution_m", "key", "vote_offset", "vote_label", "vote_weight")
    with using(path):
        resolution_m, keys = float(np.ravel(resolution_m)[0]), keys.reshape(-1, 3).astype(np.int64)
        labels = strongest(np.ravel(offsets).astype(np.int64), np.ravel(votes).astype(np.int64), np.ravel(weights))
        if len(labels) != len(keys) or labels.max(initial=-1) >= len(names) or not 0 < resolution_m < np.inf:
            raise ValueError("its arrays do not fit each other or the legend")
    return VoxelLabels(resolution_m, keys, labels, names, colors)


def strongest(offsets, votes, weights):
    """The vote of most weight of each voxel, and the smallest of equal ones; each voxel has a vote."""
    counts = np.diff(offsets)
    if len(counts) == 0:
        return np.zeros(0, np.int64)
    if offsets[0] != 0 or counts.min() < 1 or not offsets[-1] == len(votes) == len(weights):
        raise ValueError("vote_offset does not fit the votes")
    is_best = weights == np.repeat(np.maximum.reduceat(weights, offsets[:-1]), counts)
    voxel_of_best = np.repeat(np.arange(len(counts)), counts)[is_best]
    _, first = np.unique(voxel_of_best, return_index=True)
    return votes[is_best][first]
