# SPDX-License-Identifier: Apache-2.0
"""The grids of a site's floors against the exact plans of a made-up building: cells, walls and doors."""

import numpy as np
from scipy.ndimage import binary_propagation, distance_transform_edt, find_objects, label

from nightmap_eval.grid import FREE, OCCUPIED, compare_with_plan, read_grid
from nightmap_site import unit_lists
from nightmap_site.checked_reading import NUMBER, check, read_object, read_toml, using
from nightmap_site.script_errors import DataError

MIN_WALL_M = 0.5
# Heights above the floor that a wall spans at least: excludes lintels and parapets.
WALL_FROM_M, WALL_TO_M = 0.1, 1.5
MAX_HEIGHT_ERROR_M = 0.5
DEFAULT_ROBOT_WIDTH_M = 0.5
RECORD_AGAIN = "delete the recording and run make again: synthesize makes it anew"
TRUTH = {
    "?floors": [{"height_m": NUMBER, "plan": str, "doorways_m": [[NUMBER]]}],
    "?boxes": [{"label": int, "center_m": [NUMBER], "half_size_m": [NUMBER], "yaw_rad": NUMBER}],
    "?labels": [str],
}


class Sampler:
    """States of a grid at points of the building's frame (n, 2), at the height of a floor."""

    def __init__(self, grid, building_from_map, height_m):
        self.grid, self.building_from_map, self.height_m = grid, building_from_map, height_m

    def states(self, points_m):
        points = np.column_stack([points_m, np.full(len(points_m), self.height_m)])
        return state_at(self.grid, self.building_from_map.apply_inverse(points)[:, :2])


def state_at(grid, points_m):
    """States at points (n, 2) of the grid's frame; unknown outside."""
    rows, columns = grid.indices(points_m)
    height, width = grid.cells.shape
    inside = (rows >= 0) & (rows < height) & (columns >= 0) & (columns < width)
    states = np.zeros(len(points_m), dtype=np.uint8)
    states[inside] = grid.cells[rows[inside], columns[inside]]
    return states


def is_wall(box, floor_m):
    """Whether a box is a wall: upright on the floor, longer than MIN_WALL_M."""
    low_m, high_m = (box["center_m"][2] + sign * box["half_size_m"][2] for sign in (-1, 1))
    stands = low_m <= floor_m + WALL_FROM_M and high_m >= floor_m + WALL_TO_M
    return stands and 2 * max(box["half_size_m"][:2]) >= MIN_WALL_M


class Strip:
    """A wall as a strip: points by metres along and across it, from its middle."""

    def __init__(self, box):
        half_x, half_y = box["half_size_m"][:2]
        yaw = box["yaw_rad"] + (0 if half_x >= half_y else np.pi / 2)
        self.centre = np.array(box["center_m"][:2])
        self.along, self.across = np.array([np.cos(yaw), np.sin(yaw)]), np.array([-np.sin(yaw), np.cos(yaw)])
        self.half_length_m, self.half_width_m = max(half_x, half_y), min(half_x, half_y)

    def points(self, along_m, across_m):
        """(len(along) * len(across), 2), across fastest."""
        a, c = np.meshgrid(along_m, across_m, indexing="ij")
        return self.centre + a.reshape(-1, 1) * self.along + c.reshape(-1, 1) * self.across


def wall_lattice(strip, sampler, margin_m):
    """States of the grid at every half cell along and across a wall, up to `margin_m` beside it; and the
    distance of each column from the wall's middle line."""
    step_m = sampler.grid.resolution_m / 2
    num = int(2 * strip.half_length_m / step_m)
    along_m = (np.arange(num) + 0.5) * step_m - strip.half_length_m
    half_m = strip.half_width_m + margin_m
    across_m = np.linspace(-half_m, half_m, 2 + int(2 * half_m / step_m))
    return sampler.states(strip.points(along_m, across_m)).reshape(num, -1), along_m, across_m


def wall_masks(strip, sampler, plan):
    """Three masks over the half cells along a wall: exposed, present, open.

    Exposed: a side of it is free in the plan, not behind furniture. Present: the grid has an occupied
    cell within one cell of it. Open: it has none, and is free inside the wall. A half cell that is neither was
    not seen: the grid is unknown there."""
    states, along_m, across_m = wall_lattice(strip, sampler, plan.resolution_m)
    inside = np.abs(across_m) <= strip.half_width_m
    beside_m = strip.half_width_m + 1.5 * plan.resolution_m
    beside = state_at(plan, strip.points(along_m, (-beside_m, beside_m))).reshape(len(along_m), -1)
    present = np.any(states == OCCUPIED, axis=1)
    is_open = np.any(states[:, inside] == FREE, axis=1) & ~present
    return np.any(beside == FREE, axis=1), present, is_open


def is_crossed(strip, sampler):
    """Whether a chain of free cells leads through a wall, from two cells before it to two behind."""
    states, _, _ = wall_lattice(strip, sampler, 2 * sampler.grid.resolution_m)
    free = states == FREE
    begins = free & (np.arange(free.shape[1]) == 0)
    return bool(binary_propagation(begins, mask=free)[:, -1].any())


def wall_figures(sampler, plan, boxes, wall_label):
    """Share of the plan's walls that the grid shows, where no furniture hides them.

    A wall counts when more than MIN_WALL_M of it is exposed; a hidden wall must only not be crossed. A wall is
    closed when at least half of its exposed length is present and no chain of free cells leads through it."""
    num_walls = num_closed = num_hidden = num_crossed = 0
    lengths_m = np.zeros(3)  # exposed, present, open
    for box in boxes:
        if box["label"] != wall_label or not is_wall(box, sampler.height_m):
            continue
        strip = Strip(box)
        exposed, present, is_open = wall_masks(strip, sampler, plan)
        counts = [np.count_nonzero(exposed & mask) for mask in (exposed, present, is_open)]
        exposed_m, present_m, _ = in_metres = np.array(counts) * sampler.grid.resolution_m / 2
        lengths_m += in_metres
        crossed = is_crossed(strip, sampler)
        num_crossed += crossed
        if exposed_m < MIN_WALL_M:
            num_hidden += 1
            continue
        num_walls += 1
        num_closed += bool(present_m >= exposed_m / 2 and not crossed)
    all_m, present_m, open_m = map(float, lengths_m)
    seen_m = present_m + open_m
    return {
        "num_walls": num_walls,
        "num_walls_closed": num_closed,
        "num_walls_hidden": num_hidden,
        "num_walls_crossed": num_crossed,
        "walls_closed_percent": 100 * num_closed / num_walls if num_walls else None,
        "wall_length_present_percent": 100 * present_m / seen_m if seen_m else None,
        "wall_length_unseen_percent": 100 * (1 - seen_m / all_m) if all_m else None,
    }


def passage_width_m(sampler, doorway_m):
    """Diameter of the largest round robot that the grid lets through a doorway; 0: it is closed.

    Planners use the same rule: the robot stands on cell centres, and is clear of a cell that is not free when
    their centres are at least its radius apart."""
    x0, y0, x1, y1 = doorway_m
    size = np.array([x1 - x0, y1 - y0])
    through = int(np.argmin(size))  # the axis along which the robot passes
    centre = np.array([x0 + x1, y0 + y1]) / 2
    margin_m, half = 0.7, size / 2 + 0.3
    half[through] = size[through] / 2 + 0.5
    centres = sampler.grid.centres_m()
    offset = sampler.building_from_map.apply(np.dstack([centres, np.zeros(centres.shape[:2])]))[..., :2] - centre
    near = np.all(np.abs(offset) <= half + margin_m, axis=2)
    free = sampler.grid.cells == FREE
    window = near & free & np.all(np.abs(offset) <= half, axis=2)
    if not window.any() or not (near & ~free).any():
        return float(2 * (np.max(half) + margin_m)) if window.any() else 0.0
    around = find_objects(near.astype(int))[0]
    squared = np.where(window, np.rint(distance_transform_edt(~near | free) ** 2), 0)[around]
    side = np.where(np.abs(offset[..., through]) < size[through] / 2 + 0.2, 0, np.sign(offset[..., through]))[around]
    return 2 * sampler.grid.resolution_m * np.sqrt(bottleneck(squared, side))


def bottleneck(values, sides):
    """Largest value v such that cells of at least v connect side -1 with side 1 over their own sides; 0 if there is none."""
    for value in np.unique(values[values > 0])[::-1]:
        parts, _ = label(values >= value)
        if np.intersect1d(parts[(sides < 0) & (parts > 0)], parts[(sides > 0) & (parts > 0)]).size:
            return value
    return 0


def door_figures(sampler, doorways_m, robot_width_m):
    """Checks that the robot passes the plan's doors that are wide enough for it, and no others."""
    true_m = np.array([max(x1 - x0, y1 - y0) for x0, y0, x1, y1 in doorways_m])
    grid_m = np.array([passage_width_m(sampler, door) for door in doorways_m])
    passes, fits = grid_m >= robot_width_m - 1e-9, true_m >= robot_width_m
    return {
        "num_doors": len(doorways_m),
        "robot_width_m": robot_width_m,
        "num_doors_wrongly_passable": int(np.count_nonzero(passes & ~fits)),
        "num_doors_wrongly_closed": int(np.count_nonzero(~passes & fits)),
        "doors_m": [{"true_width_m": t, "grid_width_m": g} for t, g in zip(true_m, grid_m)],
        "max_door_width_error_m": float(np.max(np.abs(grid_m - true_m))) if len(true_m) else None,
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
