# SPDX-License-Identifier: Apache-2.0
"""Sections of the report on the path planned on the grid of a floor, and its drive."""

import re
import tomllib

import numpy as np

from nightmap_eval import html
from nightmap_eval.artifacts import read_csv
from nightmap_eval.trajectory import MAX_POSITION_M, read_tum
from nightmap_site.checked_reading import NUMBER, REMEDY, read_object, read_toml, using
from nightmap_site.receipts import Hashes, Receipt
from nightmap_site.script_errors import DataError, printable

NARROW = {"length_m": NUMBER, "x_m": NUMBER, "y_m": NUMBER, "room_m": NUMBER}
PATH = {"?floor": int, "?narrow_places": [NARROW]}
DRIVE_FIGURES = (
    "duration_s", "length_m", "path_length_m", "max_deviation_m", "min_clearance_m", "robot_radius_m",
    "position_error_m", "heading_error_deg",
)  # fmt: skip
DRIVE = dict.fromkeys(DRIVE_FIGURES, NUMBER) | {"?floor": int}
# The line that run_job.sh adds to the log of a failed stage, and the stage's own error.
FAILED = re.compile(r"nightmap: \w+ failed, exit code (\d+)")
ERROR = re.compile(r"\S+ error \w+: (.*)")
ENDS = ("start", "goal")


def read_if_made(site, job):
    path = site.made(job, "trajectory")
    return read_tum(path) if path else None


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


def read_path_figures(site):
    """plan/path.json; empty without a path."""
    path = site.made("plan", "json")
    return read_object(path, PATH, "run make plan again") if path else {}


def narrow_lines(figures):
    """A line per place where the path has too little room."""
    for place in figures.get("narrow_places", []):
        yield (f"The path is narrow for {place['length_m']:.2f} m: at ({place['x_m']:.2f}, {place['y_m']:.2f}) only "
               f"{100 * max(0, place['room_m']):.1f} cm are left beside the robot, less than plan.margin_m. It needs an exact pose "
               "there.")  # fmt: skip


def no_path_parts(site):
    """Parts that the last plan left when it failed."""
    picture = site.made("plan", "no_path")
    if not picture:
        return []
    text = ("The last plan found no path. Green: what the robot's centre reaches from the start; red: from a goal; blue: other free "
            "space. Circles around the ends: where they may be moved (snap_radius_m). Orange: where the widest way is too narrow.")  # fmt: skip
    return [html.paragraph(text, "failed"), html.image(picture.read_bytes(), "no path")]


def plan_section(site):
    """The path on the plan, and what is wrong with it; None where the site cannot have one."""
    if not site.made("grid", "yaml"):
        return html.section("Path", html.paragraph("The grid stage did not run.", "note"))
    if not site.has("plan"):
        return None
    parts = [] if read_path(site) is not None else [html.paragraph("No path: the plan stage did not run.", "note")]
    parts += [html.paragraph(line) for line in narrow_lines(read_path_figures(site))]
    parts += [html.paragraph(note, "failed") for note in notes(site, "plan", "path")]
    parts += no_path_parts(site)
    return html.section("Path", *(parts or [html.paragraph("The plan above shows it.", "note")]))


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


def last_failure(site, stage):
    """The reason why the last run failed; None when it succeeded."""
    path = site.logs / f"{stage}.log"
    if not path.exists():
        return None
    lines = path.read_bytes().decode("utf-8", "replace").splitlines()
    failed = FAILED.fullmatch(lines[-1]) if lines else None
    if not failed:
        return None
    reasons = [found[1] for found in map(ERROR.fullmatch, lines) if found]
    return printable(reasons[-1] if reasons else f"exit code {failed[1]}, see {path.name}")


def other_ends(site, receipt):
    """START and GOAL of the present configs if the path has other ends; else None."""
    path = site.config / "plan.toml"
    if not path.exists():
        return None
    now = read_toml(path)
    with using(receipt.path):
        then = tomllib.loads(receipt.content.get("config", ""))
    asked = {name: now[name] for name in ENDS if now.get(name) and now[name] != then.get(name)}
    return ", ".join(f"{name} = {value}" for name, value in asked.items()) or None


def notes(site, stage, result):
    """A failed run of plan or drive leaves the previous result. Sentences on the results of the last runs of plan or drive; `result` is the word for a result."""
    path, failure, found = site.made(stage, "receipt"), last_failure(site, stage), []
    if failure:
        shown = f"the {result} shown here is of an earlier run" if path else f"there is no {result}"
        found.append(f"The last run of {stage} failed, {shown}: {failure}")
    if not path:
        return found
    receipt = Receipt(path)
    changed = [str(path.relative_to(site.folder) if path.is_relative_to(site.folder) else path.name)
               for path, _ in receipt.changed("inputs", Hashes())]  # fmt: skip
    if changed:
        found.append(f"The {result} is out of date: {', '.join(changed)} changed since. Run make {stage}.")
    ends = other_ends(site, receipt) if stage == "plan" else None
    if ends:
        found.append(f"The {result} was planned for other ends than those of the present configs ({ends}). Run make plan.")
    return found
