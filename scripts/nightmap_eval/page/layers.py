# SPDX-License-Identifier: Apache-2.0
"""The layers of the plan: grid, fields, rooms, ways, loops, located queries, paths, those of other jobs' sections, and what is to be looked at."""

from nightmap_eval import html
from nightmap_eval.artifacts import read_csv
from nightmap_eval.grid import FREE
from nightmap_eval.page.fields import fields
from nightmap_eval.page.floor_map import Layer, Plan, area, cells_png, circle, drawing, field_png, label, polyline, raster, size_of
from nightmap_eval.page.places import places_to_look_at
from nightmap_eval.query_errors import read_located
from nightmap_eval.report_plan import read_path, read_path_figures
from nightmap_eval.rooms import find_rooms
from nightmap_eval.ways import loop_ends, way_of

MAX_LOOPS = 500


def plan_parts(site, truth):
    """(the drawing, places to look at, names of what was judged for them, rooms by floor) of a site; None without a trajectory and a grid. truth: in the map frame, or None."""
    plan, way = Plan(site), way_of(site)
    if not plan.grids and not way:
        return None
    ways = _ways(site, plan, way, truth)  # before fields, which are as large as what the plan holds
    found = [*fields(site, plan), *_of_sections(site, plan, "fields")]
    rooms = {number: find_rooms(grid)[1] for number, grid in plan.grids.items() if (grid.cells == FREE).any()}
    places, judged = places_to_look_at(site, plan, found)
    layers = [
        _grids(plan), *_fields(found), *_of_sections(site, plan, "layers"), _rooms(rooms), *ways, *_loops(site, plan, way),
        *_paths(site, plan), _queries(site, plan), _places(places)]  # fmt: skip
    command = f"make plan SITE={site.name}" if site.has("plan") else ""
    no_way = html.paragraph("There is no trajectory: the map_frame stage did not run.", "failed") if not way and site.has("map_frame") else ""
    return html.Raw(drawing(site.name, plan, layers, command) + no_way), places, judged, rooms


def _grids(plan):
    layer = Layer("grid")
    for number, grid in plan.grids.items():
        layer.add(number, raster(cells_png(grid.cells), size_of(grid.cells, grid.resolution_m), (grid.origin_x_m, grid.origin_y_m), grid.origin_yaw_rad))
    return layer


def _fields(found):
    layers = {}
    for field in found:
        layer = layers.setdefault(field.title(), Layer(field.title(), is_shown=False, colors=field.colors))
        layer.add(field.floor, raster(field_png(field), size_of(field.values, field.resolution_m), field.origin_m, field.yaw_rad))
    return layers.values()


def _rooms(rooms):
    layer = Layer("rooms")
    for floor, of_floor in rooms.items():
        for room in of_floor:
            for part in room.polygons:
                layer.add(floor, area([part.outer, *part.holes], "room", f"room {room.number}: {room.area_m2:.1f} m²"))
            layer.add(floor, label(*room.centre_m, f"{room.area_m2:.1f} m²"))
    return layer


def _ways(site, plan, way, truth):
    true, estimated = Layer("truth", is_shown=False), Layer("way of the camera" if site.has_camera() else "way of the robot")
    if truth is not None:
        plan.add_way(true, truth.positions_m, "truth")
    if way:
        plan.add_way(estimated, way.positions_m, "way")
    return true, estimated


def _loops(site, plan, way):
    if not way:
        return
    for name, loops in zip(("accepted", "rejected"), loop_ends(site, way)):
        layer = Layer(f"{name} loops ({len(loops)})", is_shown=False)
        for ends in loops[:: -(-len(loops) // MAX_LOOPS) or 1]:
            layer.add(int(plan.numbers_at(ends[:1, 2])[0]), polyline(ends, name))
        yield layer


def _paths(site, plan):
    path_m, floor = read_path(site), read_path_figures(site).get("floor", 0)
    for name, points_m in (("path", path_m), ("drive", _drive(site))):
        layer = Layer({"path": "planned path", "drive": "driven path"}[name])
        if points_m is not None and len(points_m) and floor in [one["number"] for one in plan.floors]:
            layer.add(floor, polyline(points_m, name))
        yield layer


def _drive(site):
    path = site.made("drive", "csv")
    return [(float(row["x_m"]), float(row["y_m"])) for row in read_csv(path, ("x_m", "y_m"))] if path else None


def _of_sections(site, plan, kind):
    """"fields" or "layers" of other jobs' sections."""
    for _, module in site.sections("report"):
        yield from getattr(module, kind)(site, plan) if hasattr(module, kind) else ()


def _queries(site, plan):
    layer, path = Layer("located queries"), site.made("localize", "queries")
    if path:
        rows, times_ns, located = read_located(path)
        name_at = {int(time_ns): row["color_path"] for row, time_ns in zip(rows, times_ns)}
        for time_ns, position_m in zip(located.times_ns, located.positions_m):
            layer.add(int(plan.numbers_at(position_m[2:])[0]), circle(*position_m[:2], name_at[int(time_ns)], "query"))
    return layer


def _places(places):
    layer = Layer("to look at")
    for number, place in enumerate(places, 1):
        layer.add(place.floor, f'<g class="bad">{circle(place.x_m, place.y_m, place.said)}{label(place.x_m, place.y_m, str(number))}</g>')
    return layer
