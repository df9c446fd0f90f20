# SPDX-License-Identifier: Apache-2.0
"""Sections of the report on the map that a site made of laser scans: its figures, and its objects."""

import json
from pathlib import Path

import numpy as np
import yaml

from nightmap_eval import drawing, html
from nightmap_eval.grid import read_grid
from nightmap_eval.laser.laser_accuracy import STRETCHES_M
from nightmap_eval.laser.wall_quality import doubled, thickness_cells, wall_cells
from nightmap_eval.metrics_json import LASER_STATISTICS, WALL_KEYS, laser_figures
from nightmap_eval.page.fields import Cells
from nightmap_eval.page.floor_map import Layer, area, cells_png
from nightmap_eval.report_map import ate_rows, building_rows
from nightmap_eval.trajectory import Similarity, interpolated, read_tum, rotation_matrices
from nightmap_eval.trajectory_errors import MAX_TRUTH_GAP_NS, TRUTH_REMEDY
from nightmap_eval.walls_and_doors import read_floors
from nightmap_site.checked_reading import check, read_text, read_toml, using
from nightmap_site.script_errors import DataError

LOOP_ROWS = (("num_accepted", "Loops accepted"), ("num_rejected", "Loops rejected"), ("num_false_accepted", "False loops accepted"))
WALL_ROWS = tuple(zip(WALL_KEYS, (
    "Thickness of walls, mean (cells)",
    "Thickness of walls, median (cells)",
    "Thickness of walls, 90 % (cells)",
    "Share of the wall cells with a second drawing of the wall beside (%)",
)))  # fmt: skip
RELATION_ROWS = (
    ("translation", "m", "Translation (m)"),
    ("translation_squared", "m2", "Squared translation (m2)"),
    ("rotation", "deg", "Rotation (deg)"),
    ("rotation_squared", "deg2", "Squared rotation (deg2)"),
)
DEFAULT_MAX_SIZE_M = 4.0  # of max_object_size_m
PARTS = ("objects_file.js", "objects_map.js", "objects_editor.js", "objects_mouse.js")
START = 'new ObjectsEditor(document.getElementById("objects-editor"), JSON.parse(document.getElementById("objects-data").textContent));'
PLACE_M, MIN_WALL_M = 0.5, 0.3  # edge of a place, and length of the wall in it from which on it is judged
OBJECT_KEYS = ("x_m", "y_m", "size_x_m", "size_y_m", "angle_deg")
SIGNS = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])


def sections(site, metrics):
    figures = laser_figures(metrics)
    made = (figures_section(figures), error_section(site, figures), objects_section(site))
    return [section for section in made if section]


def fields(site, plan):
    """Quality of the walls of each floor's grid by place: thickness, and how much is drawn twice."""
    for floor, grid in plan.grids.items():
        walls = wall_cells(grid)
        if len(walls.cells) == 0:
            continue
        rows, columns = (walls.cells + 0.5).T
        cells = Cells(grid.from_cells(columns, rows), PLACE_M)
        counts = cells.sums(np.ones(len(walls.cells)))
        is_wall = counts * grid.resolution_m >= MIN_WALL_M
        twice = 100 * cells.sums(doubled(grid, walls).astype(float)) / np.maximum(counts, 1)
        thickness_cm = 100 * grid.resolution_m * cells.median(thickness_cells(grid, walls))
        yield cells.field("thickness of walls", floor, np.where(is_wall, thickness_cm, np.nan), 0, 30, "cm", "inferno")
        yield cells.field("walls drawn twice", floor, np.where(is_wall, twice, np.nan), 0, 100, "%", "inferno")


def layers(site, plan):
    """Objects in use, else those that the job `objects` proposes; none of a file that cannot be read, of which the section tells."""
    layer = Layer("objects")
    for _, path in sources(site)[:1]:
        try:
            boxes = objects_of(path)
        except (DataError, OSError):
            continue
        for name, corners_m in boxes:
            layer.add(0, area([corners_m], "box", name))
    return [layer]


def objects_of(path):
    """(name, corners (4, 2) in metres) of each object of a file."""
    with using(path, "correct it, or name another file"):
        try:
            items = yaml.load(read_text(path), yaml.BaseLoader)["objects"]
        except yaml.YAMLError as error:
            raise ValueError(" ".join(str(error).split())) from None
        return [(item["name"], _corners_m(**{key: float(item[key]) for key in OBJECT_KEYS})) for item in items]


def _corners_m(x_m, y_m, size_x_m, size_y_m, angle_deg):
    half, angle = np.array([size_x_m, size_y_m]) / 2, np.radians(angle_deg)
    axes = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    return np.array([x_m, y_m]) + (SIGNS * half) @ axes


def figures_section(figures):
    """Tables of the figures; None where they were not measured."""
    if not figures:
        return None
    parts = [html.table(("", ""), _count_rows(figures))]
    if "trajectory" in figures:
        trajectory = figures["trajectory"]
        head = ("Position", "RMSE (cm)", "median (cm)", "largest (cm)", "rotation RMSE (deg)", "usual RMSE")
        parts.append(html.table(head, ate_rows(trajectory, figures["path_length_m"])))
        head = ("Motion over", *(f"{name} (cm)" for name in ("mean", "median", "90 %")),
                *(f"{name} (deg)" for name in ("mean", "median", "90 %")), "stretches", "missing")  # fmt: skip
        parts.append(html.table(head, _stretch_rows(trajectory)))
    else:
        parts.append(html.paragraph("The robot's true way is not known: the accuracy of the poses is unknown.", "note"))
    if "relations" in figures:
        parts += _relation_parts(figures["relations"])
    if figures.get("map"):
        parts.append(html.table(("Against the exact building", ""), building_rows(figures["map"])))
    return html.section("Accuracy of the laser map", *parts)


def _count_rows(figures):
    yield ["Scans with a pose", figures["num_scans_with_pose"]]
    yield ["Scans", figures["num_scans"]]
    if "num_keyscans" in figures:
        yield ["Keyscans", figures["num_keyscans"]]
    yield ["Path (m)", float(figures["path_length_m"])]
    if "trajectory" in figures:
        yield ["Scans with a true pose", figures["trajectory"]["num_scans_with_truth"]]
        yield ["Share of them that has no estimate (%)", float(figures["trajectory"]["missing_percent"])]
    for key, title in LOOP_ROWS:
        if key in figures.get("loops", {}):
            yield [title, figures["loops"][key]]
    for key, title in WALL_ROWS:
        if figures.get("walls", {}).get(key) is not None:
            yield [title, float(figures["walls"][key])]


def _stretch_rows(trajectory):
    for metres in STRETCHES_M:
        values = trajectory[f"relative_{metres}m"]
        if values["num_pairs"]:
            moved_cm = [100 * values[f"translation_{kind}_m"] for kind in LASER_STATISTICS]
            turned_deg = [values[f"rotation_{kind}_deg"] for kind in LASER_STATISTICS]
            yield [f"{metres} m", *moved_cm, *turned_deg, values["num_pairs"], values["num_missing"]]


def _relation_parts(relations):
    counts = f"{relations['num_relations']} relations; of {relations['num_missing']} the map has not both poses."
    parts = [html.paragraph(counts, "failed" if relations["num_missing"] else "note")]
    rows = [[title, relations[f"{name}_mean_{unit}"], html.number(relations[f"{name}_std_{unit}"])]
            for name, unit, title in RELATION_ROWS if f"{name}_mean_{unit}" in relations]  # fmt: skip
    return [*parts, html.table(("Errors of relations", "mean", "standard deviation"), rows)] if rows else parts


def error_section(site, figures):
    """Position error over time where there is truth, else None."""
    path = site.made("map_frame", "trajectory")
    if "trajectory" not in figures or not path or not site.robot_truth.exists():
        return None
    values = np.array(figures["trajectory"]["truth_from_map_m_q"])
    truth_from_map = Similarity(1.0, rotation_matrices(values[None, 3:])[0], values[:3])
    estimate = read_tum(path)
    rows, truth = interpolated(read_tum(site.robot_truth, TRUTH_REMEDY), estimate.times_ns, MAX_TRUTH_GAP_NS)
    errors_m = np.linalg.norm(truth_from_map.apply(estimate.positions_m[rows]) - truth.positions_m, axis=1)
    picture = drawing.error_png((truth.times_ns - truth.times_ns[:1]) / 1e9, "time (s)", errors_m)
    return html.section("Position error", html.image(picture, "position error over time"))


def objects_section(site):
    """The editor of objects, over the grid; None without a grid. The page reads and writes objects.yaml (objects_file.js): it gets the text of
    a site's file."""
    if not site.made("grid", "yaml"):
        return None
    files, problems = [], []
    for title, path in sources(site):
        try:
            files.append({"title": title, "name": path.name, "text": read_text(path, "correct it, or name another file")})
        except (DataError, OSError) as error:
            problems.append(html.paragraph(str(error), "failed"))
    grid = read_grid(site.folder_of("grid") / read_floors(site)[0]["yaml"])
    command = f"make use-objects SITE={site.name} OBJECTS=~/Downloads/objects.yaml"
    said = ("Objects are rectangles on places that never change, by which a robot finds where it is. Drag on the map to draw one; "
            "drag it, its corners or the handle beside it to change it. The wheel zooms, the right button moves the map. "
            "Download objects.yaml when they are right, and give it to the next make by "
            f"<code>{html.escape(command)}</code>. A click on the map tells a place for make localize.")  # fmt: skip
    return html.section("Objects", html.paragraph(html.Raw(said)), *problems, html.Raw(editor_html(grid, files, max_size_m(site))))


def max_size_m(site):
    """Length of a side at most, as `localize` cuts it."""
    config = site.config / "scan_localize.toml"
    if not config.exists():
        return DEFAULT_MAX_SIZE_M
    values = read_toml(config)
    check(values, {"?max_object_size_m": float}, str(config))
    return values.get("max_object_size_m", DEFAULT_MAX_SIZE_M)


def sources(site):
    """(title, file) of the site's objects: those in use, then those that the job `objects` proposes. The page opens the first."""
    named = (("Open the objects in use", file_in_use(site)), ("Open the proposed objects", site.made("objects", "objects")))
    return [(title, path) for title, path in named if path is not None]


def file_in_use(site):
    """The file that [import] of the site's config names as objects; None where there is none."""
    config = site.config / "site" / f"{site.name}.toml"
    if site.data is None or not config.exists():
        return None
    tables = read_toml(config)
    check(tables, {"?import": {"?objects": str}}, str(config))
    name = tables.get("import", {}).get("objects")
    return site.data / name if name and (site.data / name).is_file() else None


def editor_html(grid, files, longest_m):
    """HTML of the editor with its script. files: title, name and text of each file that can be opened; the first is. longest_m: of a
    side."""
    rows, columns = grid.cells.shape
    shown = {"png": html.data_uri(cells_png(grid.cells)), "rows": rows, "columns": columns,
             "resolution_m": grid.resolution_m, "origin_x_m": grid.origin_x_m, "origin_y_m": grid.origin_y_m,
             "origin_yaw_rad": grid.origin_yaw_rad}  # fmt: skip
    # No name can end it: the browser looks for tags in it before it reads it.
    in_script = json.dumps({"max_size_m": longest_m, "grid": shown, "files": files}).replace("<", "\\u003c")
    folder = Path(__file__).parent
    script = "\n".join([(folder / name).read_text(encoding="utf-8") for name in PARTS] + [START])
    return ((folder / "objects_editor.html").read_text(encoding="utf-8")
            + f'<script type="application/json" id="objects-data">{in_script}</script>\n'
            + f"<script>(() => {{\n{script}\n}})();</script>")  # fmt: skip
