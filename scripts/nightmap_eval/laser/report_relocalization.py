# SPDX-License-Identifier: Apache-2.0
"""Section of the report on robots that are located by a scan: the map with every query, its truth and its verdict."""

import numpy as np

from nightmap_eval import drawing, html
from nightmap_eval.grid import read_grid
from nightmap_eval.laser.scan_relocalization import THRESHOLDS, read_scans

COLORS = {"located": drawing.GREEN, "ambiguous": drawing.ORANGE, "not_in_map": drawing.RED, "no_features": drawing.RED}
TITLE = "Where is this scan?"
WRONG_M = 0.5


def sections(site, metrics):
    queries, truth = site.made("test_localize", "queries"), site.made("test_scans", "truth")
    if not (queries and truth):
        return []
    scans = read_scans(queries, truth)
    if not scans.rows:
        return [html.section(TITLE, html.paragraph("The way is too short, or leads nowhere twice: no scan was asked for.", "note"))]
    measured = metrics.get("sections", {}).get("test_localize", {})
    parts = [html.paragraph("Stretches of the way were kept out of a map, and their scans looked for in the whole of it.", "note")]
    if measured.get("num_queries"):
        parts.append(html.table(("", ""), rows_of(measured)))
    return [html.section(TITLE, *parts, html.image(picture(site, scans), "map with the scans that were located"))]


def rows_of(figures):
    yield ["Scans", figures["num_queries"]]
    for verdict, count in figures["num_by_verdict"].items():
        if count:
            yield [verdict.replace("_", " "), count]
    for max_cm, max_deg in THRESHOLDS:
        yield [f"Within {max_cm} cm and {max_deg} deg (%)", html.number(figures[f"within_{max_cm}cm_{max_deg}deg_percent"])]
    yield [f"Located with an error above {100 * WRONG_M:.0f} cm", figures["num_wrong"]]
    for key, title in (("median", "Median"), ("p90", "90 %")):
        for name, unit in (("translation", "cm"), ("rotation", "deg")):
            yield [f"{title} error ({unit}); a failure counts as infinite", html.number(figures[f"{key}_{name}_error_{unit}"])]
    for name in ("translation", "rotation"):
        if f"p90_{name}_error_per_sigma" in figures:
            yield [f"90 % of the errors of {name} are within (sigma)", html.number(figures[f"p90_{name}_error_per_sigma"])]
    if "num_objects" in figures:
        yield ["Objects of the map", figures["num_objects"]]
    if figures.get("num_queries_near_objects"):  # of the method `published` alone
        yield ["Scans with an object near their rough position", figures["num_queries_near_objects"]]
        yield ["Poses at which an object is where the map has it", figures["num_object_poses"]]
        yield ["Scans of which objects removed a place", figures["num_queries_filtered_by_objects"]]


def picture(site, scans):
    """The test map; a dot at the truth of each query in the color of its verdict, a line to where a wrong one was put."""
    figure, axes = drawing.map_axes("Scans that were looked for, at their true places")
    if site.made("test_grid", "yaml"):
        drawing.draw_grid(axes, read_grid(site.path("test_grid", "yaml")))
    verdicts = np.array([row["status"] for row in scans.rows])
    for verdict, color in COLORS.items():
        places_m = scans.truth.positions_m[verdicts == verdict]
        if len(places_m):
            axes.plot(places_m[:, 0], places_m[:, 1], ".", color=color, ms=4, label=f"{verdict.replace('_', ' ')} ({len(places_m)})")
    for i in scans.located[scans.translation_m > WRONG_M]:
        ends_m = np.array([scans.truth.positions_m[i, :2], [float(scans.rows[i][name]) for name in ("tx_m", "ty_m")]])
        axes.plot(ends_m[:, 0], ends_m[:, 1], color=drawing.RED, lw=1)
    axes.legend(fontsize=9, loc="upper left", bbox_to_anchor=(1.01, 1))
    return drawing.to_png(figure)
