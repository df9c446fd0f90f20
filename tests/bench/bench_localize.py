#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""bench_localize: CPU time to locate a picture as a function of the number of landmarks.

Thins the map of a site to the smallest size and pads it to the others with copies of real maps (its own
and those of --donor; see padded_map.py), so all sizes share the same real part. Locates the site's
queries in each. The yardstick is the time to describe the same pictures in the same run. Sizes take
turns; the least of --repeats times counts for each part.
Prints a Markdown table; with --page it goes between `<!-- bench_localize:begin -->` and
`<!-- bench_localize:end -->`. "Moved" counts the queries whose positions in the smallest and in this map
differ by more than 5 cm.
Exit codes: 0 done; 1 a run failed; 2 wrong command line.
"""

import math
import shutil
from pathlib import Path

import h5py
import numpy as np

from command_line import markdown, parser_of, put_into_page  # first: it makes the packages of scripts/ importable
import padded_map
from nightmap_eval.artifacts import read_csv
from nightmap_site.checked_reading import read_object
from nightmap_site.job_results import RECEIPT
from nightmap_site.script_errors import run_main
from stage_run import LOCALIZE_OUTPUTS, Programs, localize_inputs

SIZES = (20_000, 100_000, 600_000, 10_000_000)
MOVED_M = 0.05


def parse_arguments():
    parser = parser_of(__doc__, "data", "build", "threads", "page")
    parser.add_argument("site_dir", type=Path, help="MAPS/SITE of a mapped site with queries")
    parser.add_argument("--sizes", type=int, nargs="+", default=SIZES, help="number of landmarks of each map")
    parser.add_argument("--donor", type=Path, action="append", default=[], help="MAPS/SITE of another map to copy")
    parser.add_argument("--repeats", type=int, default=3)
    arguments = parser.parse_args()
    if min(arguments.repeats, *arguments.sizes) < 1:
        parser.error("--repeats and --sizes must be at least 1")
    arguments.sizes = sorted(set(arguments.sizes))
    return arguments


def landmarks_of(site_dir):
    return site_dir / "landmarks" / "landmarks.h5"


def make_maps(arguments, folder):
    """Writes landmarks.h5 and vocabulary.h5 of each size into one folder per size."""
    real = padded_map.read_map(landmarks_of(arguments.site_dir))
    donors = [padded_map.read_map(landmarks_of(donor)) for donor in arguments.donor]
    vocabulary = arguments.site_dir / "vocabulary" / "vocabulary.h5"
    base = padded_map.thin(real, min(len(real), arguments.sizes[0]), np.random.default_rng(0))
    for size in arguments.sizes:
        rng = np.random.default_rng(1)
        padded = padded_map.pad(base, real, donors, size, rng)
        out = folder / str(size)
        out.mkdir(parents=True)
        with h5py.File(vocabulary) as file:
            paths = padded_map.write_map(
                landmarks_of(arguments.site_dir), file, padded, len(base.poses), out / "landmarks.h5"
            )
        padded_map.write_vocabulary(
            vocabulary, padded, paths[:, -1], len(base.poses), out / "vocabulary.h5", rng
        )


class Run:
    """One run of localize: CPU seconds per part, and positions of the located queries."""

    def __init__(self, folder):
        receipt = read_object(folder / "receipt.json", RECEIPT)
        self.parts_s = {}
        for part in receipt.get("parts", []):
            self.parts_s[part["name"]] = self.parts_s.get(part["name"], 0) + part["cpu_time_s"]
        rows = read_csv(folder / "queries.csv", ("query_idx", "status", "tx_m", "ty_m", "tz_m"))
        self.num_queries = len(rows)
        self.positions_m = {
            row["query_idx"]: [float(row[name]) for name in ("tx_m", "ty_m", "tz_m")]
            for row in rows
            if row["status"] == "located"
        }

    def num_moved(self, other):
        common = self.positions_m.keys() & other.positions_m.keys()
        return sum(math.dist(self.positions_m[i], other.positions_m[i]) > MOVED_M for i in common)


def localize(arguments, folder):
    """Locates the site's queries in the map of `folder`."""
    inputs = localize_inputs(arguments.site_dir, arguments.data)
    inputs |= {"landmarks": folder / "landmarks.h5", "vocabulary": folder / "vocabulary.h5"}
    config = arguments.site_dir / "config" / "localize.toml"
    programs = Programs(arguments.build, arguments.threads)
    programs.run("localize", inputs, LOCALIZE_OUTPUTS, folder / "localize", config if config.exists() else None)
    return Run(folder / "localize")


def shortest(runs):
    """CPU milliseconds per query of each part."""
    return {name: min(1e3 * run.parts_s[name] / run.num_queries for run in runs) for name in ("extract", "locate")}


def make_table(runs_of_size):
    """`runs_of_size`: size -> its runs; the first size is the reference of the others."""
    titles = [
        "landmarks", "read (CPU s)", "extract (CPU ms)", "locate (CPU ms)", "both / extract", "both / smallest",
        "located", "moved",
    ]  # fmt: skip
    rows = []
    smallest = next(iter(runs_of_size.values()))
    # The time to describe pictures does not depend on the map: all sizes share it.
    extract_ms = min(shortest(runs)["extract"] for runs in runs_of_size.values())
    first_ms = extract_ms + shortest(smallest)["locate"]
    for size, runs in runs_of_size.items():
        locate_ms = shortest(runs)["locate"]
        both_ms = extract_ms + locate_ms
        rows.append([
            f"{size:,}", f"{min(run.parts_s['read'] for run in runs):.2f}", f"{extract_ms:.1f}", f"{locate_ms:.1f}",
            f"{both_ms / extract_ms:.2f}", f"{both_ms / first_ms:.2f}",
            f"{len(runs[0].positions_m)} of {runs[0].num_queries}", f"{runs[0].num_moved(smallest[0])}",
        ])  # fmt: skip
    return markdown(titles, rows, 0)


def main():
    arguments = parse_arguments()
    folder = arguments.build / "bench_localize" / arguments.site_dir.resolve().name
    shutil.rmtree(folder, ignore_errors=True)
    make_maps(arguments, folder)
    runs_of_size = {size: [] for size in arguments.sizes}
    for _ in range(arguments.repeats):
        for size, runs in runs_of_size.items():
            runs.append(localize(arguments, folder / str(size)))
    table = make_table(runs_of_size)
    print(table, end="")
    put_into_page(arguments, "bench_localize", table)


if __name__ == "__main__":
    run_main(main)
