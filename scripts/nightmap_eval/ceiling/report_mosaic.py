# SPDX-License-Identifier: Apache-2.0
"""Section of the report with the picture of a whole ceiling, and how well its landmarks are known."""

import io

import numpy as np
from PIL import Image

from nightmap_eval import html
from nightmap_eval.ceiling import ceiling_drawing
from nightmap_eval.ceiling.adjusted_ceiling import JOB as ADJUST
from nightmap_eval.ceiling.ceiling_accuracy import read_results
from nightmap_eval.page.floor_map import Layer, raster
from nightmap_site.checked_reading import NUMBER, read_object

TITLE = "Picture of the ceiling"
ROWS = (
    ("num_views", "Pictures that it is made of"),
    ("covered_m2", "Ceiling seen (m2)"),
    ("median_deviation", "Deviation of brightness between pictures, median (of 255)"),
)
MAX_SHOWN_PX = 2000
Image.MAX_IMAGE_PIXELS = None  # the mosaic of a large building is no attack


def sections(site, metrics):
    if not (site.made("mosaic", "png") and site.made("mosaic", "report")):
        return [html.section(TITLE, html.paragraph("The mosaic stage did not run.", "note"))]
    report = read_object(site.needed("mosaic", "report"), dict.fromkeys((key for key, _ in ROWS), NUMBER))
    _, ceiling_map = read_results(site, ADJUST)
    picture, corner_m, size_m = read_mosaic(site)
    pixels = np.asarray(picture)
    shown = ceiling_drawing.mosaic_png(pixels, corner_m, size_m, ceiling_map)
    table = html.table(("Mosaic", ""), ([title, report[key]] for key, title in ROWS))
    return [html.section(TITLE, html.image(shown, "the whole ceiling, drawn like a map of the floor"), table)]


def read_mosaic(site):
    """(picture at the size that is shown, its upper left corner, its width and height) in metres of the map."""
    world = [float(line) for line in site.needed("mosaic", "pgw").read_text().split()]  # its fifth and sixth: the middle of a pixel
    corner_m, resolution_m = np.array([world[4] - world[0] / 2, world[5] - world[3] / 2]), world[0]
    with Image.open(site.needed("mosaic", "png")) as picture:
        size_m = np.array(picture.size) * resolution_m
        picture.thumbnail((MAX_SHOWN_PX, MAX_SHOWN_PX))
        return picture.convert("RGB"), corner_m, size_m


def layers(site, plan):
    layer = Layer("ceiling")
    if site.made("mosaic", "png"):
        picture, corner_m, size_m = read_mosaic(site)
        buffer = io.BytesIO()
        picture.save(buffer, "JPEG", quality=80)
        lower_left_m = corner_m - [0, size_m[1]]
        plan.reach(0, np.array([lower_left_m, lower_left_m + size_m]))
        layer.add(0, raster(buffer.getvalue(), size_m, lower_left_m, media_type="image/jpeg"))
    return [layer]
