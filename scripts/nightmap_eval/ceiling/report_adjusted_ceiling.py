# SPDX-License-Identifier: Apache-2.0
"""Sections of the report on the adjusted map of a ceiling: its picture, what the adjustment found, errors."""

from nightmap_eval import html
from nightmap_eval.artifacts import Frames
from nightmap_eval.ceiling import ceiling_drawing
from nightmap_eval.ceiling.adjusted_ceiling import JOB
from nightmap_eval.ceiling.ceiling_accuracy import read_results, true_frames
from nightmap_eval.ceiling.report_ceiling import in_map, landmark_parts, trajectory_parts
from nightmap_site.checked_reading import NUMBER, read_object

TITLE = "Adjusted map of the ceiling"
FOUND_ROWS = (
    ("num_keyframes", "Keyframes"),
    ("num_landmarks", "Landmarks"),
    ("median_error_px", "Error of a sighting, median (px)"),
    ("ceiling_height_m", "Height of most of the ceiling (m)"),
    ("wheel_scale_error", "Scale error of the wheels"),
    ("wheel_heading_error_rad_per_m", "Heading error of the wheels (rad/m)"),
)


def sections(site, metrics):
    if not (site.made(JOB, "trajectory") and site.made(JOB, "map")):
        return [html.section(TITLE, html.paragraph("The adjust stage did not run.", "note"))]
    estimate, ceiling_map = read_results(site, JOB)
    truth = true_frames(site, Frames(site).times_ns)
    truth_m = None if truth is None or len(estimate) == 0 else in_map(estimate, truth)
    picture = ceiling_drawing.map_png(ceiling_map, estimate.positions_m, truth_m)
    report = read_object(site.needed(JOB, "report"), dict.fromkeys((key for key, _ in FOUND_ROWS), NUMBER))
    parts = [html.image(picture, "adjusted landmarks of the ceiling and the robot's way"),
             html.table(("Adjustment", ""), [[title, report[key]] for key, title in FOUND_ROWS])]  # fmt: skip
    figures = metrics.get("sections", {}).get(JOB)
    if figures is None:
        parts.append(html.paragraph("The evaluate step did not run.", "note"))
    else:
        parts += trajectory_parts(figures) + landmark_parts(figures)
    return [html.section(TITLE, *parts)]
