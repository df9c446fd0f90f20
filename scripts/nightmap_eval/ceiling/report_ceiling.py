# SPDX-License-Identifier: Apache-2.0
"""Sections of the report on the map that a site made of a ceiling: the map with the robot's way, figures, errors, NEES."""

from nightmap_eval import html
from nightmap_eval.artifacts import Frames
from nightmap_eval.ceiling import ceiling_drawing
from nightmap_eval.ceiling.ceiling_accuracy import read_results, true_frames
from nightmap_eval.ceiling.ceiling_consistency import POSE_DEGREES, errors_then
from nightmap_eval.planar_poses import compose, inverse, read_wheels, to_rows, wrapped_rad
from nightmap_eval.trajectory import associate, travelled_m
from nightmap_eval.trajectory_errors import SAME_NS

TITLE = "Map of the ceiling"
COUNT_ROWS = (
    ("num_landmarks", "Landmarks"),
    ("num_anchors", "Anchors"),
    ("num_loops", "Loops"),
    ("num_frames_with_slipping_wheels", "Frames with slipping wheels"),
    ("num_frames_without_odometry", "Frames without odometry"),
    ("num_frames_without_landmark", "Frames that saw no landmark"),
)
ALIGNMENTS = (("start", "from the first pose on"), ("se3", "after SE(3) alignment"), ("sim3", "after Sim(3) alignment"))
SHARES = ("within_percent", "below_percent", "above_percent")


def sections(site, metrics):
    if not (site.made("odometry", "trajectory") and site.made("odometry", "map")):
        return [html.section(TITLE, html.paragraph("The odometry stage did not run.", "note"))]
    estimate, ceiling_map = read_results(site)
    if len(estimate) == 0:
        return [html.section(TITLE, html.paragraph("No frame has a pose.", "note"))]
    times_ns = Frames(site).times_ns
    truth, wheels = true_frames(site, times_ns), read_wheels(site, times_ns)
    truth_m = None if truth is None else in_map(estimate, truth)
    wheels_m = None if wheels is None else in_map(estimate, wheels)
    picture = ceiling_drawing.map_png(ceiling_map, estimate.positions_m, truth_m, wheels_m)
    parts = [html.image(picture, "landmarks of the ceiling and the robot's way"), *figure_parts(metrics)]
    made = [html.section(TITLE, *parts)]
    if truth_m is not None:
        made.append(html.section("Errors of the robot's way", *error_parts(estimate, ceiling_map, truth, truth_m)))
    return made


def in_map(estimate, other):
    """Rows x, y, heading of another trajectory of the robot, in the map: the first common pose is that of the estimate.

    None when no pose is common."""
    pairs = associate(other.times_ns, estimate.times_ns, SAME_NS)
    if len(pairs) == 0:
        return None
    rows = to_rows(other)
    own, same = to_rows(estimate.select(pairs[:1, 1])), rows[pairs[:1, 0]]
    return compose(compose(own, inverse(same)), rows)


def error_parts(estimate, ceiling_map, truth, truth_in_map):
    pairs = associate(truth.times_ns, estimate.times_ns, SAME_NS)
    errors = to_rows(estimate.select(pairs[:, 1])) - truth_in_map[pairs[:, 0]]
    errors[:, 2] = wrapped_rad(errors[:, 2])
    yield html.paragraph("Errors from the first pose on, without alignment: those of what the filter said at each frame, and those of the "
                         "trajectory, which is by all that is known at the end.", "note")  # fmt: skip
    then = errors_then(ceiling_map, truth)
    way_m = travelled_m(truth_in_map[:, :2])[pairs[:, 0]]
    yield html.image(ceiling_drawing.errors_png(then, way_m, errors), "position and heading error over the route")
    is_judged, nees = then.nees()
    if len(nees):
        times_s = (then.times_ns[is_judged] - then.times_ns[0]) / 1e9
        yield html.image(ceiling_drawing.nees_png(times_s, nees, POSE_DEGREES), "NEES over time")


def figure_parts(metrics):
    figures = metrics.get("sections", {}).get("odometry")
    if figures is None:
        return [html.paragraph("The evaluate step did not run.", "note")]
    ways = [("Path (m)", figures["coverage"]), *([("Path by the wheels alone (m)", figures["wheels"])] if "wheels" in figures else [])]
    parts = [html.table(("Map", ""), [*([title, float(way["path_length_m"])] for title, way in ways),
                                      *([title, figures[key]] for key, title in COUNT_ROWS)])]  # fmt: skip
    parts += trajectory_parts(figures)
    head = ("Honesty of the covariances", "within 95 % bounds (%)", "below (%)", "above (%)", "mean, 1 is ideal", "frames")
    parts.append(html.table(head, consistency_rows(figures)))
    return parts + landmark_parts(figures)


def trajectory_parts(figures):
    if "trajectory" not in figures:
        return [html.paragraph("The robot's true way is not known: the accuracy of the poses is unknown.", "note")]
    head = ("Way of the robot", "RMSE (cm)", "median (cm)", "largest (cm)", "heading RMSE (deg)", "largest (deg)", "missing")
    return [html.table(head, pose_rows(figures))]


def landmark_parts(figures):
    landmarks = figures.get("landmarks", {})
    if not landmarks.get("num_judged"):
        return []
    head = ("Landmarks against the exact ceiling", "median (cm)", "90 % (cm)", "largest (cm)", "largest off edges (cm)",
            "inside 95 % ellipsoid (%)", "landmarks")  # fmt: skip
    rows = []
    for alignment, text in ALIGNMENTS:
        if alignment in landmarks:
            values = landmarks[alignment]
            shown_cm = [100 * values[f"error_{kind}_m"] for kind in ("median", "p90", "max", "max_off_edges")]
            rows.append([text, *shown_cm, float(values["inside_percent"]), landmarks["num_judged"]])
    return [html.table(head, rows),
            html.paragraph(f"{landmarks['num_at_edge']} landmarks lie at the edge of a lintel or doorway, where few pixels decide "
                           "which surface is the true one.", "note")]  # fmt: skip


def pose_rows(figures):
    wheels = figures.get("wheels", {})
    names = [("estimate", figures["trajectory"])]
    if "start" in wheels:
        names.append(("wheels alone", wheels))
    for alignment, text in ALIGNMENTS:
        for name, poses in names:
            values = poses[alignment]
            scale = f", scale {values['scale']:.4f}" if "scale" in values else ""
            shown_cm = [100 * values[f"ate_{kind}_m"] for kind in ("rmse", "median", "max")]
            yield [f"{name}, {text}{scale}", *shown_cm, values["rotation_rmse_deg"], values["rotation_max_deg"], poses["num_missing"]]
        if f"position_ratio_{alignment}" in wheels:
            ratios = [html.number(float(wheels[f"{kind}_ratio_{alignment}"])) + " times" if f"{kind}_ratio_{alignment}" in wheels else ""
                      for kind in ("position", "heading")]  # fmt: skip
            yield ["wheels / estimate", ratios[0], "", "", ratios[1], "", ""]


def consistency_rows(figures):
    for key, title, mean, divisor in (("nees", "NEES of the poses (3 degrees of freedom)", "mean", POSE_DEGREES),
                                      ("nis", "NIS of the sightings", "mean_per_degree_of_freedom", 1)):  # fmt: skip
        values = figures.get(key, {})
        if values.get("num_frames"):
            yield [title, *(float(values[name]) for name in SHARES), values[mean] / divisor, values["num_frames"]]
