# SPDX-License-Identifier: Apache-2.0
"""Errors that a map usually has against truth, for a reader who does not know what is good. They are limits of the ordinary, not of this
program: published RGB-D systems reach 1 to 5 cm and 0.5 to 3 degrees in rooms (TUM RGB-D benchmark), and twice that over ways that lead
through a building, lasers and cameras that look up likewise."""

from nightmap_eval import html

ROOM_CM, BUILDING_CM, USUAL_DEG = 5.0, 10.0, 3.0
LONG_WAY_M = 50.0


def usual_cm(path_length_m):
    return ROOM_CM if path_length_m < LONG_WAY_M else BUILDING_CM


def usual_text(path_length_m):
    return f"up to {usual_cm(path_length_m):g} cm, {USUAL_DEG:g}°"


def judged(value, usual):
    """A number, marked where it is not usual."""
    return html.Raw(f'<span class="failed">{html.number(float(value))} (unusual)</span>') if value > usual else html.Raw(html.number(float(value)))


def judged_errors(values, path_length_m):
    """Text of the errors of an alignment, as in metrics.json."""
    error, turn = judged(100 * values["ate_rmse_m"], usual_cm(path_length_m)), judged(values["rotation_rmse_deg"], USUAL_DEG)
    return html.Raw(f"{error} cm, {turn}° RMSE (usual: {usual_text(path_length_m)})")
