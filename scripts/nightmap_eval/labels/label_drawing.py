# SPDX-License-Identifier: Apache-2.0
"""Draws the labelled voxels of a floor from above, each class in its color."""

import numpy as np
from matplotlib.patches import Patch

NO_VOXEL = -1
BACKGROUND = (235, 235, 235)
MAX_SIDE_PX = 4000
BELOW_FLOOR_M, HEADROOM_M = 0.2, 2.2  # ceilings are above


def floor_from_above(voxels, floor):
    return from_above(voxels, floor["height_m"] - BELOW_FLOOR_M, floor["height_m"] + HEADROOM_M)


def from_above(voxels, low_m, high_m):
    """Label of the highest voxel of each column between two heights: (rows, columns), row 0 lowest in y; and left, right, bottom, top.

    Where the map is larger than MAX_SIDE_PX voxels, several columns are one pixel."""
    heights_m = voxels.centres_m()[:, 2]
    chosen = np.flatnonzero((heights_m >= low_m) & (heights_m < high_m))
    if len(chosen) == 0:
        return np.full((1, 1), NO_VOXEL), (0.0, 1.0, 0.0, 1.0)
    chosen = chosen[np.argsort(voxels.keys[chosen, 2], kind="stable")]
    low, high = voxels.keys[chosen, :2].min(axis=0), voxels.keys[chosen, :2].max(axis=0) + 1
    step = int(np.ceil((high - low).max() / MAX_SIDE_PX))
    size = -((low - high) // step)
    image = np.full(size[::-1], NO_VOXEL)
    columns, rows = ((voxels.keys[chosen, :2] - low) // step).T
    image[rows, columns] = voxels.labels[chosen]  # the last of a column stays: the highest
    left, bottom = low * voxels.resolution_m
    width, height = size * step * voxels.resolution_m
    return image, (left, left + width, bottom, bottom + height)


def draw(axes, voxels, image, extent_m, opacity=1.0):
    """Colors of the classes; what has no voxel stays light gray."""
    palette = np.array([[int(color[i : i + 2], 16) for i in (1, 3, 5)] for color in voxels.colors] + [BACKGROUND], float)
    palette = opacity * palette + (1 - opacity) * np.array(BACKGROUND)
    axes.imshow(palette[image].astype(np.uint8), origin="lower", extent=extent_m, interpolation="nearest")


def legend_of(voxels, image):
    """A patch for each class of the picture, for its legend."""
    shown = np.unique(image[image != NO_VOXEL])
    plain = [name.replace("$", r"\$") for name in voxels.names]  # in which Matplotlib finds no formula
    return [Patch(facecolor=voxels.colors[i], edgecolor="#888888", label=plain[i]) for i in shown]
