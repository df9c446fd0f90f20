# SPDX-License-Identifier: Apache-2.0
"""Plots of the comparison: recall curves, histograms of the errors, queries on the map."""

import matplotlib.pyplot as plt
import numpy as np

from nightmap_eval.drawing import BLUE, GRAY, GREEN, ORANGE, RED, map_axes, draw_grid, to_png

COLORS = {"nightmap": BLUE, "colmap_mapper": ORANGE, "colmap_triangulate": GREEN, "colmap_held": RED}
DEFAULT = "_default"  # with COLMAP's number of retrieved images: the same color, dashed
MARKERS = {"nightmap": "^", "colmap_mapper": "x", "colmap_triangulate": "+", "colmap_held": "1"}
BINS_CM = np.geomspace(0.1, 1000, 25)


def _line(method):
    return {"color": COLORS[method.removesuffix(DEFAULT)], "ls": "--" if method.endswith(DEFAULT) else "-"}


def _panels(errors, size):
    """One plot per protocol; errors: protocol -> method -> errors in cm."""
    figure, all_axes = plt.subplots(1, len(errors), figsize=size, sharey=True, squeeze=False)
    for axes, protocol in zip(all_axes[0], errors):
        axes.set_xscale("log")
        axes.set_xlabel("position error (cm)")
        axes.set_title(f"{protocol} alignment", fontsize=11)
        axes.grid(alpha=0.3)
    return figure, all_axes[0]


def recall_png(errors, num_queries):
    """Share of all queries located within each error; a query without a pose never counts."""
    figure, panels = _panels(errors, (9.5, 3.6))
    for axes, by_method in zip(panels, errors.values()):
        for method, errors_cm in by_method.items():
            percent = 100 * np.searchsorted(np.sort(errors_cm), BINS_CM, side="right") / num_queries
            axes.plot(BINS_CM, percent, **_line(method), label=method)
        axes.set_ylim(0, 102)
    panels[0].set_ylabel("queries (%)")
    panels[0].legend(fontsize=9, loc="lower right")
    return to_png(figure)


def histogram_png(errors):
    figure, panels = _panels(errors, (9.5, 3.2))
    for axes, by_method in zip(panels, errors.values()):
        for method, errors_cm in by_method.items():
            inside = np.clip(errors_cm, BINS_CM[0], BINS_CM[-1])
            axes.hist(inside, BINS_CM, histtype="step", lw=1.6, **_line(method), label=method)
    panels[0].set_ylabel("queries")
    panels[0].legend(fontsize=9, loc="upper left")
    return to_png(figure)


def queries_png(grid, trajectory_m, positions_m):
    """Positions of the queries by each method, in nightmap's map; positions_m: method -> (n, 3)."""
    figure, axes = map_axes("Located queries from above, in nightmap's map")
    if grid is not None:
        draw_grid(axes, grid)
    axes.plot(trajectory_m[:, 0], trajectory_m[:, 1], color=GRAY, lw=0.8, label="map frames")
    for method, points_m in positions_m.items():
        axes.plot(points_m[:, 0], points_m[:, 1], MARKERS[method.removesuffix(DEFAULT)], ms=5 - 2 * method.endswith(DEFAULT),
                  color=COLORS[method.removesuffix(DEFAULT)], label=method)  # fmt: skip
    axes.legend(fontsize=9, loc="upper left", bbox_to_anchor=(1.01, 1))
    return to_png(figure)
