#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""floor_plan: writes the floors of a map for other programs: plan.geojson, plan.dxf and nav2.zip.

Rooms and walls are measured on the grids (nightmap_eval/rooms.py); the way of the recording, the last planned path and the boxes of
things are there where the site has them. All coordinates are metres in the map frame.
Exit codes: 0 written; 1 missing or inconsistent data; 2 wrong command line.
"""

import io
import json
import zipfile

import numpy as np

from nightmap_eval.artifacts import write_atomic
from nightmap_eval.dxf import dxf_text
from nightmap_eval.floor_plan import floor_at, floor_features, grids_of, thing_features, way_features
from nightmap_eval.things import read_things
from nightmap_eval.polygons import Polygon
from nightmap_eval.report_plan import notes, read_if_made, read_path, read_path_figures
from nightmap_eval.walls_and_doors import read_floors
from nightmap_site.script_errors import DataError, paths_parser, printable, run_main
from nightmap_site.site import Site

ABOUT = {"format": "nightmap floor plan", "version": 1,
         "frame": "metres in the map frame of nightmap, z up: x and y instead of the longitude and latitude of RFC 7946"}  # fmt: skip
EARLIEST = (1980, 1, 1, 0, 0, 0)  # of zip: the bytes depend on no clock
README = """\
Maps of the floors of {site} for nav2 (ROS 2), in the map frame, metres.

{floors}
Unpack the archive, go to its folder, and start the server of maps with one of them:

  ros2 run nav2_map_server map_server --ros-args -p yaml_filename:=map.yaml
  ros2 run nav2_util lifecycle_bringup map_server

or all of nav2:

  ros2 launch nav2_bringup bringup_launch.py map:=$PWD/map.yaml

Another floor, while the server runs:

  ros2 service call /map_server/load_map nav2_msgs/srv/LoadMap "{{map_url: $PWD/FLOOR.yaml}}"
"""
README_PATH = """
path.yaml is the path that was planned last, a nav_msgs/Path on floor {floor}. To show it:

  ros2 topic pub --once /plan nav_msgs/msg/Path "$(cat path.yaml)"
"""


def features_of(site, floors, grids):
    """All features, floor by floor; then ways and things."""
    features = [feature for floor, grid in grids for feature in floor_features(floor, grid)]
    way, path_m = read_if_made(site, "map_frame"), read_path(site)
    if way is not None:
        features += way_features("trajectory", way.positions_m[:, :2], [floor_at(floors, z_m) for z_m in way.positions_m[:, 2]])
    if path_m is not None:
        number = read_path_figures(site).get("floor", 0)
        of_path = [floor for floor in floors if floor["number"] == number]
        features += way_features("path", path_m, of_path * len(path_m)) if of_path else []
    return features + list(thing_features(read_things(site) or [], floors))


def geojson_text(features):
    """RFC 7946 but for its frame, which a member tells; a feature a line."""
    head = {"type": "FeatureCollection", "nightmap": ABOUT}
    lines = ",\n".join(json.dumps(_geojson(feature), allow_nan=False) for feature in features)
    return f"{json.dumps(head)[:-1]}, \"features\": [\n{lines}\n]}}\n"


def _geojson(feature):
    shape = feature.shape
    if isinstance(shape, Polygon):
        geometry = {"type": "Polygon", "coordinates": [_points(np.vstack([ring, ring[:1]])) for ring in (shape.outer, *shape.holes)]}
    else:
        geometry = {"type": "LineString", "coordinates": _points(shape)}
    properties = {"kind": feature.kind, "floor": feature.floor, "height_m": round(feature.height_m, 4)} | feature.figures
    return {"type": "Feature", "properties": properties, "geometry": geometry}


def _points(points_m):
    return (np.round(points_m, 4) + 0.0).tolist()


def nav2_zip(site, grids):
    """Bytes of the archive: yaml and pgm of each floor, the planned path, and how they are used. Stored, so that no zlib matters."""
    files, lines, folder = {}, [], site.folder_of("grid")
    for floor, grid in grids:
        name = floor["yaml"]
        image = name.removesuffix(".yaml") + ".pgm"
        rows, columns = grid.cells.shape
        lines.append(f"  {name}: floor {floor['number']} at {floor['height_m']:.2f} m, {columns} x {rows} cells of {grid.resolution_m:g} m\n")
        files |= {file: (folder / file).read_bytes() for file in (name, image)}
    readme, path = README.format(site=site.name, floors="".join(lines)), site.made("plan", "nav")
    if path:
        files[path.name] = path.read_bytes()
        readme += README_PATH.format(floor=read_path_figures(site).get("floor", 0))
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as archive:
        for name, content in {**files, "README.txt": readme.encode()}.items():
            entry = zipfile.ZipInfo(name, EARLIEST)
            entry.external_attr = 0o644 << 16
            archive.writestr(entry, content)
    return buffer.getvalue()


def summary(features, floors):
    for floor in floors:
        here = [feature for feature in features if feature.floor == floor["number"]]
        rooms = [feature for feature in here if feature.kind == "room" and feature.figures["part"] == 1]
        area_m2 = sum(room.figures["area_m2"] for room in rooms)
        num = {kind: sum(feature.kind == kind for feature in here) for kind in ("wall", "path", "thing")}
        more = "".join(f", {kind}s {count}" for kind, count in num.items() if count)
        yield f"floor {floor['number']}: rooms {len(rooms)}, free floor in them {area_m2:.1f} m2{more}"


def main():
    arguments = paths_parser(__doc__, site_dir="maps/<site>", data="?folder of the recordings",
                             out="plan.geojson to write, with the others beside it").parse_args()  # fmt: skip
    site = Site(arguments.site_dir, arguments.data)
    if not site.has("grid"):
        raise DataError(f"{arguments.site_dir}: its profile makes no grid, and so no plan of floors; take a profile with a laser or depth")
    floors = read_floors(site)
    grids = list(grids_of(site, floors))
    features = features_of(site, floors, grids)
    write_atomic(arguments.out.with_name("nav2.zip"), nav2_zip(site, grids))
    write_atomic(arguments.out.with_suffix(".dxf"), dxf_text(features))
    write_atomic(arguments.out, geojson_text(features))  # the last: make takes its time for that of all
    print(printable("\n".join([*summary(features, floors), *notes(site, "plan", "path")])))


if __name__ == "__main__":
    run_main(main)
