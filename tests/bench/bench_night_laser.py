#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""bench_night_laser: time, memory and error of the laser's programs against the number of scans of a night.

Composes nights out of the recording of a made-up site (night/laser_compose.py): copies of its building, differently furnished and
joined by tunnels, through which the robot drives twice. Runs the programs that make and test the map on them, one after the other, with
their default configs. Queries are the stretches that the map's test holds out. A night takes 3 kB of disk per scan; it is deleted when
it is measured.
Prints two Markdown tables, of cost and of errors; with --page they go between `<!-- bench_night_laser:begin -->` and
`<!-- bench_night_laser:end -->`. A program that fails, such as for want of memory, is a row that says so.
Exit codes: 0 done; 1 no night could be composed; 2 wrong command line.
"""

import tempfile
from pathlib import Path

from bench_night import TITLES, add_limits, cost_rows, costs_of, limited_programs
from command_line import markdown, parser_of, put_into_page  # first: it makes the packages of scripts/ importable
from nightmap_site.script_errors import run_main

from night import laser_run
from night.laser_compose import NUM_VISITS, Composer, Source
from night.score import trajectory_figures

ERRORS = ["scans", "copies", "without pose", "ATE (m)", "RPE over 10 m (cm)", "RPE over 10 m (deg)", "loops", "false loops",
          "revisits closed (%)", "queries located", "in a wrong place"]  # fmt: skip


def error_row(folder, composer, truth, costs):
    """A row of the second table."""
    cells, visit = [f"{len(truth):,}", str(composer.num_copies)], len(truth) // NUM_VISITS
    if "map_frame" not in costs:
        return cells + ["n/a"] * (len(ERRORS) - len(cells))
    way = trajectory_figures(folder / "map_frame/trajectory.tum", truth, visit)
    loops = laser_run.loop_figures(folder, truth, visit)
    cells += [str(way["num_without"]), f"{way['ate_m']:.3f}", f"{100 * way['rpe_m']:.2f}", f"{way['rpe_deg']:.3f}",
              f"{loops['num_accepted']:,}", str(loops["num_false"]), f"{loops['closed_percent']:.1f}"]  # fmt: skip
    if "test_localize" not in costs:
        return [*cells, "n/a", "n/a"]
    queries = laser_run.query_figures(folder)
    return [*cells, f"{queries['num_located']} of {queries['num_queries']}", str(queries["num_wrong"])]


def measure(arguments, source, num_scans, folder):
    """A night for the tables: its scans, costs and failure; its row of errors."""
    composer, programs = Composer(source, num_scans), limited_programs(arguments)
    truth = composer.write(folder)
    costs, failure = costs_of(laser_run.jobs_of_whole(), folder, lambda job: laser_run.run(job, programs, folder))
    return (len(truth), costs, failure), error_row(folder, composer, truth, costs)


def main():
    parser = parser_of(__doc__, "build", "threads", "page")
    parser.add_argument("site_dir", type=Path, help="maps/SITE with frames, of a made-up site with a laser that looks all around")
    parser.add_argument("--scans", type=int, nargs="+", default=[5_000, 50_000, 200_000])
    add_limits(parser)
    arguments = parser.parse_args()
    source = Source(arguments.site_dir)
    sites, errors = [], []
    for num_scans in arguments.scans:
        with tempfile.TemporaryDirectory(dir=arguments.folder, ignore_cleanup_errors=True) as folder:
            site, row = measure(arguments, source, num_scans, Path(folder) / "site")
        sites.append(site)
        errors.append(row)
        titles = [title.replace("frame", "scan") for title in TITLES]
        text = markdown(titles, cost_rows(sites)) + "\n" + markdown(ERRORS, errors, 0)
        print(text, flush=True)
    put_into_page(arguments, "bench_night_laser", text)


if __name__ == "__main__":
    run_main(main)
