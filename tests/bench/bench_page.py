#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""bench_page: what the page of a mapped site costs: time against that of the map, memory, size, and how long a browser takes to open it.

SITES are folders maps/<site>. Each page is written to a folder of its own, and opened by headless Chromium from file://, three times; the
median counts, from the start of the navigation to the end of `load`.
Prints a Markdown table; with --page it goes between `<!-- bench_page:begin -->` and `<!-- bench_page:end -->`.
Exit codes: 0 done; 1 a run failed; 2 wrong command line.
"""

import os
import statistics
import sys
import tempfile
import time
import unittest
from pathlib import Path

from command_line import markdown, parser_of, put_into_page  # first: it makes the packages of scripts/ importable
from checkout import CHECKOUT
from nightmap_site.job_results import read_stages
from nightmap_site.script_errors import DataError, run_main
from nightmap_site.site import Site

sys.path.append(str(CHECKOUT / "tests/e2e"))
os.environ.setdefault("NIGHTMAP_BUILD", str(CHECKOUT / "build"))
from driven_browser import DrivenPage  # noqa: E402

NUM_LOADS = 3
LOAD_MS = "(() => { const [entry] = performance.getEntriesByType('navigation'); return entry.loadEventEnd; })()"
TITLES = ("site", "frames", "jobs of the map (s)", "page (s)", "share of the map (%)", "memory (MiB)", "size (MB)", "opens in (s)")


def written(site_dir, data, page):
    """(seconds, MiB) that report.py takes."""
    command = ["/usr/bin/python3", CHECKOUT / "scripts/report.py", "--site-dir", site_dir, "--data", data, "--out", page]
    began = time.monotonic()
    pid = os.posix_spawn(command[0], [str(word) for word in command], os.environ)
    _, status, used = os.wait4(pid, 0)
    if status != 0:
        raise DataError(f"the page of {site_dir} was not written, see above")
    return time.monotonic() - began, used.ru_maxrss / 1024


def opened_s(page):
    def once():
        test = unittest.TestCase()
        try:
            opened = DrivenPage(test, page)
            opened.wait(f"{LOAD_MS} > 0")
            return opened.value(LOAD_MS) / 1000
        finally:
            test.doCleanups()

    return statistics.median(once() for _ in range(NUM_LOADS))


def row(site_dir, data, folder):
    site = Site(site_dir)
    of_map = {job.folder for job in site.pipeline.jobs.values() if job.goal == "map" and job.when != "synthetic"}
    map_s = sum(stage.wall_time_s() or 0 for stage in read_stages(site) if stage.name in of_map)
    frames = sum(report.get("num_frames", 0) for stage in read_stages(site) if stage.name == "frames" for report in stage.reports)
    page = folder / site.name / "index.html"
    page.parent.mkdir()
    seconds, memory = written(site_dir, data, page)
    return [site.name, str(frames), f"{map_s:.1f}", f"{seconds:.1f}", f"{100 * seconds / map_s:.1f}", f"{memory:.0f}", f"{page.stat().st_size / 1e6:.1f}",
            f"{opened_s(page):.2f}"]  # fmt: skip


def main():
    parser = parser_of(__doc__, "data", "page")
    parser.add_argument("sites", nargs="+", type=Path, metavar="SITE", help="folder maps/<site>")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        table = markdown(TITLES, [row(site, arguments.data, Path(folder)) for site in arguments.sites])
    print(table)
    put_into_page(arguments, "bench_page", table)


if __name__ == "__main__":
    run_main(main)
