# SPDX-License-Identifier: Apache-2.0
"""Section of the report on things with names: their boxes on the map, and a table with the picture that shows each best."""

import numpy as np

from nightmap_eval import drawing, html
from nightmap_eval.floor_accuracy import read_floors
from nightmap_eval.grid import read_grid
from nightmap_eval.labels import label_drawing
from nightmap_eval.labels.thing_accuracy import MIN_IOU
from nightmap_eval.labels.thing_drawing import draw_things
from nightmap_eval.labels.thing_pictures import thumbnail
from nightmap_eval.labels.things import read_things
from nightmap_eval.labels.voxel_labels import read_voxel_labels

TITLE = "Things"
FLOOR_REACH_M = 0.5  # a thing stands on the highest floor that is at most so far above its bottom
OPACITY = 0.45  # of the classes below the boxes
MAX_PICTURES = 24


def sections(site, metrics):
    things = read_things(site)
    if things is None:
        return [html.section(TITLE, html.paragraph("The things stage did not run.", "note"))]
    if not things:
        return [html.section(TITLE, html.paragraph("No thing was found.", "note"))]
    said = [html.paragraph(f"Things that stand in the map: {len(things)}. Each box has a name; its front is the side with the thick "
                           "line and the arrow.")]  # fmt: skip
    floors, voxels = read_floors(site), read_voxel_labels(site)
    for floor in sorted(floors, key=lambda floor: abs(floor["number"])):
        standing = [thing for thing in things if floor_of(thing, floors) is floor]
        said.append(html.image(_floor_png(site, floor, voxels, standing), f"things on floor {floor['number']}"))
    return [html.section(TITLE, *said, *_table(site, things), *_accuracy(metrics))]


def floor_of(thing, floors):
    """The highest floor that is not above the thing; the lowest where all are."""
    bottom_m = thing.box.centre_m[2] - thing.box.half_size_m[2]
    below = [floor for floor in floors if floor["height_m"] <= bottom_m + FLOOR_REACH_M]
    return max(below, key=lambda floor: floor["height_m"]) if below else min(floors, key=lambda floor: floor["height_m"])


def _floor_png(site, floor, voxels, things):
    figure, axes = drawing.map_axes(f"Things on floor {floor['number']} ({len(things)})", (9.5, 7.5))
    axes.set_aspect("equal", adjustable="box")
    if voxels is not None:
        label_drawing.draw(axes, voxels, *label_drawing.floor_from_above(voxels, floor), OPACITY)
    elif site.made("grid", "yaml"):
        drawing.draw_grid(axes, read_grid(site.folder_of("grid") / floor["yaml"]))
    else:  # the boxes set the limits
        corners_m = np.concatenate([np.zeros((1, 2)), *(thing.box.corners_m() for thing in things)])
        axes.set_xlim(corners_m[:, 0].min() - 1, corners_m[:, 0].max() + 1)
        axes.set_ylim(corners_m[:, 1].min() - 1, corners_m[:, 1].max() + 1)
    draw_things(axes, things)
    return drawing.to_png(figure)


def _table(site, things):
    with_picture = set(np.linspace(0, len(things) - 1, min(MAX_PICTURES, len(things))).astype(int).tolist())
    if len(with_picture) < len(things):
        yield html.paragraph(f"{len(with_picture)} of the {len(things)} things, spread over the list, have a picture.", "note")
    rows = [(thing.name, thing.class_name, " x ".join(f"{2 * half_m:.2f}" for half_m in thing.box.half_size_m), thing.num_views,
             round(100 * thing.confidence), thumbnail(site, thing) if i in with_picture else "")
            for i, thing in enumerate(things)]  # fmt: skip
    yield html.table(("Name", "Class", "Depth x width x height (m)", "Views", "Confidence (%)", "Best view"), rows)


def _accuracy(metrics):
    found = metrics.get("sections", {}).get("things", {})
    if not found.get("has_truth"):
        return []
    rows = [
        ("True things that the map has voxels of", found.get("num_true")),
        (f"Those that the map found, with an intersection over union of {MIN_IOU} or more (%)", found.get("found_percent")),
        ("Median intersection over union, 0 where nothing was found", found.get("iou_median")),
        ("Things of the map that are no such true thing (%)", found.get("false_percent")),
        ("Things of the map that touch no true thing of their class (%)", found.get("nowhere_percent")),
        ("True things that were never seen", found.get("num_never_seen")),
    ]
    return [html.table(("Things against the made-up building", ""), [(title, "n/a" if value is None else value) for title, value in rows])]
