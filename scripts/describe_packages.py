#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""describe_packages: prints where each package of docs/packages.md runs, as a table in Markdown; --write puts it into that page.

The page's own table says what each file that includes a package does with it. The programs that such a file belongs to follow
from what sources include, and which profiles and goals run these programs from configs/. A test compares the page with both.
Exit codes: 0 done; 1 the page has no markers, or names no file; 2 wrong command line.
"""

import re
from pathlib import Path

from describe_pipeline import print_or_write, variants
from nightmap_site.declaration import profiles
from nightmap_site.pipeline import read_pipeline
from nightmap_site.script_errors import DataError, run_main

CHECKOUT = Path(__file__).resolve().parents[1]
PAGE = CHECKOUT / "docs/packages.md"
BEGIN, END = "<!-- packages:begin -->", "<!-- packages:end -->"
HEADERS = {"OpenCV": "opencv2", "Ceres": "ceres", "PCL": "pcl", "OctoMap": "octomap", "OpenImageIO": "OpenImageIO"}
FILE = re.compile(r"^\| (\w+) \| `((?:pipeline|stages)/[\w./]+)` \| ([^|]+) \| ([^|]*)\|$", re.MULTILINE)
OURS = re.compile(r'^#include "((?:pipeline|stages)/[\w./]+)"', re.MULTILINE)
HEAD = ("| package | stages | runs in `make map` of | in other goals | only |", "|---|---|---|---|---|")


def files_of_page(page):
    """(package, file) -> when alone the package runs there ("": whenever its program does), from the page's own table."""
    found = {(package, file): only.strip() for package, file, _, only in FILE.findall(page)}
    if not found:
        raise DataError("docs/packages.md: no table of files; restore it")
    return found


def users_of(checkout):
    """The pairs (package, file) of the sources of stages and of what they stand on."""
    return {(package, str(path.relative_to(checkout)))
            for folder in ("pipeline", "stages") for path in (checkout / folder).rglob("*") if path.suffix in (".cc", ".h")
            for package, header in HEADERS.items() if f"#include <{header}/" in path.read_text(encoding="utf-8")}  # fmt: skip


def sources_of(checkout, program):
    """The sources of a program: those of its folder, the headers that they include, and the sources of these."""
    reached, waiting = set(), [path for path in checkout.glob(f"stages/*/{program}/*") if path.suffix in (".cc", ".h")]
    while waiting:
        path = waiting.pop()
        if path in reached or not path.is_file():
            continue
        reached.add(path)
        for name in OURS.findall(path.read_text(encoding="utf-8")):
            waiting += [checkout / name, (checkout / name).with_suffix(".cc")]
    return {str(path.relative_to(checkout)) for path in reached}


class Program:
    """profiles_of_goal: the profiles whose sites run it, the default one first. reads_pixels: it gets the folder of the recordings."""

    def __init__(self, checkout, name):
        self.sources, self.profiles_of_goal, self.reads_pixels = sources_of(checkout, name), {}, False

    def add(self, job, profile):
        self.profiles_of_goal.setdefault(job.goal, {})[profile] = None
        self.reads_pixels |= any(reference.source == "data" for reference in job.inputs)

    def reaches(self, file):
        """Sources on pixels are included by many that read none. The module of pipeline/media is loaded, not included."""
        is_of_pixels = file.startswith(("pipeline/io/", "pipeline/media/"))
        return self.reads_pixels if file.startswith("pipeline/media/") else file in self.sources and (self.reads_pixels or not is_of_pixels)

    def cells(self):
        goals = {goal: ", ".join(profiles) for goal, profiles in self.profiles_of_goal.items()}
        others = "; ".join(f"`make {goal}`: {profiles}" for goal, profiles in goals.items() if goal != "map")
        return f"{goals.get('map', '-')} | {others or '-'}"


def programs_of(checkout):
    programs, configs = {}, str(checkout / "configs")
    for profile in sorted(["default", *profiles(configs)], key=lambda name: name != "default"):
        for given in variants(configs, profile):
            for job in read_pipeline(configs, profile, given).jobs.values():
                if job.program:
                    if job.program not in programs:
                        programs[job.program] = Program(checkout, job.program)
                    programs[job.program].add(job, profile)
    return programs


def describe(checkout, page):
    """The table. `page`: the text of the page, whose table of files says when alone a package runs."""
    programs, stages_of_row = programs_of(checkout), {}
    for (package, file), only in files_of_page(page).items():
        for name, program in programs.items() if not only.startswith("never") else ():
            if program.reaches(file):
                stages_of_row.setdefault((package, program.cells(), only), {})[f"`{name}`"] = None
    rows = [f"| {package} | {', '.join(sorted(stages))} | {cells} | {only} |" for (package, cells, only), stages in stages_of_row.items()]
    return "\n".join([*HEAD, *sorted(rows, key=lambda row: (list(HEADERS).index(row.split()[1]), not row.endswith("|  |")))]) + "\n"


if __name__ == "__main__":
    run_main(lambda: print_or_write(__doc__, PAGE, (BEGIN, END), lambda: describe(CHECKOUT, PAGE.read_text(encoding="utf-8"))))
