#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""bench_drive: plans between random places of a grid and drives each plan.

Draws a start and a goal among the grid's free cells, with random headings; draws again when plan refuses
the pair (in an obstacle, too near to one, no path between). Checks each drive from drive.csv alone: the
commands stay within their limits; the poses follow from the commands (within six standard deviations of
the wheels' slip); the footprint is clear of every obstacle cell at every pose and between; the robot
arrives within 5 cm and 5 degrees. Each drive has its own noise seed. Prints counts and the spread of the figures.
Exit codes: 0 all drives pass; 1 some fail; 2 wrong command line.
"""

import collections
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
from command_line import markdown, parser_of  # first: it makes the packages of scripts/ importable
from grid_holes import holes
from nightmap_eval.figure_page import put_figure
from nightmap_eval.grid import FREE, OCCUPIED, UNKNOWN, read_grid
from nightmap_eval.planar_poses import wrapped_rad
from nightmap_site.checked_reading import read_object, using
from nightmap_site.script_errors import DataError, run_main

MAX_POSITION_ERROR_M, MAX_HEADING_ERROR_DEG = 0.05, 5.0
ROUNDING = 2e-6  # rounding of drive.csv and path.csv
MAX_DRAWS_A_DRIVE = 100
MAX_SIGMAS = 6
NOISES = ({}, {"wheel_noise": 0.05, "position_noise_m": 0.005, "heading_noise_rad": 0.01},
          {"wheel_noise": 0.05, "position_noise_m": 0.01, "heading_noise_rad": 0.0175})  # fmt: skip
FAILURES = {"collides": "collided", "has not arrived": "not arrived", "off the goal": "stopped off the goal"}
NUM_BETWEEN = 4  # points checked between two poses


def parse_arguments():
    parser = parser_of(__doc__, "build", "page")
    parser.add_argument("grid", type=Path, help="map.yaml of a grid")
    parser.add_argument("--plan", type=Path, help="plan program to use instead of BUILD/bin/plan")
    parser.add_argument("--folder", type=Path, help="folder of the results instead of BUILD/bench_drive")
    parser.add_argument("--num-drives", type=int, default=200)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--set", action="append", default=[], metavar="STAGE.KEY=VALUE", help="options, as TOML")
    return parser.parse_args()


def run(program, config, inputs, folder, outputs):
    """Returns (exit code, output)."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "config.toml").write_text("".join(f"{key} = {value}\n" for key, value in config.items()))
    command = [program, "--config", folder / "config.toml", "--log-level", "err", "--threads", "1"]
    for name, path in inputs.items():
        command += ["--in", f"{name}={path}"]
    for name, file in {**outputs, "report": "report.json", "receipt": "receipt.json"}.items():
        command += ["--out", f"{name}={folder / file}"]
    result = subprocess.run(list(map(str, command)), capture_output=True, text=True)
    return result.returncode, result.stderr.strip()


def on_arcs(x, y, heading, v, omega, duration_s):
    """Poses reached from others by holding a twist for some time."""
    turn = omega * duration_s
    chord = v * duration_s * np.sinc(turn / (2 * np.pi))
    return x + chord * np.cos(heading + turn / 2), y + chord * np.sin(heading + turn / 2), heading + turn


class Drive:
    """Checks drive.csv without the code of the drive program."""

    def __init__(self, folder, path):
        with using(folder / "drive.csv"):
            values = np.loadtxt(folder / "drive.csv", delimiter=",", skiprows=1, ndmin=2)
            self.times_s, self.x, self.y, self.heading, self.v, self.omega = values.T
        self.times_s = self.times_s / 1e9
        self.path = path
        report = read_object(folder / "report.json", {"config": str})
        self.config = report.pop("config")
        self.figures = report

    def option(self, name):
        return float(re.search(rf"(?m)^{name} = (.*)$", self.config).group(1))

    def keeps_limits(self):
        period_s = self.option("period_s")
        for values, limit, change in (
            (self.v, "max_v_m_s", "max_acceleration_m_s2"),
            (self.omega, "max_omega_rad_s", "max_angular_acceleration_rad_s2"),
        ):
            changes = np.abs(np.diff(np.concatenate([[0], values])))
            if np.abs(values).max() > self.option(limit) + 1e-9:
                return False
            if changes.max() > self.option(change) * period_s + 1e-9 or values[-1] != 0:
                return False
        return self.v.min() >= 0 and np.allclose(np.diff(self.times_s), period_s, atol=1e-9)

    def replays(self):
        """Integrates the commands from the first pose; with noise, from each pose to the next."""
        x, y, heading = self.x[0], self.y[0], self.heading[0]
        noise = MAX_SIGMAS * self.option("wheel_noise")
        for i, duration_s in enumerate(np.diff(self.times_s)):
            if noise > 0:
                x, y, heading = self.x[i], self.y[i], self.heading[i]
            x, y, heading = on_arcs(x, y, heading, self.v[i], self.omega[i], duration_s)
            off_m = max(abs(x - self.x[i + 1]), abs(y - self.y[i + 1]))
            off_rad = abs(wrapped_rad(heading - self.heading[i + 1]))
            radius_m = self.figures["robot_radius_m"]
            way_m = noise * (self.v[i] + radius_m * abs(self.omega[i])) * duration_s
            # The start is rounded; its angle error rotates all later poses.
            rounding = ROUNDING * (2 + np.hypot(x - self.x[0], y - self.y[0]))
            if off_m > rounding + way_m or off_rad > rounding + way_m / radius_m:
                return False
        return True

    def moved(self):
        """Velocities from each pose to the next, taken as constant in between; the last is at rest."""
        turns = wrapped_rad(np.diff(self.heading))
        direction = self.heading[:-1] + turns / 2
        chords = np.diff(self.x) * np.cos(direction) + np.diff(self.y) * np.sin(direction)
        steps_s = np.diff(self.times_s)
        v, omega = chords / np.sinc(turns / (2 * np.pi)) / steps_s, turns / steps_s
        return np.append(v, 0), np.append(omega, 0)

    def clearance_m(self, obstacles_m, resolution_m):
        """Smallest distance to an obstacle cell's square, at the poses and between them."""
        period_s = self.option("period_s")
        v, omega = self.moved()
        parts = [(self.x, self.y)]
        for part in range(1, NUM_BETWEEN):
            parts.append(on_arcs(self.x, self.y, self.heading, v, omega, period_s * part / NUM_BETWEEN)[:2])
        x, y = (np.concatenate(values) for values in zip(*parts))
        points = np.unique(np.column_stack([x, y]), axis=0)
        nearest = np.inf
        for chunk in np.array_split(points, len(points) // 500 + 1):
            beside = np.abs(chunk[:, None] - obstacles_m[None]) - resolution_m / 2
            nearest = min(nearest, np.linalg.norm(np.maximum(beside, 0), axis=2).min())
        return nearest

    def arrival(self, goal_heading_rad):
        """Position error (m) and heading error (degrees)."""
        position_m = np.hypot(*(self.path[-1] - [self.x[-1], self.y[-1]]))
        return position_m, np.degrees(abs(wrapped_rad(self.heading[-1] - goal_heading_rad)))


def obstacle_centres_m(grid, unknown_is_obstacle, max_hole_m):
    """Centres of the obstacle cells that touch another cell; a rim of one cell stands for the outside."""
    filled = holes(grid.cells == FREE, grid.cells == OCCUPIED, int(max_hole_m / grid.resolution_m + 1e-6))
    cells = np.pad(np.where(filled, FREE, grid.cells), 1, constant_values=UNKNOWN)
    blocked = cells != FREE if unknown_is_obstacle else cells == OCCUPIED
    inner = np.pad(blocked, 1, constant_values=True)
    surrounded = inner[:-2, 1:-1] & inner[2:, 1:-1] & inner[1:-1, :-2] & inner[1:-1, 2:]
    rows, columns = np.nonzero(blocked & ~surrounded)
    centres = np.column_stack([columns - 0.5, rows - 0.5]) * grid.resolution_m
    return centres + [grid.origin_x_m, grid.origin_y_m]


def judge(drive, obstacles_m, resolution_m, goal_heading_rad):
    """One word per failed check; empty when the drive passes."""
    drive.position_error_m, drive.heading_error_deg = drive.arrival(goal_heading_rad)
    drive.nearest_m = drive.clearance_m(obstacles_m, resolution_m)
    checks = {
        "limits": drive.keeps_limits(),
        "replay": drive.replays(),
        "collision": drive.nearest_m >= drive.figures["robot_radius_m"] - 2 * ROUNDING,
        "position": drive.position_error_m <= MAX_POSITION_ERROR_M,
        "heading": drive.heading_error_deg <= MAX_HEADING_ERROR_DEG,
        "start": np.hypot(drive.x[0] - drive.path[0, 0], drive.y[0] - drive.path[0, 1]) <= ROUNDING,
    }
    return [name for name, right in checks.items() if not right]


def options_of(arguments, stage):
    pairs = [text.partition("=") for text in arguments.set]
    if not all(key.count(".") == 1 and equals for key, equals, _ in pairs):
        raise DataError("--set takes STAGE.KEY=VALUE")
    return {key.split(".")[1]: value for key, _, value in pairs if key.split(".")[0] == stage}


def spread(name, values):
    values = np.asarray(values)
    print(f"{name}: median {np.median(values):.4g}, smallest {values.min():.4g}, largest {values.max():.4g}")


def draw_drives(arguments, options):
    """Plans and drives until there are enough drives. Returns outcomes (name -> count), the number of draws that plan
    refused, and the drives that arrived. `options`: of drive, besides those of --set."""
    folder = arguments.folder or arguments.build / "bench_drive"
    grid = read_grid(arguments.grid)
    maps = {"grid": arguments.grid}
    plan_program = arguments.plan or arguments.build / "bin" / "plan"
    places_m = grid.centres_m()[grid.cells == FREE]
    rng = np.random.default_rng(arguments.seed)
    outcomes, num_refused, drives = collections.Counter(), 0, []
    obstacles_m = None
    for number in range(MAX_DRAWS_A_DRIVE * arguments.num_drives):
        if sum(outcomes.values()) == arguments.num_drives:
            break
        ends = places_m[rng.integers(len(places_m), size=2)] + rng.uniform(-0.5, 0.5, (2, 2)) * grid.resolution_m
        headings_deg = rng.uniform(-180, 180, 2)
        start, goal = (f'"{x:.6f},{y:.6f}"' for x, y in ends)
        outputs = {"csv": "path.csv", "json": "path.json", "nav": "path.yaml", "png": "path.png"}
        config = {**options_of(arguments, "plan"), "start": start, "goal": goal}
        code, said = run(plan_program, config, maps, folder / "plan", outputs)
        if code == 1:
            num_refused += 1
            continue
        if code != 0:
            raise DataError(f"plan: exit code {code}: {said}")
        config = {"start_heading_deg": f'"{headings_deg[0]:.6f}"', "goal_heading_deg": f'"{headings_deg[1]:.6f}"',
                  "seed": number, **options_of(arguments, "drive"), **options}  # fmt: skip
        inputs = {**maps, "csv": folder / "plan/path.csv", "json": folder / "plan/path.json"}
        outputs = {"csv": "drive.csv", "json": "drive.json"}
        code, said = run(arguments.build / "bin" / "drive", config, inputs, folder / "drive", outputs)
        if code != 0:
            outcomes[next((name for text, name in FAILURES.items() if text in said), f"exit code {code}")] += 1
            print(f"draw {number}: start {start}, goal {goal}, headings {headings_deg}: {said}")
            continue
        path = np.loadtxt(folder / "plan/path.csv", delimiter=",", skiprows=1, ndmin=2, usecols=(0, 1))
        drive = Drive(folder / "drive", path)
        if obstacles_m is None:
            obstacles_m = obstacle_centres_m(grid, drive.figures["unknown_is_obstacle"], drive.figures["max_hole_m"])
        wrong = judge(drive, obstacles_m, grid.resolution_m, np.radians(headings_deg[1]))
        outcomes["right" if not wrong else ", ".join(wrong)] += 1
        if wrong:
            print(f"draw {number}: start {start}, goal {goal}, headings {headings_deg}: wrong: {', '.join(wrong)}")
        drives.append(drive)
    return outcomes, num_refused, drives


def noise_row(noise, outcomes, drives):
    """`noise`: options of drive. A drive that touches, stops off its goal or does not arrive is told by its outcome."""
    failed = ", ".join(f"{count} {name}" for name, count in sorted(outcomes.items()) if name != "right")
    offset_cm = 100 * max(drive.position_error_m for drive in drives)
    turn_deg = max(drive.heading_error_deg for drive in drives)
    name = " ".join(f"{key} = {value}" for key, value in noise.items()) or "none"
    return [name, f"{outcomes['right']} of {sum(outcomes.values())}", failed or "-", f"{offset_cm:.2f}", f"{turn_deg:.2f}"]


def compare_noise(arguments):
    lines = []
    for noise in NOISES:
        outcomes, _, drives = draw_drives(arguments, noise)
        lines.append(noise_row(noise, outcomes, drives))
    table = markdown(("noise of drive", "right", "failed", "farthest off (cm)", "(deg)"), lines)
    print(table, end="")
    put_figure(arguments.page, "bench_drive", table)


def main():
    arguments = parse_arguments()
    if arguments.page:
        compare_noise(arguments)
        return
    outcomes, num_refused, drives = draw_drives(arguments, {})
    print(f"drives: {dict(outcomes)}; draws that plan refused: {num_refused}")
    for name in ("path_length_m", "length_m", "duration_s", "max_deviation_m"):
        spread(name, [drive.figures[name] for drive in drives])
    for name in ("nearest_m", "position_error_m", "heading_error_deg"):
        spread(name, [getattr(drive, name) for drive in drives])
    spread("m/s on average", [drive.figures["length_m"] / drive.figures["duration_s"] for drive in drives])
    sys.exit(0 if outcomes["right"] == arguments.num_drives else 1)


if __name__ == "__main__":
    run_main(main)
