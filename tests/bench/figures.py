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
from nightmap_eval.figure_page import put_figure
from nightmap_site.script_errors import DataError, run_main

OFFICE, OFFICE_QUERIES = "hololens_office", "hololens_office_queries"
FR1, FR1_QUERIES = "tum_fr1_xyz_15hz", "tum_fr1_xyz_15hz_queries"
# The commands of each table, in order, with the folders of parse_arguments. `make` builds what it needs.
FIGURES = {
    "accuracy": (f"seeds.py {OFFICE} {OFFICE_QUERIES} {FR1} {FR1_QUERIES} --data {{data}} --maps {{maps}} --page {{page}}",),
    "accuracy_made_up": ("seeds.py demo two_floors --data {data} --maps {maps} --page {page} --name accuracy_made_up",),
    "mirror": ("seeds.py mirror --seeds 10 --data '{data}/{{seed}}' --maps {maps} --page {page} --name mirror",),
    "laser": ("seeds.py intel freiburg_079 --seeds 1 --data {data} --maps {maps} --page {page} --name laser",),
    "laser_not_thinned": ("seeds.py intel freiburg_079 --seeds 1 --data {data} --maps {maps}/not_thinned --page {page} "
                          "--name laser_not_thinned --set laser_grid.thin_walls=false",),
    "laser_no_wheels": ("seeds.py freiburg_079_no_wheels --site-configs tests/bench/laser --seeds 1 --data {data} --maps {maps} "
                        "--page {page} --name laser_no_wheels",),
    "laser_made_up": ("seeds.py demo_laser --data '{data}/{{seed}}' --maps {maps} --page {page} --name laser_made_up",),
    "laser_truth": ("make evaluate SITE=intel DATA={data} MAPS={maps}", "make evaluate SITE=freiburg_079 DATA={data} MAPS={maps}",
                    "truth_noise.py {maps}/intel {maps}/freiburg_079 > laser_truth"),
    "laser_and_camera": ("make evaluate SITE=demo_laser DATA={data} MAPS={maps}",
                         "make evaluate SITE=demo DATA={data} MAPS={maps}/laser_height "
                         "SET='grid.robot_height_m=0.35 grid.max_step_height_m=0.25'",
                         "compare_grids.py {maps}/laser_height/demo {maps}/demo_laser > laser_and_camera"),
    "bench_laser": ("make map SITE=freiburg_079 DATA={data} MAPS={maps}",
                    "bench_laser.py {maps}/freiburg_079 --build {build} --threads {threads} --page {page}"),
    "relocalization": ("make evaluate SITE=freiburg_079 DATA={data} MAPS={maps}",
                       "make evaluate SITE=intel DATA={data} MAPS={maps}",
                       "bench_relocalization.py {maps}/freiburg_079 {maps}/intel --build {build} --threads {threads} "
                       "--page {page}"),
    "published_rgbd": (f"seeds.py {OFFICE_QUERIES} {OFFICE_QUERIES}:published_rgbd --name published_rgbd --data {{data}} "
                       "--maps {maps} --page {page}",),
    "published_laser": ("seeds.py freiburg_079 freiburg_079:published_laser --seeds 1 --name published_laser --data {data} "
                        "--maps {maps} --page {page}",),
    "place_search": ("make build", "bench_place_search.py --build {build} --threads {threads} --page {page}"),
    "detectors": (f"detectors.py {OFFICE_QUERIES} {FR1} --data {{data}} --maps {{maps}} --page {{page}}",),
    "ablation": (f"make localize SITE={OFFICE_QUERIES} DATA={{data}} MAPS={{maps}}",
                 f"ablation.py {OFFICE_QUERIES} --seeds 3 --data {{data}} --maps {{maps}} --build {{build}} --page {{page}}"),
    "cloud_consistency": (f"cloud_consistency.py {FR1} {OFFICE} demo --data {{data}} --maps {{maps}} --page {{page}}",),
    "bench": (f"bench.py {FR1} {OFFICE} --data {{data}} --build {{build}} --threads {{threads}} --page {{page}}",),
    "bench_shards": ("bench_shards.py --page {page}",),
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
    "things": ("seeds.py things things_true --name things --site-configs tests/bench/labels --data '{data}/{{seed}}' --maps {maps} "
               "--page {page}",),
    "ceiling": ("seeds.py ceiling_corridor ceiling_office --name ceiling --seeds 10 --vary synthesize_ceiling.noise_seed "
                "--data '{data}/ceiling_{{seed}}' --maps {maps} --page {page}",),
    **{f"ceiling_depth_{depth}": (f"seeds.py ceiling_office --name ceiling_depth_{depth} --vary synthesize_ceiling.noise_seed --data "
        f"'{{data}}/ceiling_{{{{seed}}}}' --maps {{maps}} --page {{page}} --set ceiling_ekf.initial_depth={depth}",)
       for depth in ("parallax", "published")},
    "published_ceiling": ("seeds.py ceiling_office ceiling_office:published_ceiling --name published_ceiling --vary "
        "synthesize_ceiling.noise_seed --data '{data}/ceiling_{{seed}}' --maps {maps} --page {page}",),
    "faults": ("rm -f {maps}/faults/rows.jsonl",
        f"tests/bench/faults/measure_faults.py {FR1} {OFFICE} --random 60 --data {{data}} --work {{maps}}/faults "
        "--rows {maps}/faults/rows.jsonl --threads {threads} --page {page}"),
    # Recordings with people pasted into them, which are no part of any data set (docs/figures.md).
    "people_xyz": ("seeds.py xyz_empty xyz_people xyz_people_true xyz_people_7 xyz_people_7_true --name people_xyz "
        "--site-configs tests/bench/people --data {data} --maps {maps} --page {page}",),
    "people_moving": ("seeds.py xyz_people_moving_labels xyz_standing_moving_labels office_standing_moving_labels "
        "xyz_standing_moving_labels:published_people office_standing_moving_labels:published_people --seeds 1 --name people_moving "
        "--site-configs tests/bench/people --data {data} --maps {maps} --page {page}",),
    "people_demo": ("make map SITE=demo DATA={data} MAPS={maps}",
        "seeds.py demo_empty --name people_demo --site-configs tests/bench/people --data {data} --maps {maps} --page {page}"),
    "people_office": ("seeds.py office_empty office_people office_people_true office_people_7 office_people_7_true "
        "--name people_office --site-configs tests/bench/people --data {data} --maps {maps} --page {page}",),
}  # fmt: skip


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
    if failures:
        raise DataError(f"not measured: {', '.join(failures)}")


if __name__ == "__main__":
    run_main(main)
