# SPDX-License-Identifier: Apache-2.0
"""Sections of the report on the map: trajectory, accuracy, quality of the cloud; with those of report_plan.py."""

import numpy as np

from nightmap_eval import drawing, html
from nightmap_eval.loop_ends import loop_ends
from nightmap_eval.report_plan import drive_section, plan_section, read_if_made
from nightmap_eval.trajectory import FRAME_GAP_NS, Similarity, associate, read_truth, rotation_matrices
from nightmap_site.checked_reading import read_object
from nightmap_site.job_results import StageResult

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
CLOUD_ROWS = (
    ("plane_thickness_median_m", "Thickness of flat surfaces, median per tile (cm)", 100),
    ("plane_thickness_p90_m", "Thickness of flat surfaces, 90 % per tile (cm)", 100),
    ("held_out_rays_agreeing_percent", "Held-out rays that end on the cloud (%)", 1),
    ("held_out_rays_blocked_percent", "Held-out rays that a surface of the cloud blocks (%)", 1),
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
    estimate = read_if_made(site, "map_frame")
    if estimate is None or len(estimate) == 0:
        return html.section("Trajectory", html.paragraph("The map_frame stage did not run.", "note"))
    truth, loops = truth_in_map(site, metrics), loop_ends(site, estimate)[0]
    parts = []
    if truth is None:
        picture = drawing.trajectory_png(estimate.positions_m, None, loops)
    else:
        pairs = associate(estimate.times_ns, truth.times_ns, FRAME_GAP_NS)
        shown = truth.positions_m[pairs[:, 1]]
        picture = drawing.trajectory_png(estimate.positions_m, shown, loops)
        errors_m = np.linalg.norm(estimate.positions_m[pairs[:, 0]] - shown, axis=1)
        errors = drawing.error_png(pairs[:, 0], "frame with a pose", errors_m, "Position error of each frame, SE(3) alignment")
        parts.append(html.image(errors, "error of each frame"))
    parts += floor_paragraphs(site) + sensor_paragraphs(site)
    return html.section("Trajectory", html.image(picture, "trajectory from above"), *parts)


def ate_rows(trajectory, *more):
    for name, title in (("se3", "ATE, SE(3) alignment"), ("sim3", "ATE, Sim(3) alignment")):
        values = trajectory[name]
        shown = [100 * values[f"ate_{kind}_m"] for kind in ("rmse", "median", "max")]
        scale = f", scale {values['scale']:.4f}" if "scale" in values else ""
        yield [title + scale, *shown, values["rotation_rmse_deg"], *more]


def _relative_rows(trajectory):
    for name, title, suffix in (("rpe_per_frame", "RPE per frame", ""), ("rpe_per_metre", "RPE per metre", "_per_m")):
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
    parts = [html.table(head, ate_rows(trajectory, trajectory["num_pairs"]))]
    head = ("Motion", "RMSE (cm)", "median (cm)", "rotation RMSE (deg)", "median (deg)", "pairs")
    parts.append(html.table(head, _relative_rows(trajectory)))
    if metrics.get("map"):
        parts.append(html.table(("Against the exact building", ""), building_rows(metrics["map"])))
    return html.section("Accuracy", *parts)


def cloud_section(site):
    """Quality of the cloud without truth; None when point_cloud wrote no such figures."""
    found = StageResult(site.folder_of("point_cloud")).figures()
    rows = [[title, html.number(tuple(scale * part for part in found[key])) if isinstance(found[key], tuple) else scale * found[key]]
            for key, title, scale in CLOUD_ROWS if key in found]  # fmt: skip
    return html.section("Cloud, without truth", html.table(("", ""), rows)) if rows else None
