#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""bench_night_ceiling: time, memory and error of the programs that map a ceiling as a whole, against its number of pictures.

Composes nights of an upward camera out of the tracks of a mapped site (night/ceiling.py): two laps of copies of a part of its way.
Runs ceiling_ekf, ceiling_adjust and ceiling_mosaic on them, one after the other, with their default configs; the mosaic is of the
site's pictures, again and again. Other programs of the profile work on a picture or a shard, whose number does not change their cost.
Prints two Markdown tables, of cost and of errors; with --page they go between `<!-- bench_night_ceiling:begin -->` and
`<!-- bench_night_ceiling:end -->`. A program that fails, such as for want of memory, is a row that says so.
Exit codes: 0 done; 1 no site could be composed; 2 wrong command line.
"""

import functools
import json
import tempfile
from pathlib import Path

from bench_night import TITLES, add_limits, cost_rows, costs_of, limited_programs
from command_line import markdown, parser_of, put_into_page  # first: it makes the packages of scripts/ importable
from nightmap_site.checked_reading import read_text
from nightmap_site.pipeline import read_pipeline
from nightmap_site.script_errors import run_main

from night import run, score
from night.ceiling import CeilingNight
from night.ceiling_source import Source
from night.compose import link_data

PROFILE, JOBS = "ceiling", ("odometry", "adjust", "mosaic")
ERRORS = ["pictures", "copies", "way", "ATE (m)", "RPE over 10 m (cm)", "RPE over 10 m (deg)", "loops", "searches without loop",
          "landmarks"]  # fmt: skip


def jobs():
    declared = read_pipeline(str(run.CONFIGS), PROFILE).jobs
    return [declared[name] for name in JOBS]


def error_rows(night, truth, folder):
    """A row per trajectory that there is: the filter's and the adjusted one."""
    rows = []
    for job in JOBS[:2]:
        if not (folder / job / "trajectory.tum").exists():
            continue
        way = score.trajectory_figures(folder / job / "trajectory.tum", truth, night.lap_frames)
        report = json.loads(read_text(folder / job / "report.json"))
        loops = [str(report.get(key, "")) for key in ("num_loops", "num_searches_without_loop")]
        rows.append([f"{night.num_frames:,}", str(night.num_copies), job, f"{way['ate_m']:.3f}", f"{100 * way['rpe_m']:.2f}",
                     f"{way['rpe_deg']:.3f}", *loops, f"{report['num_landmarks']:,}"])  # fmt: skip
    return rows


def parse_arguments():
    parser = parser_of(__doc__, "data", "build", "threads", "page")
    parser.add_argument("site_dir", type=Path, help="maps/SITE of the profile ceiling, mapped, with true poses of its robot")
    parser.add_argument("--pictures", type=int, nargs="+", default=[5_000, 50_000, 200_000])
    parser.add_argument("--unit", type=int, nargs=2, metavar=("FIRST", "LAST"),
                        help="frames of a copy; without it those that lead farthest, at most a fifth of the smallest size")  # fmt: skip
    add_limits(parser)
    return parser.parse_args()


def main():
    arguments = parse_arguments()
    source = Source(arguments.site_dir)
    unit = tuple(arguments.unit or source.choose_unit(min(arguments.pictures) // 5))
    programs = limited_programs(arguments)
    sites, errors = [], []
    for count in arguments.pictures:
        with tempfile.TemporaryDirectory(dir=arguments.folder, ignore_cleanup_errors=True) as temporary:
            folder = Path(temporary) / "site"
            night = CeilingNight(source, unit, count)
            truth = night.write(folder)
            link_data(folder / "data", arguments.data, len(night.sizes))
            run_one = functools.partial(run.run, programs=programs, folder=folder, source=arguments.site_dir, data=arguments.data,
                                        profile=PROFILE)  # fmt: skip
            sites.append((night.num_frames, *costs_of(jobs(), folder, run_one)))
            errors += error_rows(night, truth, folder)
        titles = [title.replace("frame", "picture") for title in TITLES]
        text = markdown(titles, cost_rows(sites)) + "\n" + markdown(ERRORS, errors, 0)
        print(text, flush=True)
    put_into_page(arguments, "bench_night_ceiling", text)


if __name__ == "__main__":
    run_main(main)
