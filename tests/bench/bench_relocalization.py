#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""bench_relocalization: how many scans of a laser site are located in its map, how well, and how long that takes.

Takes the stretches of the way that `make evaluate` held out of each site's second map, and looks for their scans in it:
in the whole map; near a rough position; there with furniture moved, without and with objects; and those of the next site.
Objects are those that `objects` proposes for that map. Things within them do not move, in both rows alike.
A row that draws at random is the median over the seeds. Prints a Markdown table; with --page it goes between
`<!-- relocalization:begin -->` and `<!-- relocalization:end -->`.
Exit codes: 0 done; 1 a run failed; 2 wrong command line.
"""

import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

from checkout import CHECKOUT  # first: it makes the packages of scripts/ importable
from command_line import output_of, parser_of, put_into_page
import numpy as np
from nightmap_eval.artifacts import read_csv
from nightmap_eval.laser.report_relocalization import WRONG_M
from nightmap_eval.laser.scan_relocalization import figures, read_scans
from nightmap_eval.query_errors import read_located
from nightmap_eval.trajectory import read_tum
from nightmap_site.checked_reading import read_object
from nightmap_site.script_errors import DataError, run_main
from stage_run import Programs

LOCALIZED = {"queries": "queries.csv", "trajectory": "queries.tum", "candidates": "candidates.csv", "object_poses": "object_poses.csv"}
METHODS = ("branch_and_bound", "published")
HELD_OUT = {"scans": "scans.h5", "queries": "queries.h5", "truth": "truth.tum"}
MOVE_FURNITURE = CHECKOUT / "tests/bench/laser/move_furniture.py"
FILTERED = dict.fromkeys(("num_queries_near_objects", "num_queries_filtered_by_objects"), int)
INFINITE, NONE = float("inf"), "n/a"
# Column -> a number of the figures, or two, and their decimals.
COLUMNS = {
    "queries": (("num_queries",), 0),
    "within 10 cm, 1 deg (%)": (("within_10cm_1deg_percent",), 1),
    "within 5 cm, 0.5 deg (%)": (("within_5cm_0.5deg_percent",), 1),
    "ambiguous (%)": (("ambiguous_percent",), 1),
    "not in map (%)": (("not_in_map_percent",), 1),
    "wrong place (%)": (("wrong_percent",), 1),
    "true place a candidate (%)": (("has_true_place_percent",), 1),
    "objects remove a place (%)": (("filtered_percent",), 1),
    "median (cm / deg)": (("median_translation_error_cm", "median_rotation_error_deg"), 2),
    "error / sigma, 90 % (position / heading)": (("p90_translation_error_per_sigma", "p90_rotation_error_per_sigma"), 1),
    "s per query": (("wall_s",), 3),
    "CPU s per query": (("cpu_s",), 3),
}  # fmt: skip


def parse_arguments():
    parser = parser_of(__doc__, "build", "threads", "page")
    parser.add_argument("site_dirs", type=Path, nargs="+", help="maps/SITE of laser sites after make evaluate")
    parser.add_argument("--seeds", type=int, default=5, help="of rough positions and of the furniture")
    parser.add_argument("--radius", type=float, default=5, help="m, of the rough positions")
    parser.add_argument("--share", type=float, default=0.3, help="of the occupied cells that go with the furniture")
    arguments = parser.parse_args()
    if arguments.seeds < 1 or not arguments.radius > 0:
        parser.error("--seeds and --radius must be positive")
    return arguments


@dataclass
class Questions:
    """Scans to locate; truth: file of their poses in the map, None when they are of another building."""

    queries: Path
    truth: Path | None


class Site:
    """A site after `make evaluate`, and what the benchmark derives from it in `folder`."""

    def __init__(self, site_dir, programs, folder):
        self.dir, self.programs, self.folder = site_dir, programs, folder / site_dir.name
        self.grid = site_dir / "test_grid/map.yaml"
        self.held_out = Questions(site_dir / "test_scans/queries.h5", site_dir / "test_scans/truth.tum")

    def run(self, program, inputs, outputs, name, **options):
        config = self.dir / "config" / f"{program}.toml"
        return self.programs.run(program, inputs, outputs, self.folder / name, config, **options)

    def near(self, radius_m, seed):
        """The same questions, each with a rough position."""
        folder = self.folder / f"near_{seed}"
        inputs = {"scans": self.dir / "frames/scans.h5", "trajectory": self.dir / "map_frame/trajectory.tum"}
        self.run("hold_out_scans", inputs, HELD_OUT, folder.name, rough_radius_m=float(radius_m), seed=seed)
        return Questions(folder / "queries.h5", folder / "truth.tum")

    def objects(self):
        self.run("objects", {"grid": self.grid}, {"objects": "objects.yaml"}, "objects")
        return self.folder / "objects/objects.yaml"

    def moved_grid(self, share, seed, objects):
        folder = self.folder / f"moved_{seed}"
        words = [self.grid, "--out", folder, "--share", share, "--seed", seed, "--objects", objects]
        output_of([sys.executable, MOVE_FURNITURE, *words])
        return folder / "map.yaml"

    def locate(self, questions, method, grid=None, objects=None):
        """Figures of one run of scan_localize."""
        inputs = {"grid": grid or self.grid, "queries": questions.queries} | ({"objects": objects} if objects else {})
        result = self.run("scan_localize", inputs, LOCALIZED, "located", method=f'"{method}"')
        found = run_figures(self.folder / "located/queries.csv", questions.truth, result)
        if questions.truth:
            found |= candidate_figures(self.folder / "located/candidates.csv", read_tum(questions.truth).positions_m)
        return found | filter_figures(read_object(self.folder / "located/report.json", FILTERED))


def run_figures(queries, truth, result):
    """Figures of queries.csv and of the run's StageResult. In another building every pose is wrong."""
    if truth:
        found = figures(read_scans(queries, truth))
    else:
        rows = read_located(queries)[0]
        count = {verdict: sum(row["status"] == verdict for row in rows) for verdict in ("located", "ambiguous", "not_in_map")}
        found = {"num_queries": len(rows), "num_by_verdict": count}
    num_queries = found["num_queries"]
    if num_queries == 0:
        raise DataError(f"{queries}: no scan was asked for")
    for verdict in ("ambiguous", "not_in_map"):
        found[f"{verdict}_percent"] = 100 * found["num_by_verdict"][verdict] / num_queries
    if not truth:
        found["wrong_percent"] = 100 * found["num_by_verdict"]["located"] / num_queries
    return found | {"wall_s": result.wall_time_s() / num_queries, "cpu_s": result.cpu_time_s() / num_queries}


def candidate_figures(candidates, true_positions_m):
    """The share of the queries whose true place is among their candidates."""
    rows = read_csv(candidates, ("query_idx", "x_m", "y_m"))
    places = [(int(row["query_idx"]), np.array([float(row["x_m"]), float(row["y_m"])])) for row in rows]
    found = {i for i, place in places if np.linalg.norm(place - true_positions_m[i, :2]) <= WRONG_M}
    return {"has_true_place_percent": 100 * len(found) / len(true_positions_m)}


def filter_figures(report):
    """Nothing where no object was looked for."""
    near = report["num_queries_near_objects"]
    return {"filtered_percent": 100 * report["num_queries_filtered_by_objects"] / near} if near else {}


def median(values):
    """The upper one of the two in the middle. None stands for an infinite error."""
    return sorted(INFINITE if value is None else value for value in values)[len(values) // 2]


def cell(runs, names, decimals):
    """Medians over the runs, of a figure or of two; n/a when a run lacks it."""
    if any(name not in run for run in runs for name in names):
        return NONE
    return " / ".join(f"{median([run[name] for run in runs]):.{decimals}f}" for name in names)


def line(site, case, runs):
    return f"| {site} | {case} | " + " | ".join(cell(runs, *column) for column in COLUMNS.values()) + " |"


def cases_of(site, arguments):
    """(case, figures of its runs) for each row of a site whose own scans are located."""
    seeds = range(1, arguments.seeds + 1)
    near = {seed: site.near(arguments.radius, seed) for seed in seeds}
    known = f"known within {arguments.radius:g} m"
    objects = site.objects()
    moved = {seed: site.moved_grid(arguments.share, seed, objects) for seed in seeds}
    for method in METHODS:
        yield f"{method}: whole map", [site.locate(site.held_out, method)]
        for name, used in (("no objects", None), ("objects", objects)):
            yield f"{method}: {known}, {name}", [site.locate(near[seed], method, None, used) for seed in seeds]
        for name, used in (("no objects", None), ("objects", objects)):
            runs = [site.locate(near[seed], method, moved[seed], used) for seed in seeds]
            yield f"{method}: {known}, furniture moved, {name}", runs


def cases(sites, arguments):
    """(site, case, figures of its runs) for each row. Each site is asked for the scans of the next one, too."""
    for i, site in enumerate(sites):
        for case, runs in cases_of(site, arguments):
            yield site.dir.name, case, runs
        if len(sites) > 1:
            other = sites[(i + 1) % len(sites)]
            asked = Questions(other.held_out.queries, None)
            for method in METHODS:
                yield site.dir.name, f"{method}: scans of {other.dir.name}", [site.locate(asked, method)]


def table_text(lines):
    return "\n".join([f"| map | case | {' | '.join(COLUMNS)} |", "|---|---|" + "---:|" * len(COLUMNS), *lines]) + "\n"


def table(sites, arguments):
    lines = []
    for row in cases(sites, arguments):
        lines.append(line(*row))
        print(lines[-1], flush=True)
    return table_text(lines)


def main():
    arguments = parse_arguments()
    with tempfile.TemporaryDirectory() as folder:
        programs = Programs(arguments.build, arguments.threads)
        text = table([Site(site_dir, programs, Path(folder)) for site_dir in arguments.site_dirs], arguments)
    put_into_page(arguments, "relocalization", text)


if __name__ == "__main__":
    run_main(main)
