# SPDX-License-Identifier: Apache-2.0
"""Section of the report in which a person draws objects on the map: rectangles on places that never change.

The page writes objects.yaml and reads it again (objects_file.js), so this file does not: it hands the text of a site's file on.
"""

import base64
import io
import json
from pathlib import Path

from PIL import Image

from nightmap_eval import html
from nightmap_eval.grid import FREE, OCCUPIED, UNKNOWN, read_grid
from nightmap_eval.walls_and_doors import read_floors
from nightmap_site.checked_reading import check, read_text, read_toml
from nightmap_site.script_errors import DataError

DEFAULT_MAX_SIZE_M = 4.0  # of max_object_size_m
PARTS = ("objects_file.js", "objects_list.js", "objects_map.js", "objects_editor.js", "objects_mouse.js")
START = 'new ObjectsEditor(document.getElementById("objects"), JSON.parse(document.getElementById("objects-data").textContent));'
GRAYS = {UNKNOWN: 200, FREE: 255, OCCUPIED: 32}


def objects_section(site):
    """The editor, over the grid; None without a grid."""
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
    editor = html.folded("Draw objects on the map", html.Raw(editor_html(grid, files, max_size_m(site))))
    return html.section("Objects", html.paragraph(html.Raw(said)), *problems, editor)


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
    shown = {"png": f"data:image/png;base64,{base64.b64encode(cells_png(grid.cells)).decode()}", "rows": rows, "columns": columns,
             "resolution_m": grid.resolution_m, "origin_x_m": grid.origin_x_m, "origin_y_m": grid.origin_y_m,
             "origin_yaw_rad": grid.origin_yaw_rad}  # fmt: skip
    # No name can end it: the browser looks for tags in it before it reads it.
    in_script = json.dumps({"max_size_m": longest_m, "grid": shown, "files": files}).replace("<", "\\u003c")
    folder = Path(__file__).parent
    script = "\n".join([(folder / name).read_text(encoding="utf-8") for name in PARTS] + [START])
    return ((folder / "objects_editor.html").read_text(encoding="utf-8")
            + f'<script type="application/json" id="objects-data">{in_script}</script>\n'
            + f"<script>(() => {{\n{script}\n}})();</script>")  # fmt: skip


def cells_png(cells):
    """A pixel per cell, the top row first."""
    picture = Image.fromarray(cells[::-1].copy(), "P")
    picture.putpalette([GRAYS[state] for state in sorted(GRAYS) for _ in range(3)])
    buffer = io.BytesIO()
    picture.save(buffer, "PNG", optimize=True, bits=2)
    return buffer.getvalue()
