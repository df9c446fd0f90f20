# SPDX-License-Identifier: Apache-2.0
"""Pictures of the report and the README as PNG bytes; equal input gives equal bytes."""

import io

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402
from matplotlib.colors import ListedColormap  # noqa: E402
from matplotlib.transforms import Affine2D  # noqa: E402

from nightmap_eval.grid import FREE, OCCUPIED  # noqa: E402

BLUE, ORANGE, GREEN, RED, GRAY = "#2166ac", "#e08214", "#1b7837", "#b2182b", "#888888"


def to_png(figure, dpi=110):
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=dpi, bbox_inches="tight", metadata={"Software": None})
    plt.close(figure)
    return buffer.getvalue()


def map_axes(title, size=(7.5, 6.0)):
    figure, axes = plt.subplots(figsize=size)
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_xlabel("x (m)")
    axes.set_ylabel("y (m)")
    axes.set_title(title, fontsize=11)
    return figure, axes


def line_axes(size, x, y):
    figure, axes = plt.subplots(figsize=size)
    axes.set_xlabel(x)
    axes.set_ylabel(y)
    axes.grid(alpha=0.3)
    return figure, axes


def draw_trajectory(axes, estimate_m, loops_m=()):
    """Top view. loops_m: pairs of positions of accepted loop closures."""
    for i, (start, end) in enumerate(loops_m):
        label = f"loops ({len(loops_m)})" if i == 0 else None
        axes.plot(*np.transpose([start[:2], end[:2]]), color=GREEN, lw=0.8, alpha=0.6, label=label)
    axes.plot(estimate_m[:, 0], estimate_m[:, 1], color=BLUE, lw=1.2, label="estimate")
    axes.plot(*estimate_m[0, :2], "o", color=BLUE, ms=6)


def error_png(x, x_name, errors_m, title=""):
    """Error of each pose after the alignment."""
    figure, axes = line_axes((7.5, 2.4), x_name, "error (cm)")
    axes.plot(x, 100 * np.asarray(errors_m), color=BLUE, lw=1)
    axes.set_ylim(bottom=0)
    axes.set_title(title, fontsize=11)
    return to_png(figure)


def draw_grid(axes, grid):
    """Free cells white, occupied black, others gray; cropped to the seen cells."""
    axes.set_aspect("equal", adjustable="box")
    colors = ListedColormap(["#c8c8c8", "#ffffff", "#202020"])
    image = axes.imshow(grid.cells, cmap=colors, vmin=0, vmax=2, origin="lower", extent=grid.extent_m(),
                        interpolation="nearest")  # fmt: skip
    if grid.origin_yaw_rad != 0:
        turn = Affine2D().rotate_around(grid.origin_x_m, grid.origin_y_m, grid.origin_yaw_rad)
        image.set_transform(turn + axes.transData)
    rows, columns = np.nonzero((grid.cells == FREE) | (grid.cells == OCCUPIED))
    if len(rows):
        margin = 5
        columns = np.array([columns.min() - margin, columns.max() + margin])
        rows = np.array([rows.min() - margin, rows.max() + margin])
        corners = grid.from_cells(*np.meshgrid(columns, rows)).reshape(-1, 2)
        axes.set_xlim(corners[:, 0].min(), corners[:, 0].max())
        axes.set_ylim(corners[:, 1].min(), corners[:, 1].max())


def draw_path(axes, path_m):
    axes.plot(path_m[:, 0], path_m[:, 1], color=RED, lw=2, label="path")
    axes.plot(*path_m[0, :2], "o", color=GREEN, ms=8, label="start")
    axes.plot(*path_m[-1, :2], "*", color=RED, ms=13, label="goal")
