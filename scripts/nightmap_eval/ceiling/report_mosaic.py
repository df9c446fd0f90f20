# SPDX-License-Identifier: Apache-2.0
"""Section of the report with the picture of a whole ceiling, and how well its landmarks are known."""

import numpy as np
from PIL import Image

from nightmap_eval import html
from nightmap_eval.ceiling import ceiling_drawing
from nightmap_eval.ceiling.adjusted_ceiling import JOB as ADJUST
from nightmap_eval.ceiling.ceiling_accuracy import read_results
from nightmap_site.checked_reading import NUMBER, check, read_json

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
    path = site.needed("mosaic", "report")
    report = read_json(path)
    check(report, dict.fromkeys((key for key, _ in ROWS), NUMBER), str(path))
    _, ceiling_map = read_results(site, ADJUST)
    corner_m, resolution_m = placed_at(site.needed("mosaic", "pgw"))
    with Image.open(site.needed("mosaic", "png")) as picture:
        size_m = np.array(picture.size) * resolution_m
        picture.thumbnail((MAX_SHOWN_PX, MAX_SHOWN_PX))
        pixels = np.asarray(picture.convert("RGB"))
    shown = ceiling_drawing.mosaic_png(pixels, corner_m, size_m, ceiling_map)
    table = html.table(("Mosaic", ""), ([title, report[key]] for key, title in ROWS))
    return [html.section(TITLE, html.image(shown, "the whole ceiling, drawn like a map of the floor"), table)]


def placed_at(path):
    """((x, y) of the upper left corner in the map, edge of a pixel) of a world file."""
    values = [float(line) for line in path.read_text().split()]
    return np.array([values[4] - values[0] / 2, values[5] - values[3] / 2]), values[0]
