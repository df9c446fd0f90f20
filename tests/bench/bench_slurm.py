#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""bench_slurm: what Slurm adds to the time of a site, with both nodes of a cluster on this machine (tests/e2e/slurm_cluster.py).

Makes, in turns with `make -j2` alone: the map of the demo, and a site of many shards whose stub programs compute for half a second
each, where the jobs of a hundred frames take one or two. Prints a Markdown table of wall seconds, the best of each; with --page it goes
between `<!-- bench_slurm:begin -->` and `<!-- bench_slurm:end -->`.
Exit codes: 0 done; 1 a run failed; 2 wrong command line.
"""

import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from checkout import CHECKOUT
from command_line import markdown, parser_of, put_into_page
from nightmap_site.script_errors import DataError, run_main

sys.path.append(str(CHECKOUT / "tests/e2e"))
from slurm_cluster import Cluster  # noqa: E402
from stub_site import StubSite  # noqa: E402
from workspace import environment  # noqa: E402

ALONE, ON_SLURM = ["make", "-j2"], ["salloc", "--quiet", "--nodes=2", "--exclusive", "--mem=0", "--no-kill", "make", "-j4", "LAUNCH=scripts/on_slurm.sh"]
TITLES = ("site", "alone, make -j2 (s)", "on Slurm (s)", "more (%)")


def wall_s(command, folder, **variables):
    began_s = time.monotonic()
    result = subprocess.run(command, cwd=folder, env=environment() | variables, text=True, stdin=subprocess.DEVNULL,
                            stdout=subprocess.PIPE, stderr=subprocess.STDOUT)  # fmt: skip
    if result.returncode != 0:
        raise DataError(f"{' '.join(command)} failed:\n{result.stdout[-4000:]}")
    return time.monotonic() - began_s


def row(title, repeats, run):
    """run(command) makes the site from nothing and returns its seconds."""
    pairs = [(run(ALONE), run(ON_SLURM)) for _ in range(repeats)]
    alone_s, slurm_s = (min(times) for times in zip(*pairs))
    return [title, f"{alone_s:.1f}", f"{slurm_s:.1f}", f"{100 * (slurm_s / alone_s - 1):.0f}"]


def demo(arguments, cluster):
    def run(command):
        with tempfile.TemporaryDirectory() as maps:
            return wall_s([*command, "map", "SITE=demo", "THREADS=2", f"DATA={arguments.data}", f"MAPS={maps}", f"BUILD={arguments.build}"],
                          CHECKOUT, **cluster.environment)  # fmt: skip

    run(ALONE)  # renders the recording
    return row("demo", arguments.repeats, run)


def shards(arguments, cluster):
    site = StubSite()
    try:
        def run(command):
            shutil.rmtree(site.path(""), ignore_errors=True)
            return wall_s([*command, "map", "SITE=demo", "THREADS=1"], site.folder, STUB_SHARDS=str(arguments.shards),
                          STUB_STEPS=str(arguments.steps), **cluster.environment)  # fmt: skip

        return row(f"{arguments.shards} shards", 1, run)
    finally:
        site.remove()


def main():
    parser = parser_of(__doc__, "build", "page")
    parser.add_argument("--data", type=Path, default=CHECKOUT / "data", help="recordings; the demo is rendered here")
    parser.add_argument("--shards", type=int, default=500)
    parser.add_argument("--steps", type=int, default=450_000, help="of the loop of a stub of a shard: 450,000 take half a second")
    parser.add_argument("--repeats", type=int, default=2, help="of the demo")
    arguments = parser.parse_args()
    arguments.data, arguments.build = arguments.data.resolve(), arguments.build.resolve()
    cluster = Cluster()
    try:
        table = markdown(TITLES, [demo(arguments, cluster), shards(arguments, cluster)])
    finally:
        cluster.stop()
    print(table, end="")
    put_into_page(arguments, "bench_slurm", table)


if __name__ == "__main__":
    run_main(main)
