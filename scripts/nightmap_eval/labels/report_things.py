# SPDX-License-Identifier: Apache-2.0
"""Section of the report on things with names: their boxes on the map, and a table with the picture that shows each best."""

import numpy as np
from PIL import ImageDraw
from matplotlib.patches import Polygon
from matplotlib.patheffects import withStroke

from nightmap_eval import drawing, html
from nightmap_eval.drawing import RED
from nightmap_eval.floor_plan import floor_at
from nightmap_eval.grid import read_grid
from nightmap_eval.labels.report_labels import draw, floor_from_above
from nightmap_eval.labels.thing_accuracy import MIN_IOU
from nightmap_eval.things import read_things
from nightmap_eval.labels.voxel_labels import read_voxel_labels
from nightmap_eval.page.floor_map import Layer, area, label
from nightmap_eval.pictures import jpeg, open_picture
from nightmap_eval.walls_and_doors import read_floors

TITLE = "Things"
OPACITY = 0.45  # of the classes below the boxes
MAX_PICTURES = 24
FONT_PT, LINE_PT, LETTER_PT = 6, 7, 3.5
ARROW_M = 0.25
USED_PT = np.array([520, 420])  # of a figure, by the map
WIDTH_PX = 220
MARGIN = 0.25  # around the thing, of its longer side
COLOR = (178, 24, 43)


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


def layers(site, plan):
    layer = Layer("things")
    for thing in read_things(site) or []:
        floor = floor_of(thing, plan.floors)["number"]
        layer.add(floor, area([thing.box.corners_m()], "box", thing.name) + label(*thing.box.centre_m[:2], thing.name))
    return [layer]


def floor_of(thing, floors):
    return floor_at(floors, thing.box.centre_m[2] - thing.box.half_size_m[2])


def _floor_png(site, floor, voxels, things):
    figure, axes = drawing.map_axes(f"Things on floor {floor['number']} ({len(things)})", (9.5, 7.5))
    axes.set_aspect("equal", adjustable="box")
    if voxels is not None:
        draw(axes, voxels, *floor_from_above(voxels, floor), OPACITY)
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


def thumbnail(site, thing):
    """The part of its best view with the thing, framed."""
    def framed():
        if site.data is None or not thing.color_path:
            raise OSError("no file")
        with open_picture(site.data / thing.color_path) as picture:
            return cut_out(picture.convert("RGB"), thing.rectangle_px)

    return jpeg(framed, thing.color_path, "thumbnail")


def cut_out(picture, rectangle_px):
    """The rectangle with a margin and a frame around it, as far as the picture reaches, and no wider or higher than WIDTH_PX."""
    left, top, right, bottom = rectangle_px
    margin = round(MARGIN * max(right - left, bottom - top))
    outer = (max(0, left - margin), max(0, top - margin), min(picture.width, right + margin), min(picture.height, bottom + margin))
    if outer[0] >= outer[2] or outer[1] >= outer[3]:
        raise ValueError("the rectangle lies outside of the picture")
    picture = picture.copy()
    ImageDraw.Draw(picture).rectangle((left, top, right - 1, bottom - 1), outline=COLOR, width=max(1, (outer[2] - outer[0]) // 100))
    cut = picture.crop(outer)
    cut.thumbnail((WIDTH_PX, WIDTH_PX))
    return cut
