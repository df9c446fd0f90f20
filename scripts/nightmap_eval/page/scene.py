# SPDX-License-Identifier: Apache-2.0
"""Section of the report that shows the map in space: clouds, octree, trajectory, loops, things, queries, grids.

The section holds all that it needs, three.js too, and is read by scene*.js in classic scripts: a page that is opened from a disk may load
neither modules nor files."""

import json
from pathlib import Path

import numpy as np

from nightmap_eval import html
from nightmap_eval.page import scene_layers
from nightmap_eval.ways import way_of
from nightmap_site.checked_reading import read_text

TITLE = "The map in space"
THREE = Path("/usr/share/javascript/three")  # of the package libjs-three
LIBRARIES = ("three.min.js", "examples/js/controls/OrbitControls.js")
PARTS = ("scene_data.js", "scene_points.js", "scene_octree.js", "scene_lines.js", "scene_shapes.js", "scene_names.js", "scene_camera.js",
         "scene_measure.js", "scene_view.js", "scene_start.js")  # fmt: skip
MARGIN_M = 0.5


def scene_section(site, metrics, data):
    """None when the site has nothing to show in space. data: folder of the recordings, for the pictures of queries, or None."""
    texts = {}
    way = way_of(site)
    clouds = list(scene_layers.cloud_layers(site, texts))
    layers = [
        *clouds,
        *scene_layers.octree_layers(site, texts),
        *scene_layers.landmark_layers(site, texts),
        *scene_layers.grid_layers(site, bool(clouds)),
        *scene_layers.way_layers(site, way),
        *scene_layers.thing_layers(site),
        *scene_layers.query_layers(site, metrics, data),
    ]
    if all(layer["kind"] == "absent" for layer in layers):
        return None
    missing = [name for name in LIBRARIES if not (THREE / name).is_file()]
    if missing:
        said = f"The view needs {THREE / missing[0]} of the package libjs-three: run make deps, then make report again."
        return html.section(TITLE, html.paragraph(said, "failed"))
    views = [] if way is None else scene_layers.views(site, way)
    outline = outline_m(layers)
    scene = {"site": site.name, "layers": layers, "views": views, "outline": scene_layers.rounded(outline, 2),
             "bounds": scene_layers.rounded([outline.min(axis=0) - MARGIN_M, outline.max(axis=0) + MARGIN_M])}  # fmt: skip
    return html.section(TITLE, html.Raw(markup(scene, texts)), is_open=True)


def outline_m(layers):
    """Some points (n, 3) of the map, which the view of the whole shows; of the grids only where there is no cloud: rays that went astray
    reach far. They are of no use later, so the layers lose them."""
    found = {layer["kind"]: [] for layer in layers}
    for layer in layers:
        found[layer["kind"]] += _outlines(layer)
    if "cloud" in found:
        found.pop("grids", None)
    parts = [part for parts in found.values() for part in parts if len(part)]
    return np.concatenate(parts) if parts else np.array([[-1.0, -1, 0], [1, 1, 2]])


def _outlines(layer):
    if layer["kind"] == "cloud":
        return [layer.pop("outline")]
    if layer["kind"] == "way":
        points_m = np.reshape(layer["points"], (-1, 3))
        return [points_m[scene_layers.evenly(len(points_m), scene_layers.MAX_OUTLINE)]]
    if layer["kind"] == "grids":
        return [np.insert(plane.pop("outline"), 2, plane["corner"][2], axis=1) for plane in layer["planes"]]
    return []


def markup(scene, texts):
    """The markup, the data, the libraries, which run when the view starts, and the scripts."""
    folder = Path(__file__).parent
    held = "".join(f'<script type="application/octet-stream" id="{name}">{text}</script>\n' for name, text in texts.items())
    libraries = "".join(f'<script type="text/plain" class="scene-library">{_library(name)}</script>\n' for name in LIBRARIES)
    script = "\n".join(read_text(folder / name, "install nightmap again") for name in PARTS)
    boxes = "".join(map(_layer_box, scene["layers"]))
    return (read_text(folder / "scene.html", "install nightmap again").replace("<!-- boxes of layers -->", boxes)
            + f'<script type="application/json" id="scene-data">{in_script(scene)}</script>\n{held}{libraries}'
            + f"<script>(() => {{\n{script}\n}})();</script>")  # fmt: skip


def _layer_box(layer):
    """The checkbox of a layer, which the view enables: boxes that came with the view would move all below them."""
    checked = " checked" if layer.get("on") else ""
    return f'<label><input type="checkbox" name="{html.escape(layer["name"])}"{checked} disabled>{html.escape(layer["title"])}</label>'


def in_script(value):
    """JSON in which no name can end the script that holds it: the browser looks for tags in it before it reads it."""
    return json.dumps(value, separators=(",", ":")).replace("<", "\\u003c")


def _library(name):
    return (THREE / name).read_text(encoding="utf-8").replace("</script", "<\\/script")
