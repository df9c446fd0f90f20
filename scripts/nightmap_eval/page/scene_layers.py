# SPDX-License-Identifier: Apache-2.0
"""Layers of the 3-D view of the report, each a dictionary for JSON (scene_start.js lists the kinds); and the texts that hold large ones."""

import base64
import io
import re

import numpy as np
from PIL import Image

from nightmap_eval.artifacts import read_hdf5
from nightmap_eval.grid import FREE, OCCUPIED, UNKNOWN, read_grid
from nightmap_eval.page.scene_cloud import COLORS, NO_FACING, class_cloud, color_cloud, encoded, hashes, pack
from nightmap_eval.pictures import picture_camera
from nightmap_eval.query_errors import read_located
from nightmap_eval.shown_queries import choose, query_rows, thumbnail
from nightmap_eval.things import read_things
from nightmap_eval.trajectory import MAX_POSITION_M, read_tum
from nightmap_eval.walls_and_doors import read_floors
from nightmap_eval.ways import loop_ends
from nightmap_site.checked_reading import NUMBER, REMEDY, read_csv, read_object, using
from nightmap_site.script_errors import DataError

MAX_OUTLINE, MAX_WAY, MAX_VIEWS, MAX_LOOPS, MAX_THINGS, MAX_QUERIES = 100, 20_000, 1000, 3000, 2000, 24
MAX_GRID_PX, MAX_FLOORS, MAX_LANDMARKS = 2048, 16, 50_000
MAX_OCTREE_BYTES = 100_000_000
MAX_OCTREE_TEXT, MAX_GRID_TEXT = 8_000_000, 400_000  # characters
LANDMARK_M = 0.05  # in size
EYE_M = 1.0  # height of the view above the place of a robot that has no camera
RGBA = {UNKNOWN: (0, 0, 0, 0), FREE: (214, 219, 226, 255), OCCUPIED: (58, 64, 74, 255)}
HEIGHT_COLORS = np.array([[63, 81, 181], [0, 150, 136], [253, 216, 53]])  # low, middle, high
HEX_COLOR = re.compile(r"#[0-9a-f]{6}")
LEGEND = {"classes": [{"label": int, "name": str, "color": str}]}
CAMERAS = {"cameras": [{"color": {"width": int, "height": int, "fx": NUMBER, "fy": NUMBER}}]}


def rounded(values, digits=4):
    return np.round(np.asarray(values, float), digits).ravel().tolist()


def evenly(count, most):
    """Rows of at most `most` of `count`, spread evenly, the first and the last among them."""
    return np.arange(count) if count <= most else np.unique(np.linspace(0, count - 1, most).astype(int))


def view_of(trajectory, row, is_camera):
    """Place of the eye and direction of view, six numbers. A camera looks along z, a robot along x."""
    rotation, eye_m = trajectory.select([row]).rotations()[0], trajectory.positions_m[row]
    return rounded([*eye_m, *rotation[:, 2]] if is_camera else [*eye_m[:2], eye_m[2] + EYE_M, *rotation[:, 0]])


def views(site, way):
    """Those of the keyframes, in their order."""
    path = site.made("map_frame", "keyframes")
    poses = read_tum(path) if path else way
    return [view_of(poses, row, site.has_camera()) for row in evenly(len(poses), MAX_VIEWS)]


def cloud_layers(site, texts):
    path, labelled, legend = site.made("join_clouds", "cloud"), site.made("join_labels", "cloud"), site.made("join_labels", "legend")
    if path:
        yield from _cloud(texts, "colors", "Cloud", color_cloud(path), on=True)
    if labelled and legend:
        classes = _classes(legend)
        packed = class_cloud(labelled, {entry["label"]: i for i, entry in enumerate(classes)})
        shown = [{"name": entry["name"], "color": entry["color"]} for entry in classes]
        yield from _cloud(texts, "labels", "Cloud by label", packed, classes=shown, on=False)


def _cloud(texts, name, title, packed, **more):
    if packed is not None:
        texts[f"scene-{name}"] = packed.text
        yield {"name": name, "title": title, "kind": "cloud", "text": f"scene-{name}", "cloud": packed.head(), "outline": packed.outline_m, **more}


def _classes(path):
    classes = [entry for entry in read_object(path, LEGEND)["classes"] if entry.get("num_voxels", 1)]
    if not all(HEX_COLOR.fullmatch(entry["color"]) for entry in classes):
        raise DataError(f"{path}: a color is not #rrggbb; {REMEDY}")
    return classes[:255]


def landmark_layers(site, texts):
    """Landmarks of a ceiling, in colors of their heights."""
    path = next(filter(None, (site.made(job, "map") for job in ("adjust", "odometry"))), None)
    if not path:
        return
    [points_m] = read_hdf5(path, "landmark_position_m")
    with using(path):
        points_m = np.asarray(points_m, float).reshape(-1, 3)
        if not np.all(np.abs(points_m) <= MAX_POSITION_M):
            raise ValueError("a landmark out of range")
    if len(points_m) == 0:
        return
    points_m = points_m[evenly(len(points_m), MAX_LANDMARKS)]
    low_m, high_m = np.percentile(points_m[:, 2], [1, 99])
    share = np.clip((points_m[:, 2] - low_m) / max(high_m - low_m, 0.01), 0, 1)
    colors = np.stack([np.interp(share, [0, 0.5, 1], column) for column in HEIGHT_COLORS.T], axis=1)
    values, order = np.column_stack([np.rint(colors), np.full(len(points_m), NO_FACING)]), hashes(np.arange(len(points_m)))
    packed = pack(points_m, values, order, (*COLORS, "facing"), len(points_m))
    packed.spacing_m = LANDMARK_M
    yield from _cloud(texts, "landmarks", "Landmarks", packed, least_px=4, on=True)


def octree_layers(site, texts):
    """The occupied leaves; too large for a page, it has a sentence instead."""
    path = site.made("join_octrees", "bt")
    if not path:
        return
    text = encoded(path.read_bytes()) if path.stat().st_size <= MAX_OCTREE_BYTES else None
    if text is None or len(text) > MAX_OCTREE_TEXT:
        yield {"name": "octree", "title": f"Octree: too large for this page ({path.stat().st_size / 1e6:.0f} MB); open octree/map.bt in octovis",
               "kind": "absent", "on": False}  # fmt: skip
        return
    texts["scene-octree"] = text
    yield {"name": "octree", "title": "Octree", "kind": "octree", "text": "scene-octree", "on": False}


def way_layers(site, way):
    if way is None or len(way) == 0:
        return
    yield {"name": "trajectory", "title": "Trajectory", "kind": "way", "on": True, "points": rounded(way.positions_m[evenly(len(way), MAX_WAY)])}
    for name, ends in zip(("accepted", "rejected"), loop_ends(site, way)):
        if ends:
            shown = [rounded(ends[i]) for i in evenly(len(ends), MAX_LOOPS)]
            yield {"name": f"loops_{name}", "title": f"Loops {name} ({len(ends)})", "kind": "loops", "on": name == "accepted", "segments": shown}


def thing_layers(site):
    things = read_things(site)
    if things:
        shown = [{"name": thing.name, "centre": rounded(thing.box.centre_m), "half": rounded(thing.box.half_size_m),
                  "heading": round(thing.box.heading_rad, 5)} for thing in (things[i] for i in evenly(len(things), MAX_THINGS))]  # fmt: skip
        yield {"name": "things", "title": f"Things ({len(things)})", "kind": "things", "on": True, "things": shown}


def query_layers(site, metrics, data):
    """Located pictures, chosen as by the section on queries, at the rays of their camera; or located scans."""
    path = site.made("localize", "queries")
    if not path:
        return
    rows, times_ns, located = read_located(path)
    row_of_time = {int(time_ns): i for i, time_ns in enumerate(located.times_ns)}
    poses = {int(row["query_idx"]): row_of_time.get(int(time_ns)) for row, time_ns in zip(rows, times_ns)}
    candidates = choose([row for row in query_rows(site, metrics) if row["status"] == "located"], MAX_QUERIES)
    chosen = [(row, pose) for row in candidates if (pose := poses.get(row["query_idx"])) is not None]
    if not chosen:
        return
    if site.pipeline.asks == "scans":
        shown = [{"name": row["color_path"], "view": view_of(located, pose, is_camera=False)} for row, pose in chosen]
        yield {"name": "queries", "title": "Located scans", "kind": "scans", "on": True, "scans": shown}
        return
    slopes = _slopes(site)
    shown = [{"name": row["color_path"], "place": rounded(located.positions_m[pose]), "picture": _source(thumbnail(data, row["color_path"])),
              "axes": rounded(located.select([pose]).rotations()[0].T), "slopes": slopes.get(row["color_path"], [0.6, 0.45])}
             for row, pose in chosen]  # fmt: skip
    yield {"name": "queries", "title": "Located pictures", "kind": "pictures", "on": True, "pictures": shown}


def _source(image):
    """The address of an image of the page; none of a note."""
    found = re.search(r'src="(data:image/jpeg;base64,[^"]*)"', image)
    return found[1] if found else ""


def _slopes(site):
    """color_path -> x and y per z at the right and lower edge of the picture, without distortion."""
    rows, cameras = site.made("queries", "queries"), site.made("queries", "query_cameras")
    if not (rows and cameras):
        return {}
    listed = read_object(cameras, CAMERAS)["cameras"]
    with using(cameras):
        found = [picture_camera(camera) for camera in listed]
        of_camera = [rounded([camera["width"] / 2 / camera["fx"], camera["height"] / 2 / camera["fy"]]) for camera in found]
    with using(rows):
        return {row["color_path"]: of_camera[int(row["camera_idx"])] for row in read_csv(rows, ("color_path", "camera_idx"))}


def grid_layers(site, has_cloud):
    if not site.made("grid", "yaml"):
        return
    planes = []
    for floor in read_floors(site)[:MAX_FLOORS]:
        grid = read_grid(site.folder_of("grid") / floor["yaml"])
        picture, sides = grid_picture(grid.cells)
        planes.append({"corner": rounded([grid.origin_x_m, grid.origin_y_m, floor["height_m"]]), "yaw": round(grid.origin_yaw_rad, 6),
                       "size": rounded(np.array(sides[::-1]) * grid.resolution_m), "picture": picture,
                       "outline": _seen_places(grid)})  # fmt: skip
    yield {"name": "grid", "title": "Grid of the floor" if len(planes) == 1 else f"Grids of {len(planes)} floors", "kind": "grids",
           "on": not has_cloud, "planes": planes}  # fmt: skip


def _seen_places(grid):
    """Places (n, 2) of some of the cells that are not unknown: of the outermost of each of some rows."""
    seen = grid.cells != UNKNOWN
    rows = np.flatnonzero(seen.any(axis=1))
    rows = rows[evenly(len(rows), MAX_OUTLINE)]
    columns = np.concatenate([seen[rows].argmax(axis=1), seen.shape[1] - 1 - seen[rows, ::-1].argmax(axis=1)])
    return grid.from_cells(columns + 0.5, np.concatenate([rows, rows]) + 0.5)


def grid_picture(cells):
    """A picture with a pixel per cell, or per square of a large grid, of which the highest state counts, the top row first, unknown clear; and
    the rows and columns of cells that it covers."""
    step = -(-max(cells.shape) // MAX_GRID_PX)
    while len(text := _png(states := _coarse(cells, step))) > MAX_GRID_TEXT:
        step *= 2
    return "data:image/png;base64," + text, tuple(step * side for side in states.shape)


def _coarse(cells, step):
    padded = np.pad(cells, [(0, -side % step) for side in cells.shape])
    rows, columns = padded.shape
    return padded.reshape(rows // step, step, columns // step, step).max(axis=(1, 3))[::-1]


def _png(states):
    palette, buffer = np.array([RGBA[state] for state in sorted(RGBA)], np.uint8), io.BytesIO()
    Image.fromarray(palette[states], "RGBA").save(buffer, "PNG", optimize=True)
    return base64.b64encode(buffer.getvalue()).decode()
