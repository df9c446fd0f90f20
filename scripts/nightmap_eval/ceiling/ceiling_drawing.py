# SPDX-License-Identifier: Apache-2.0
"""Pictures of a ceiling's map as PNG bytes: the map from above, errors over the route, NEES over time."""

import numpy as np
from matplotlib.collections import EllipseCollection, LineCollection

from nightmap_eval import drawing
from nightmap_eval.ceiling.ceiling_consistency import bounds, quantile
from nightmap_eval.drawing import BLUE, GRAY, GREEN, ORANGE, RED

ELLIPSE_PROBABILITY = 0.95
LEAST_NEES = 1e-3  # of the logarithmic axis


def map_png(ceiling_map, estimate_m, truth_m=None, wheels_m=None):
    """The map's frame from above. truth_m, wheels_m: positions in the map, or None."""
    shown = [ceiling_map.landmark_position_m, estimate_m, *(way_m for way_m in (truth_m, wheels_m) if way_m is not None)]
    width_m, height_m = np.ptp(np.concatenate([points_m[:, :2] for points_m in shown]), axis=0) + 1
    size = (9.5, np.clip(7 * height_m / width_m, 2.5, 8) + 1)
    figure, axes = drawing.map_axes("Landmarks with 95 % ellipses, and the robot's way (the dot is the start)", size)
    axes.set_aspect("equal", adjustable="box")
    draw_landmarks(figure, axes, ceiling_map)
    if wheels_m is not None:
        axes.plot(*wheels_m[:, :2].T, "--", color=GRAY, lw=1, label="wheels alone")
    axes.plot(*estimate_m[:, :2].T, color=BLUE, lw=1.4, label="estimate")
    if truth_m is not None:
        axes.plot(*truth_m[:, :2].T, color=ORANGE, lw=0.7, label="truth")
    axes.plot(*estimate_m[0, :2], "o", color=BLUE, ms=6)
    draw_loops(axes, ceiling_map)
    axes.autoscale_view()
    axes.grid(alpha=0.3)
    figure.legend(fontsize=9, loc="upper center", bbox_to_anchor=(0.5, 0.02), ncol=5)
    return drawing.to_png(figure)


def mosaic_png(pixels, corner_m, size_m, ceiling_map):
    """A picture of the ceiling at its place in the map, with the ellipses of the landmarks. corner_m: of its upper left corner."""
    size = (9.5, np.clip(7 * size_m[1] / size_m[0], 2.5, 8) + 1)
    figure, axes = drawing.map_axes("The ceiling, with 95 % ellipses of the landmarks", size)
    axes.set_aspect("equal", adjustable="box")
    axes.imshow(pixels, extent=(corner_m[0], corner_m[0] + size_m[0], corner_m[1] - size_m[1], corner_m[1]), origin="upper")
    draw_landmarks(figure, axes, ceiling_map)
    return drawing.to_png(figure)


def draw_landmarks(figure, axes, ceiling_map):
    points_m = ceiling_map.landmark_position_m
    if len(points_m) == 0:
        return
    values, vectors = np.linalg.eigh(ceiling_map.landmark_covariance_m2[:, :2, :2])
    full_axes_m = 2 * np.sqrt(np.maximum(values, 0) * quantile(ELLIPSE_PROBABILITY, 2))
    angles_deg = np.degrees(np.arctan2(vectors[:, 1, 1], vectors[:, 0, 1]))  # of the longer axis
    ellipses = EllipseCollection(full_axes_m[:, 1], full_axes_m[:, 0], angles_deg, units="xy", offsets=points_m[:, :2],
                                 offset_transform=axes.transData, facecolors="none", edgecolors="black", lw=0.5, alpha=0.7)  # fmt: skip
    axes.add_collection(ellipses)
    low_m, high_m = np.percentile(points_m[:, 2], [1, 99])  # a few wild heights must not use up the colors
    shown = axes.scatter(*points_m[:, :2].T, c=points_m[:, 2], s=4, lw=0, cmap="viridis", vmin=low_m, vmax=max(high_m, low_m + 0.01))
    figure.colorbar(shown, ax=axes, label="height (m)", shrink=0.8, extend="both")


def draw_loops(axes, ceiling_map):
    """Above the way, since most loops join places that are near."""
    axes.plot(*ceiling_map.anchor_pose[:, :2].T, "s", color=RED, ms=3, label=f"anchors ({len(ceiling_map.anchor_pose)})")
    loops = ceiling_map.loop_anchors
    if len(loops):
        lines = LineCollection(ceiling_map.anchor_pose[loops][:, :, :2], color=GREEN, lw=2, zorder=4, label=f"loops ({len(loops)})")
        axes.add_collection(lines)


def errors_png(frame_errors, travelled_m, errors):
    """Errors of what the filter said at each frame, with its own 2-sigma band, and of the final trajectory.

    travelled_m (n,), errors (n, 3): way and error of the final trajectory, in x, y (m) and heading (rad)."""
    figure, (above, below) = drawing.plt.subplots(2, 1, figsize=(8.5, 5), sharex=True)
    sigma_m = np.sqrt(np.linalg.eigvalsh(frame_errors.covariances[:, :2, :2])[:, 1])
    sigma_rad = np.sqrt(frame_errors.covariances[:, 2, 2])
    way_m = frame_errors.travelled_m
    above.fill_between(way_m, 0, 200 * sigma_m, color=BLUE, alpha=0.15, lw=0, label="2 sigma of the filter, worst direction")
    above.plot(way_m, 100 * np.linalg.norm(frame_errors.errors[:, :2], axis=1), color=BLUE, lw=1, label="at that frame")
    above.plot(travelled_m, 100 * np.linalg.norm(errors[:, :2], axis=1), color=ORANGE, lw=1, label="by all that is known")
    distances_m = np.linalg.norm(np.concatenate([frame_errors.errors, errors])[:, :2], axis=1)
    above.set_ylim(0, 100 * height_of_axis(distances_m, sigma_m))
    above.set_ylabel("position error (cm)")
    above.legend(fontsize=8, loc="upper left")
    below.fill_between(way_m, *np.degrees([-2 * sigma_rad, 2 * sigma_rad]), color=BLUE, alpha=0.15, lw=0)
    below.plot(way_m, np.degrees(frame_errors.errors[:, 2]), color=BLUE, lw=1)
    below.plot(travelled_m, np.degrees(errors[:, 2]), color=ORANGE, lw=1)
    limit_deg = np.degrees(height_of_axis(np.abs(np.concatenate([frame_errors.errors[:, 2], errors[:, 2]])), sigma_rad))
    below.set_ylim(-limit_deg, limit_deg)
    below.set_ylabel("heading error (deg)")
    below.set_xlabel("way (m)")
    for axes in (above, below):
        axes.grid(alpha=0.3)
    return drawing.to_png(figure)


def height_of_axis(errors, sigmas):
    """Shows all errors, and as much of the 2-sigma band as does not flatten them."""
    largest = max(np.max(errors, initial=0), 1e-9)
    return 1.2 * max(largest, min(2 * np.max(sigmas, initial=0), 3 * largest))


def nees_png(times_s, nees, degrees):
    """NEES of each frame, with the bounds that hold 95 % of the values of honest covariances."""
    figure, axes = drawing.line_axes((8.5, 2.6), "time (s)", "NEES")
    axes.axhspan(*bounds(degrees), color=GREEN, alpha=0.15, lw=0, label="95 % bounds")
    axes.plot(times_s, np.maximum(nees, LEAST_NEES), color=BLUE, lw=0.8)
    axes.set_yscale("log")
    axes.legend(fontsize=8, loc="lower right")
    return drawing.to_png(figure)
