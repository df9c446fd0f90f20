# SPDX-License-Identifier: Apache-2.0
"""Section of the report on the files of a site: each result as a link from the page's folder, with its size and the programs that open it."""

import os
from urllib.parse import quote

from nightmap_eval import html

# Programs that open a file, by its name or how the name ends; the first that fits.
OPENED_BY = (
    ("cloud.ply", "CloudCompare, MeshLab"),
    (".ply", "CloudCompare, MeshLab, Blender"),
    (".pcd", "pcl_viewer, CloudCompare"),
    (".glb", "Blender, a browser's glTF viewer"),
    (".ot", "octovis (colors)"),
    (".bt", "octovis, octomap_server"),
    (".yaml", "nav2 map_server beside its .pgm; a text editor"),
    (".pgm", "nav2 map_server, GIMP"),
    (".tum", "evo_traj tum"),
    (".g2o", "g2o_viewer, GTSAM"),
    ("database.db", "COLMAP"),
    ("cameras.bin", "COLMAP, with the files beside it: import model"),
    (".bin", "COLMAP"),
    (".h5", "HDFView, h5dump, h5py"),
    (".geojson", "QGIS"),
    (".dxf", "LibreCAD, AutoCAD"),
    (".csv", "a spreadsheet"),
    (".json", "a text editor, jq"),
    (".zip", "an archive program"),
    (".png", "any picture viewer"),
    (".gif", "any browser"),
    (".pgw", "QGIS, with the picture beside it"),
    (".html", "any browser"),
    (".txt", "a text editor"),
)
MAX_UNITS = 200  # links of one output


def files_section(site, page_folder):
    """page_folder: where the page is written; the links lead from there."""
    rows, found = [], set()
    outputs = [(job, output) for job in site.pipeline.jobs.values() if job.name != "report" for output in job.outputs | job.beside]
    for job, output in sorted(outputs, key=lambda item: "{unit}" in item[0].file_of(item[1])):  # map.pgm is no unit of {unit}.pgm
        paths = [path for path in _paths(site, job, output) if path not in found]
        found |= set(paths)
        rows += [_row(site, job, output, paths, page_folder)] if paths else []
    order = {name: number for number, name in enumerate(site.pipeline.jobs)}
    rows.sort(key=lambda row: order[row[0]])
    if not rows:
        return html.section("Files", html.paragraph("No result was made yet.", "note"))
    total = sum(size for *_, size in rows)
    shown = [(job, files, size_text(size), opened_by(name)) for job, name, files, size in rows]
    said = f"Results take {size_text(total)}. The links work where the page lies in the site's folder; docs/formats.md describes each format."
    return html.section("Files", html.paragraph(said, "note"), html.table(("job", "file", "size", "opened by"), shown))


def _paths(site, job, output):
    """The file of an output, or those of all units."""
    pattern, folder = job.file_of(output), site.folder_of(job.name)
    paths = sorted(folder.glob(pattern.replace("{unit}", "*")) if "{unit}" in pattern else [folder / pattern])
    return [path for path in paths if path.is_file()]


def _row(site, job, output, paths, page_folder):
    """(job, name, links, bytes)."""
    pattern, folder = job.file_of(output), site.folder_of(job.name)
    size = sum(path.stat().st_size for path in paths)
    links = [html.Raw(f'<a href="{quote(os.path.relpath(path, page_folder))}">{html.escape(str(path.relative_to(site.folder)))}</a>')
             for path in paths[:MAX_UNITS]]  # fmt: skip
    more = [f"and {len(paths) - MAX_UNITS} more"] if len(paths) > MAX_UNITS else []
    shown = links[0] if len(paths) == 1 else html.folded(f"{len(paths)} files {folder.name}/{pattern.replace('{unit}', 'U')}", html.bullets([*links, *more]))
    return job.name, pattern, shown, size


def opened_by(name):
    return next((programs for end, programs in OPENED_BY if name.endswith(end)), "")


def size_text(size):
    for unit in ("B", "kB", "MB", "GB"):
        if size < 1000 or unit == "GB":
            return f"{size:.0f} {unit}" if unit == "B" or size >= 100 else f"{size:.1f} {unit}"
        size /= 1000
