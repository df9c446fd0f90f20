# SPDX-License-Identifier: Apache-2.0
"""Compares the grids of a site's floors with the exact plans of a synthetic building."""

import numpy as np

from nightmap_eval.grid import compare_with_plan, read_grid
from nightmap_eval.walls_and_doors import Sampler, door_figures, wall_figures
from nightmap_site import unit_lists
from nightmap_site.checked_reading import NUMBER, check, read_object, read_toml, using
from nightmap_site.script_errors import DataError

MAX_HEIGHT_ERROR_M = 0.5
DEFAULT_ROBOT_WIDTH_M = 0.5
RECORD_AGAIN = "delete the recording and run make again: synthesize makes it anew"
TRUTH = {
    "?floors": [{"height_m": NUMBER, "plan": str, "doorways_m": [[NUMBER]]}],
    "?boxes": [{"label": int, "center_m": [NUMBER], "half_size_m": [NUMBER], "yaw_rad": NUMBER}],
    "?labels": [str],
}


def read_floors(site):
    """Rows of floors.json, lowest first; without that file, the single floor of map.yaml."""
    if not site.made("grid", "floors"):
        return [{"number": 0, "height_m": 0.0, "yaml": "map.yaml"}]
    return unit_lists.whole(unit_lists.read_floors, site.folder_of("grid"))


def truth_folder(site, site_config=None):
    """DATA/<root>/truth of the site config; None without one. It exists for synthetic sites.

    site_config: another file than the copy in the site's folder."""
    config = site_config or site.config / "site" / f"{site.name}.toml"
    if not config.exists():
        if site_config:
            raise DataError(f"{config}: no such site config")
        return None
    tables = read_toml(config)
    check(tables, {"?root": str}, str(config))
    return None if site.data is None else site.data / tables.get("root", ".") / "truth"


def read_true_floors(truth_dir):
    """Floors and boxes of the exact building, and the label of walls."""
    path = truth_dir / "boxes.json"
    truth = read_object(path, TRUTH, RECORD_AGAIN) if path.exists() else {}
    only = {"height_m": 0.0, "plan": "floor_plan.yaml", "doorways_m": []}
    floors, boxes = truth.get("floors", [only]), truth.get("boxes", [])
    sizes = {len(doorway) for floor in floors for doorway in floor["doorways_m"]} - {4}
    sizes |= {len(box[name]) for box in boxes for name in ("center_m", "half_size_m")} - {3}
    if sizes or not floors:
        raise DataError(f"{path}: not a valid floor, doorway or box; {RECORD_AGAIN}")
    with using(path, RECORD_AGAIN):
        return floors, boxes, truth.get("labels", ["", "wall"]).index("wall")


def robot_width_m(site):
    """Twice the radius of the robot that the site plans for."""
    path = site.config / "plan.toml"
    config = read_toml(path) if path.exists() else {}
    with using(path):
        return 2 * float(config["robot_radius_m"]) if "robot_radius_m" in config else DEFAULT_ROBOT_WIDTH_M


def evaluate_floors(site, truth_dir, building_from_map):
    """Figures of the lowest true floor, and of every floor under `floors`; a floor missing from the map has
    `found` false."""
    rows = read_floors(site)
    # In the building's frame, over the map's origin.
    heights_m = [float(building_from_map.apply(np.array([[0.0, 0.0, row["height_m"]]]))[0, 2]) for row in rows]
    true_floors, boxes, wall_label = read_true_floors(truth_dir)
    robot_m, floors = robot_width_m(site), []
    for floor in true_floors:
        errors_m = [abs(height_m - floor["height_m"]) for height_m in heights_m]
        nearest = int(np.argmin(errors_m))
        figures = {"height_m": floor["height_m"], "found": errors_m[nearest] <= MAX_HEIGHT_ERROR_M}
        if figures["found"]:
            grid, plan = read_grid(site.folder_of("grid") / rows[nearest]["yaml"]), read_grid(truth_dir / floor["plan"])
            sampler = Sampler(grid, building_from_map, floor["height_m"])
            figures |= {"height_error_m": errors_m[nearest], **compare_with_plan(grid, plan, building_from_map),
                        **wall_figures(sampler, plan, boxes, wall_label), **door_figures(sampler, floor["doorways_m"], robot_m)}  # fmt: skip
        floors.append(figures)
    num_found = sum(floor["found"] for floor in floors)
    return floors[0] | {"num_true_floors": len(floors), "num_floors": len(rows),
                        "num_floors_found": num_found, "floors": floors}  # fmt: skip
