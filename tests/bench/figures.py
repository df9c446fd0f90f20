#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""figures: measures the tables of docs/figures.md (and of docs/ours_instead_of.md) again, all of them or those that are named.

Every table says which version of the programs made it and when. Times mean something only on a machine that does nothing
else. Maps go to --maps; Make repeats nothing that is there and still true. A table whose command fails keeps its old rows.
Exit codes: 0 done; 1 a command failed (the others ran); 2 wrong command line.
"""

import argparse
import shlex
import subprocess
from pathlib import Path

from checkout import CHECKOUT
from nightmap_eval.artifacts import put_between
from nightmap_eval.figure_page import put_figure, read_cell
from nightmap_site.script_errors import DataError, run_main

OFFICE, OFFICE_QUERIES = "hololens_office", "hololens_office_queries"
FR1, FR1_QUERIES = "tum_fr1_xyz_15hz", "tum_fr1_xyz_15hz_queries"
DETECTORS = ("orb", "brisk", "fast_orb", "fast_brisk")  # beside sift, the default
SEEDS = "seeds.py --maps {maps} --page {page}"
PEOPLE = [f"tests/bench/people/{room}_standing_moving{means}" for room in ("xyz", "office")
          for means in ("", "_labels", "_labels:published_people")]  # fmt: skip
# The commands of each table, in order, with the folders of parse_arguments. `make` builds what it needs.
FIGURES = {
    "accuracy": (f"{SEEDS} {OFFICE} {OFFICE_QUERIES} {OFFICE_QUERIES}:published_rgbd {FR1} {FR1_QUERIES} demo two_floors "
                 "--data {data}",),
    "detectors": (f"{SEEDS} {' '.join(f'{OFFICE_QUERIES}+features.detector={name}' for name in DETECTORS)} --name detectors "
                  "--data {data}",),
    "mirror": (f"{SEEDS} mirror --seeds 10 --data '{{data}}/{{{{seed}}}}' --name mirror",),
    "laser": (f"{SEEDS} intel freiburg_079 tests/bench/laser/freiburg_079_no_wheels freiburg_079:published_laser "
              "intel+laser_grid.thin_walls=false freiburg_079+laser_grid.thin_walls=false --seeds 1 --data {data} --name laser",),
    "laser_made_up": (f"{SEEDS} demo_laser --data '{{data}}/{{{{seed}}}}' --name laser_made_up",),
    "laser_truth": ("make evaluate SITE=intel DATA={data} MAPS={maps}", "make evaluate SITE=freiburg_079 DATA={data} MAPS={maps}",
                    "truth_noise.py {maps}/intel {maps}/freiburg_079 > laser_truth"),
    "laser_and_camera": ("make evaluate SITE=demo_laser DATA={data} MAPS={maps}",
                         "make evaluate SITE=demo DATA={data} MAPS={maps}/laser_height "
                         "SET='grid.robot_height_m=0.35 grid.max_step_height_m=0.25'",
                         "compare_grids.py {maps}/laser_height/demo {maps}/demo_laser > laser_and_camera"),
    "bench_laser": ("make map SITE=freiburg_079 DATA={data} MAPS={maps}",
                    "bench_laser.py {maps}/freiburg_079 --build {build} --threads {threads} --page {page}"),
    "relocalization": ("make evaluate SITE=freiburg_079 DATA={data} MAPS={maps}",
                       "bench_relocalization.py {maps}/freiburg_079 --seeds 3 --build {build} --threads {threads} --page {page}"),
    "place_search": ("make build", "bench_place_search.py --build {build} --threads {threads} --page {page}"),
    "ablation": (f"make localize SITE={OFFICE_QUERIES} DATA={{data}} MAPS={{maps}}",
                 f"ablation.py {OFFICE_QUERIES} --seeds 3 --data {{data}} --maps {{maps}} --build {{build}} --page {{page}}"),
    "bench": (f"bench.py {FR1} {OFFICE} --data {{data}} --build {{build}} --threads {{threads}} --page {{page}}",),
    "bench_shards": ("bench_shards.py --page {page}",),
    "bench_slurm": ("make build", "bench_slurm.py --data {data} --build {build} --page {page}"),
    "campus": ("make map SITE=demo DATA={data} MAPS={maps}", "scripts/plan_campus.py {maps}/demo --threads {threads} > campus"),
    "bench_localize": (f"make localize SITE={OFFICE_QUERIES} DATA={{data}} MAPS={{maps}}",
                       "make map SITE=demo DATA={data} MAPS={maps}",
                       f"make map SITE={FR1} DATA={{data}} MAPS={{maps}}",
                       f"bench_localize.py {{maps}}/{OFFICE_QUERIES} --donor {{maps}}/demo --donor {{maps}}/{FR1} "
                       "--data {data} --build {build} --threads {threads} --page {page}"),
    "bench_octree": (f"make map SITE={OFFICE} DATA={{data}} MAPS={{maps}}",
                     "make map SITE=demo DATA={data} MAPS={maps}",
                     "ninja -C {build} bench_octree",
                     f"bench_octree.py {{maps}}/{OFFICE}:trajectory:10 {{maps}}/demo:keyframes:2 "
                     "--data {data} --build {build} --repeats 2 --page {page}"),
    "bench_tiles": ("make map SITE=demo DATA={data} MAPS={maps}",
                    "bench_tiles.py {maps}/demo --data {data} --build {build} --threads {threads} "
                    "--keyframes 200 1000 10000 --page {page}"),
    "bench_drive": ("make map SITE=demo DATA={data} MAPS={maps}",
                    "bench_drive.py {maps}/demo/grid/map.yaml --build {build} --set plan.robot_radius_m=0.2 --page {page}"),
    "bench_plan": ("ninja -C {build} bench_plan", "{build}/bench_plan > bench_plan"),
}  # fmt: skip
# These take hours and run only when they are named.
LONG = {
    f"colmap_{OFFICE_QUERIES}": (f"make evaluate-colmap SITE={OFFICE_QUERIES} DATA={{data}} MAPS={{maps}}",
        f"scripts/evaluate_colmap.py --site-dir {{maps}}/{OFFICE_QUERIES} "
        f"--out {{maps}}/{OFFICE_QUERIES}/evaluate_colmap/results.json --page {{page}}"),
    "things": (f"{SEEDS} tests/bench/labels/things tests/bench/labels/things_true --name things --data '{{data}}/{{{{seed}}}}'",),
    "ceiling": (f"{SEEDS} ceiling_corridor ceiling_office ceiling_office:published_ceiling --seeds 10 --name ceiling "
                "--vary synthesize_ceiling.noise_seed --data '{data}/ceiling_{{seed}}'",),
    "faults": ("rm -f {maps}/faults/rows.jsonl",
        f"tests/bench/faults/measure_faults.py {FR1} {OFFICE} --random 60 --data {{data}} --work {{maps}}/faults "
        "--rows {maps}/faults/rows.jsonl --threads {threads} --page {page}"),
    "bench_page": ("make map evaluate localize SITE=building DATA={data} MAPS={maps}",
                   "bench_page.py {maps}/building --data {data} --page {page}"),
    "bench_night": ("make map localize SITE=building DATA={data} MAPS={maps}",
                    "bench_night.py {maps}/building --frames 10000 200000 --unit 27 38 "
                    "--data {data} --build {build} --threads {threads} --page {page}"),
    "bench_night_laser": ("make map SITE=demo_laser DATA={data} MAPS={maps}",
                          "bench_night_laser.py {maps}/demo_laser --scans 5000 50000 --build {build} --threads {threads} --page {page}"),
    "bench_night_ceiling": ("make map SITE=ceiling_office DATA={data} MAPS={maps}",
                            "bench_night_ceiling.py {maps}/ceiling_office --pictures 5000 200000 "
                            "--data {data} --build {build} --threads {threads} --page {page}"),
    # Recordings with people pasted into them by tests/bench/people/paste_people.py.
    "people": (f"{SEEDS} {' '.join(PEOPLE)} --name people --data {{data}}",),
}  # fmt: skip

LASER_CASE = "freiburg_079 | branch_and_bound: whole map"
COLMAP = f"colmap_{OFFICE_QUERIES}"
# Figures that the page begins with: words, section, and the cell of its table.
HEADLINES = (
    ("Way of a camera in the hand before a desk: error, RMSE (cm)", "Camera", "accuracy", "ATE RMSE, SE(3) (cm)", FR1),
    ("Way of a camera on a head through an office: error, RMSE (cm)", "Camera", "accuracy", "ATE RMSE, SE(3) (cm)", OFFICE),
    ("Way through the made-up building of the demo: error, RMSE (cm)", "Camera", "accuracy", "ATE RMSE, SE(3) (cm)", "demo"),
    ("Cells of its grid that are right (%)", "Camera", "accuracy", "seen cells right (%)", "demo"),
    ("False loops in buildings with rooms furnished alike", "Camera", "mirror", "false loops accepted, worst seed", "mirror"),
    ("Pictures of the office located within 5 cm and 5 degrees (%)", "Camera", "accuracy", "global 5 cm, 5 deg (%)", OFFICE_QUERIES),
    ("Their error, median (cm)", "Camera", "accuracy", "global median (cm)", OFFICE_QUERIES),
    ("Likewise by COLMAP, with nightmap's trajectory (cm)", "COLMAP", COLMAP, "global median (cm)", "colmap_triangulate"),
    ("Time of the office's map (s)", "COLMAP", COLMAP, "map (s)", "nightmap"),
    ("Likewise by COLMAP (s)", "COLMAP", COLMAP, "map (s)", "colmap_triangulate"),
    ("Octree, one thread: times faster than OctoMap", "Octree", "bench_octree",
     f"{OFFICE} (31 x 120,403 points) | 4 | batched, 1 thread", "times OctoMap"),
    ("Drives that touch nothing, with noisy wheels", "Planning and driving", "bench_drive",
     "wheel_noise = 0.05 position_noise_m = 0.01 heading_noise_rad = 0.0175", "right"),
    ("Motion over 1 m by a laser in an office building: error, mean (cm)", "Laser", "laser", "motion over 1 m, mean (cm)", "intel"),
    ("Way of a laser through the made-up building: error, RMSE (cm)", "Laser", "laser_made_up", "ATE RMSE, SE(3) (cm)", "demo_laser"),
    ("Scans located within 10 cm and 1 degree in a whole building (%)", "Laser", "relocalization", LASER_CASE,
     "within 10 cm, 1 deg (%)"),
    ("Way under a made-up office's ceiling: error, RMSE (cm)", "Ceiling", "ceiling", "position RMSE (cm)", "ceiling_office"),
    ("Faults of 15 that a report names, in an office", "Verdict", "faults", "named", f"`{OFFICE}`: verdict; ATE; advice"),
)  # fmt: skip


def put_headlines(page):
    """The first table of the page, from its others."""
    rows = [f"| [{words}](#{section.lower().replace(' ', '-')}) | {figure} |"
            for words, section, *place in HEADLINES if (figure := read_cell(page, *place)) is not None]  # fmt: skip
    put_between(page, "<!-- headlines:begin -->", "<!-- headlines:end -->", "\n".join(["| | |", "|---|---:|", *rows, ""]))


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0], epilog=f"tables: {', '.join(FIGURES | LONG)}")
    parser.add_argument("names", nargs="*", help=f"tables (default: all but {', '.join(LONG)}, which take hours)")
    parser.add_argument("--data", type=Path, required=True, help="recordings, the rendered ones too")
    parser.add_argument("--maps", type=Path, default=CHECKOUT / "build/figures", help="results of make")
    parser.add_argument("--build", type=Path, default=CHECKOUT / "build", help="programs")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--page", type=Path, default=CHECKOUT / "docs/figures.md", help="page to put the tables into")
    arguments = parser.parse_args()
    for name in arguments.names:
        if name not in FIGURES | LONG:
            parser.error(f"there is no table {name}, only {', '.join(FIGURES | LONG)}")
    return arguments


def run(command, captures=False):
    """Runs a command of FIGURES in the checkout; returns what it printed if asked to."""
    words = shlex.split(command)
    if words[0].endswith(".py"):
        folder = "" if "/" in words[0] else "tests/bench/"
        words = ["/usr/bin/python3", folder + words[0], *words[1:]]
    print("+", shlex.join(words), flush=True)
    result = subprocess.run(words, cwd=CHECKOUT, check=False, text=True, stdout=subprocess.PIPE if captures else None)
    if result.returncode != 0:
        raise DataError(f"{shlex.join(words)} failed, see above")
    return result.stdout


def make_figure(name, folders):
    """A command `PROGRAM > TABLE` prints the table; the others put theirs into the page themselves."""
    for command in (FIGURES | LONG)[name]:
        program, _, table = command.partition(" > ")
        text = run(program.format(**folders), bool(table))
        if table:
            put_figure(folders["page"], table, text)


def main():
    arguments = parse_arguments()
    folders = {key: value.resolve() if isinstance(value, Path) else value for key, value in vars(arguments).items()}
    failures = []
    for name in arguments.names or FIGURES:
        try:
            make_figure(name, folders)
        except DataError as error:
            print(error, flush=True)
            failures.append(name)
    try:
        put_headlines(folders["page"])
    except DataError as error:
        print(error, flush=True)
        failures.append("headlines")
    if failures:
        raise DataError(f"not measured: {', '.join(failures)}")


if __name__ == "__main__":
    run_main(main)
