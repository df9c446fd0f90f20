# SPDX-License-Identifier: Apache-2.0
"""Section of the report on the classes of voxels: the map in their colors, how large each is, and how many are right."""

import numpy as np
from matplotlib.patches import Patch

from nightmap_eval import drawing, html
from nightmap_eval.labels.label_accuracy import FURNITURE
from nightmap_eval.labels.voxel_labels import read_voxel_labels
from nightmap_eval.walls_and_doors import read_floors

TITLE = "What stands where"
CUTS_M = (0.5, 1.2)  # above the floor
CUT_THICKNESS_M = 0.2
NO_VOXEL = -1
BACKGROUND = (235, 235, 235)
MAX_SIDE_PX = 4000
BELOW_FLOOR_M, HEADROOM_M = 0.2, 2.2  # ceilings are above


def sections(site, metrics):
    voxels = read_voxel_labels(site)
    if voxels is None:
        return [html.section(TITLE, html.paragraph("The join_labels stage did not run.", "note"))]
    if len(voxels.keys) == 0:
        return [html.section(TITLE, html.paragraph("No voxel has a class: no keyframe with labels sees one.", "note"))]
    size_cm = 100 * voxels.resolution_m
    said = (f"{len(voxels.keys)} voxels of {size_cm:.3g} cm have a class: the one that the labels of the keyframes speak for most. "
            f"The picture shows the highest voxel of each place, up to {HEADROOM_M} m above the floor; the cuts show layers of "
            f"{CUT_THICKNESS_M} m.")  # fmt: skip
    images, parts = [], []
    for floor in sorted(read_floors(site), key=lambda floor: abs(floor["number"])):
        image, extent_m = floor_from_above(voxels, floor)
        images.append(image)
        parts.append(html.image(_above_png(voxels, floor, image, extent_m), f"classes of floor {floor['number']} from above"))
        parts.append(html.image(_cuts_png(voxels, floor, extent_m), f"cuts through floor {floor['number']}"))
    return [html.section(TITLE, html.paragraph(said), *parts, _sizes(voxels, images), *_accuracy(metrics))]


def _above_png(voxels, floor, image, extent_m):
    figure, axes = drawing.map_axes(f"Floor {floor['number']} from above")
    axes.set_aspect("equal", adjustable="box")
    draw(axes, voxels, image, extent_m)
    shown = legend_of(voxels, image)
    if shown:
        axes.legend(handles=shown, fontsize=9, loc="upper left", bbox_to_anchor=(1.01, 1))
    return drawing.to_png(figure)


def _cuts_png(voxels, floor, extent_m):
    """Thin layers of the map at two heights, each over the same part of it."""
    figure, panels = drawing.plt.subplots(1, len(CUTS_M), figsize=(9.5, 4.2))
    for axes, height_m in zip(panels, CUTS_M):
        middle_m = floor["height_m"] + height_m
        layer = from_above(voxels, middle_m - CUT_THICKNESS_M / 2, middle_m + CUT_THICKNESS_M / 2)
        draw(axes, voxels, *layer)
        axes.set_facecolor(np.array(BACKGROUND) / 255)
        axes.set_xlim(extent_m[:2])
        axes.set_ylim(extent_m[2:])
        axes.set_title(f"Floor {floor['number']}, cut at {height_m} m above it", fontsize=10)
        axes.set_xlabel("x (m)")
    panels[0].set_ylabel("y (m)")
    return drawing.to_png(figure)


def _sizes(voxels, images):
    num = len(voxels.names)
    num_voxels = np.bincount(voxels.labels, minlength=num)
    seen = sum(np.bincount(image[image != NO_VOXEL], minlength=num) for image in images)
    square = '<span style="display:inline-block;width:.9em;height:.9em;border:1px solid #888;background:{}"></span>'
    rows = [(html.Raw(square.format(voxels.colors[i])), voxels.names[i], int(num_voxels[i]), float(seen[i] * voxels.resolution_m**2))
            for i in np.flatnonzero(num_voxels)]  # fmt: skip
    return html.table(("", "Class", "Voxels", "Seen from above (m²)"), rows)


def _accuracy(metrics):
    found = metrics.get("sections", {}).get("join_labels", {})
    if not found.get("has_truth"):
        return []
    rows = [
        (f"Furniture ({', '.join(FURNITURE)}) with the right class (%)", found.get("furniture_right_percent")),
        ("The same where every class is right whose surface is in the voxel (%)", found.get("furniture_right_percent_with_borders")),
        ("The first without voxels that a surface of another class may cut (%)", found.get("furniture_right_percent_off_borders")),
        ("All voxels with the right class (%)", found.get("right_percent")),
        ("Voxels where the building has no surface (%)", found.get("nowhere_percent")),
    ]
    for name, of_class in found.get("classes", {}).items():
        rows.append((f"{of_class['num_voxels']} voxels of class {name}: right (%)", of_class["right_percent"]))
    return [html.table(("Voxels against the made-up building", ""), [(title, "n/a" if value is None else float(value)) for title, value in rows])]


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
