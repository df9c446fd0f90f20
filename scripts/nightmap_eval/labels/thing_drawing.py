# SPDX-License-Identifier: Apache-2.0
"""Draws the boxes of things on a map: footprint, front and name."""

import numpy as np
from matplotlib.patches import Polygon
from matplotlib.patheffects import withStroke

from nightmap_eval.drawing import RED

FONT_PT, LINE_PT, LETTER_PT = 6, 7, 3.5
ARROW_M = 0.25
USED_PT = np.array([520, 420])  # of a figure, by the map


def draw_things(axes, things):
    """On a map that is drawn, whose limits stay."""
    axes.autoscale(False)
    extent_m = np.array([np.ptp(axes.get_xlim()), np.ptp(axes.get_ylim())])
    for box in (thing.box for thing in things):  # the footprint, its front with an arrow out of it
        corners_m, forward = box.corners_m(), box.axes()[0]
        front_m = box.centre_m[:2] + box.half_size_m[0] * forward
        axes.add_patch(Polygon(corners_m, fill=False, edgecolor="black", lw=0.8))
        axes.plot(*corners_m[1:3].T, color=RED, lw=2, solid_capstyle="butt")
        axes.annotate("", front_m + ARROW_M * forward, front_m, arrowprops={"arrowstyle": "->", "color": RED, "lw": 1, "shrinkA": 0, "shrinkB": 0})
    for thing, place_m in zip(things, name_places_m(things, float((extent_m / USED_PT).max()))):
        axes.text(*place_m, thing.name, fontsize=FONT_PT, ha="center", va="center", clip_on=True, parse_math=False,
                  path_effects=[withStroke(linewidth=1.5, foreground="white")])  # fmt: skip


def name_places_m(things, m_per_pt):
    """The middle of each name: that of its box, or as far below as it must be to cover no name before it."""
    taken = []  # x, y, width
    for thing in things:
        (x, y), width_m = thing.box.centre_m[:2], LETTER_PT * len(thing.name) * m_per_pt
        while any(abs(x - u) < (width_m + w) / 2 and abs(y - v) < 0.99 * LINE_PT * m_per_pt for u, v, w in taken):
            y -= LINE_PT * m_per_pt
        taken.append((x, y, width_m))
    return [(x, y) for x, y, _ in taken]
