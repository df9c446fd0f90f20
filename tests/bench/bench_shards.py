#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""bench_shards: time of make itself against the number of shards.

Programs are stubs (tests/e2e/stub_program.sh) that write small files, so all that is left is what the rules, the
scripts around them and make cost. Runs `make map` from nothing, then again with nothing to do, `make -q map` and
`make why`, of each of the last three the middle of several runs.
Prints a Markdown table of wall and CPU seconds, all processes included; with --page it goes between
`<!-- bench_shards:begin -->` and `<!-- bench_shards:end -->`.
Exit codes: 0 done; 1 a run failed; 2 wrong command line.
"""

import resource
import statistics
import sys
import time

from checkout import CHECKOUT
from command_line import markdown, parser_of, put_into_page
from nightmap_site.script_errors import DataError, run_main

sys.path.append(str(CHECKOUT / "tests/e2e"))
from stub_site import StubSite  # noqa: E402

LOOKS = (["map"], ["-q", "map"], ["why"])  # at a site where nothing is to do
TITLES = ("shards", "make map, from nothing (s)", "make map, nothing to do (s)", "make -q map (s)", "make why (s)")


def parse_arguments():
    parser = parser_of(__doc__, "page")
    parser.add_argument("--shards", type=int, nargs="+", default=[1000, 5000])
    parser.add_argument("--runs", type=int, default=3, help="of each look, of which the middle one counts")
    return parser.parse_args()


def timed(site, goals, num_shards):
    """Wall and CPU seconds of one make."""
    before, start_s = resource.getrusage(resource.RUSAGE_CHILDREN), time.monotonic()
    result = site.make(*goals, num_shards=num_shards)
    wall_s, after = time.monotonic() - start_s, resource.getrusage(resource.RUSAGE_CHILDREN)
    if result.returncode != 0:
        raise DataError(f"make {' '.join(goals)} of {num_shards} shards:\n{result.stdout}\nthe run failed, see above")
    return wall_s, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def measure(num_shards, num_runs):
    """(wall, CPU) seconds of a make from nothing, then of each look the medians."""
    site = StubSite()
    try:
        times = [timed(site, ["map"], num_shards)]
        for goals in LOOKS:
            runs = [timed(site, goals, num_shards) for _ in range(num_runs)]
            times.append(tuple(map(statistics.median, zip(*runs))))
        return times
    finally:
        site.remove()


def table(rows):
    """rows: number of shards -> times of `measure`."""
    lines = [[f"{num_shards:,}", *(f"{wall_s:.2f} (CPU {cpu_s:.2f})" for wall_s, cpu_s in times)]
              for num_shards, times in rows.items()]  # fmt: skip
    return markdown(TITLES, lines, 0)


def main():
    arguments = parse_arguments()
    rows = {}
    for num_shards in arguments.shards:
        rows[num_shards] = measure(num_shards, arguments.runs)
        print(table(rows), end="", flush=True)
    put_into_page(arguments, "bench_shards", table(rows))


if __name__ == "__main__":
    run_main(main)
