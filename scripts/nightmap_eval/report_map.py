# SPDX-License-Identifier: Apache-2.0
"""Sections of the report on the map: trajectory, accuracy, floor plan, path and drive."""

import numpy as np

from nightmap_eval import drawing, html
from nightmap_eval.artifacts import Frames, read_csv
from nightmap_eval.floor_accuracy import read_floors
from nightmap_eval.grid import read_grid
from nightmap_eval.report_cloud import cloud_section
from nightmap_eval.report_stale import notes
from nightmap_eval.trajectory import MAX_POSITION_M, Similarity, associate, read_truth, read_tum, rotation_matrices
from nightmap_site.checked_reading import NUMBER, REMEDY, read_object, using
from nightmap_site.script_errors import DataError

MAX_GAP_NS = 20_000_000
DRIVE_FIGURES = (
    "duration_s", "length_m", "path_length_m", "max_deviation_m", "min_clearance_m", "robot_radius_m",
    "position_error_m", "heading_error_deg",
)  # fmt: skip
DRIVE = dict.fromkeys(DRIVE_FIGURES, NUMBER) | {"?floor": int}
GRID_ROWS = (
    ("free_right_percent", "Free cells right within one cell (%)"),
    ("occupied_right_percent", "Occupied cells right within one cell (%)"),
    ("seen_right_percent", "Seen cells right within one cell (%)"),
    ("walls_closed_percent", "Walls in the grid that no free cells lead through (%)"),
    ("wall_length_present_percent", "Share of the seen wall length that is in the grid (%)"),
    ("wall_length_unseen_percent", "Share of the wall length that was not seen (%)"),
    ("num_doors_wrongly_passable", "Doors narrower than the robot, but passable in the grid"),
    ("num_doors_wrongly_closed", "Doors wider than the robot, but closed in the grid"),
    ("max_door_width_error_m", "Width of a door, largest error (m)"),
)


def map_sections(site, metrics):
    """Sections of the jobs that the site has. Trajectory and accuracy are those of a camera; a laser's are in report_laser.py."""
    made = (section() for is_there, section in (
        (site.has("map_frame") and site.has_camera(), lambda: trajectory_section(site, metrics)),
        (site.has("map_frame") and site.has_camera(), lambda: accuracy_section(metrics)),
        (site.has("point_cloud"), lambda: cloud_section(site)),
        (site.has("grid"), lambda: plan_section(site)),
        (site.has("drive"), lambda: drive_section(site)),
    ) if is_there)  # fmt: skip
    return [section for section in made if section is not None]


def _optional(path, reader):
    return reader(path) if path else None


def truth_in_map(site, metrics):
    """The true trajectory in the map frame, or None."""
    if not site.ground_truth.exists() or "trajectory" not in metrics:
        return None
    values = np.array(metrics["trajectory"]["truth_from_map_m_q"])
    rotation = rotation_matrices(values[None, 3:])[0]
    map_from_truth = Similarity(1.0, rotation.T, -rotation.T @ values[:3])
    truth = read_truth(site.ground_truth)
    truth.positions_m = map_from_truth.apply(truth.positions_m)
    return truth


def accepted_loops(site, estimate):
    """Pairs of positions of the frames that each accepted loop joins."""
    path = site.made("pose_graph", "loops_csv")
    if not path:
        return []
    rows = read_csv(path, ("status",))
    columns = [name for name in (rows[0] if rows else ()) if "frame" in name][:2]
    if len(columns) < 2:
        return []
    frames = Frames(site)
    row_of_time = {int(t): row for row, t in enumerate(estimate.times_ns)}
    numbered = zip(frames.frame_idxs, frames.times_ns)
    row_of_frame = {int(i): row_of_time.get(int(t)) for i, t in numbered}
    loops = []
    for number, row in enumerate(rows, 2):
        with using(f"{path}:{number}"):
            ends = [row_of_frame.get(int(row[name])) for name in columns]
        if row["status"] == "accepted" and None not in ends:
            loops.append(estimate.positions_m[ends])
    return loops


def floor_paragraphs(site):
    """Explains z = 0, and why it may not be the floor; empty for an older map without this information."""
    path = site.made("map_frame", "report")
    report = read_object(path, {"?floor": str, "?floor_warnings": [str]}) if path else {}
    warnings = [html.paragraph("Warning: " + text, "failed") for text in report.get("floor_warnings", [])]
    return ([html.paragraph(report["floor"], "note")] if "floor" in report else []) + warnings


def sensor_paragraphs(site):
    """Warns of sensors whose mounting pose or clock seems wrong; empty without other sensors."""
    path = site.made("pose_graph", "report")
    report = read_object(path, {"?sensors": [{"?warnings": [str]}]}) if path else {}
    texts = [text for sensor in report.get("sensors", []) for text in sensor.get("warnings", [])]
    return [html.paragraph("Warning: " + text, "failed") for text in texts]


def trajectory_section(site, metrics):
    estimate = _optional(site.made("map_frame", "trajectory"), read_tum)
    if estimate is None or len(estimate) == 0:
        note = html.paragraph("The map_frame stage did not run.", "note")
        return html.section("Trajectory", note)
    truth, loops = truth_in_map(site, metrics), accepted_loops(site, estimate)
    parts = []
    if truth is None:
        picture = drawing.trajectory_png(estimate.positions_m, None, loops)
    else:
        pairs = associate(estimate.times_ns, truth.times_ns, MAX_GAP_NS)
        shown = truth.positions_m[pairs[:, 1]]
        picture = drawing.trajectory_png(estimate.positions_m, shown, loops)
        errors_m = np.linalg.norm(estimate.positions_m[pairs[:, 0]] - shown, axis=1)
        parts.append(html.image(drawing.error_png(pairs[:, 0], errors_m), "error of each frame"))
    parts += floor_paragraphs(site) + sensor_paragraphs(site)
    return html.section("Trajectory", html.image(picture, "trajectory from above"), *parts)


def _trajectory_rows(trajectory):
    for name, title in (("se3", "ATE, SE(3) alignment"), ("sim3", "ATE, Sim(3) alignment")):
        values = trajectory[name]
        shown = [100 * values[f"ate_{kind}_m"] for kind in ("rmse", "median", "max")]
        scale = f", scale {values['scale']:.4f}" if "scale" in values else ""
        yield [title + scale, *shown, values["rotation_rmse_deg"], trajectory["num_pairs"]]


def _relative_rows(trajectory):
    for name, title, suffix in (
        ("rpe_per_frame", "RPE per frame", ""),
        ("rpe_per_metre", "RPE per metre", "_per_m"),
    ):
        values = trajectory[name]
        if values["num_pairs"]:
            shown = [100 * values[f"translation_{kind}_m{suffix}"] for kind in ("rmse", "median")]
            turned = [values[f"rotation_{kind}_deg{suffix}"] for kind in ("rmse", "median")]
            yield [title, *shown, *turned, values["num_pairs"]]


def building_rows(building):
    cloud, grid = building.get("cloud", {}), building.get("grid", {})
    for key, title in (("surface_distance_median_m", "Cloud to surface, median (cm)"),
                       ("surface_distance_p90_m", "Cloud to surface, 90 % (cm)")):  # fmt: skip
        if key in cloud:
            yield [title, 100 * cloud[key]]
    floors = grid.get("floors", [grid])
    for floor in floors:
        prefix = f"Floor at {floor['height_m']:.1f} m: " if len(floors) > 1 else ""
        if not floor.get("found", True):
            yield [prefix + "in the map", "no"]
        for key, title in GRID_ROWS:
            if floor.get(key) is not None:
                yield [prefix + title, floor[key]]


def accuracy_section(metrics):
    if not metrics:
        return html.section("Accuracy", html.paragraph("The evaluate step did not run.", "note"))
    if "trajectory" not in metrics:
        note = "This site has no ground truth: the accuracy of the map is unknown."
        return html.section("Accuracy", html.paragraph(note, "note"))
    trajectory = metrics["trajectory"]
    head = ("Position", "RMSE (cm)", "median (cm)", "largest (cm)", "rotation RMSE (deg)", "frames")
    parts = [html.table(head, _trajectory_rows(trajectory))]
    head = ("Motion", "RMSE (cm)", "median (cm)", "rotation RMSE (deg)", "median (deg)", "pairs")
    parts.append(html.table(head, _relative_rows(trajectory)))
    if metrics.get("map"):
        parts.append(html.table(("Against the exact building", ""), building_rows(metrics["map"])))
    return html.section("Accuracy", *parts)


def read_path(site):
    """x, y of plan/path.csv in the map frame (m), or None."""
    path = site.made("plan", "csv")
    if not path:
        return None
    rows = read_csv(path, ("x_m", "y_m"))
    with using(path):
        points_m = np.array([[float(row["x_m"]), float(row["y_m"])] for row in rows]).reshape(-1, 2)
    if not np.all(np.abs(points_m) < MAX_POSITION_M):
        raise DataError(f"{path}: not a valid point; {REMEDY}")
    return points_m


def path_floor(site):
    """Number of the floor of plan/path.csv; 0 for an older path, which names none."""
    path = site.made("plan", "json")
    return read_object(path, {"?floor": int}, "run make plan again").get("floor", 0) if path else 0


def floor_picture(grid_dir, floor, path_m, estimate, located, *mover):
    """One floor's grid, with the path if it is on this floor; the floor of map.yaml also shows the trajectory, named after who moved."""
    ways = (None, None)
    if floor["number"] == 0:
        ways = [None if way is None else way.positions_m for way in (estimate, located)]
    return drawing.grid_png(read_grid(grid_dir / floor["yaml"]), path_m, *ways, *mover)


def plan_section(site):
    if not site.made("grid", "yaml"):
        return html.section("Floor plan", html.paragraph("The grid stage did not run.", "note"))
    estimate = _optional(site.made("map_frame", "trajectory"), read_tum)
    located = _optional(site.made("localize", "trajectory"), read_tum)
    path_m, number = read_path(site), path_floor(site)
    mover = () if site.has_camera() else ("robot",)
    floors, parts = read_floors(site), []
    for floor in sorted(floors, key=lambda floor: abs(floor["number"])):
        has_path = path_m is not None and floor["number"] == number
        name = f"Floor {floor['number']} at {floor['height_m']:.1f} m" + (", with the path" if has_path else "")
        if len(floors) > 1:
            parts.append(html.paragraph(name))
        picture = floor_picture(site.folder_of("grid"), floor, path_m if has_path else None, estimate, located, *mover)
        parts.append(html.image(picture, name))
    if path_m is None and site.has("plan"):
        parts.append(html.paragraph("No path: the plan stage did not run.", "note"))
    parts += [html.paragraph(note, "failed") for note in notes(site, "plan", "path")]
    return html.section("Floor plan", *parts)


def drive_section(site):
    """The simulated drive along the path; None without a drive, which is no failure."""
    figures_path, gif = site.made("drive", "json"), site.made("drive", "gif")
    said = [html.paragraph(note, "failed") for note in notes(site, "drive", "drive")]
    if not (figures_path and gif):
        return html.section("Drive", *said) if said else None
    drive = read_object(figures_path, DRIVE)
    rows = [
        ["Floor", drive.get("floor", 0)],
        ["Duration (s)", drive["duration_s"]],
        ["Driven (m)", drive["length_m"]],
        ["Planned (m)", drive["path_length_m"]],
        ["Largest distance from the path (cm)", 100 * drive["max_deviation_m"]],
        ["Smallest distance to an obstacle (cm)", 100 * drive["min_clearance_m"]],
        ["Radius of the robot (cm)", 100 * drive["robot_radius_m"]],
        ["Position error at the goal (cm)", 100 * drive["position_error_m"]],
        ["Heading error at the goal (deg)", drive["heading_error_deg"]],
    ]
    parts = [html.image(gif.read_bytes(), "simulated drive", media_type="image/gif")]
    parts.append(html.table(("Simulated drive", ""), rows))
    return html.section("Drive", *parts, *said)
