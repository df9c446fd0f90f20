#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""bench_libraries: code of ours against the library that does the same, on recordings and their maps.

Builds and runs bench_libraries (tests/bench/libraries/) on mapped sites, MAPS/SITE after `make map`, prints
the table, and with --page puts it into a page between `<!-- bench_libraries:begin -->` and
`<!-- bench_libraries:end -->`, with the command and the program version that made it.
Exit codes: 0 done; 1 the build or the run failed, or the page has no markers; 2 wrong command line.
"""

import argparse
import os
import subprocess
import sys
from pathlib import Path

CHECKOUT = Path(__file__).resolve().parent.parent.parent
BEGIN, END = "<!-- bench_libraries:begin -->\n", "<!-- bench_libraries:end -->"


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("sites", nargs="*", type=Path, metavar="MAPS/SITE")
    parser.add_argument("--data", type=Path, required=True, help="recordings")
    parser.add_argument("--build", type=Path, default=CHECKOUT / "build")
    parser.add_argument("--page", type=Path, help="file to put the table into")
    return parser.parse_args()


def measure(arguments):
    """The table, and the line that says how it was made."""
    version = subprocess.run(["git", "describe", "--always", "--dirty"], cwd=CHECKOUT, check=True,
                             stdout=subprocess.PIPE, text=True).stdout.strip()  # fmt: skip
    subprocess.run(["ninja", "-C", arguments.build, "bench_libraries"], check=True, stdout=sys.stderr)
    load = os.getloadavg()[0]
    command = [arguments.build / "bench_libraries", arguments.data, *arguments.sites]
    table = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout
    sites = " ".join(f"maps/{site.name}" for site in arguments.sites)
    made = (f"Made by `tests/bench/bench_libraries.py {sites} --data data --page docs/ours_instead_of.md`, program version "
            f"{version}, two cores with a load of {load:.1f} by other programs.")  # fmt: skip
    return f"{made}\n\n{table}"


def put_into(page, text):
    before, has_begin, rest = page.read_text(encoding="utf-8").partition(BEGIN)
    _, has_end, after = rest.partition(END)
    if not has_begin or not has_end:
        sys.exit(f"{page}: no markers {BEGIN.strip()} and {END}")
    page.write_text(f"{before}{BEGIN}{text}{END}{after}", encoding="utf-8")


def main():
    arguments = parse_arguments()
    try:
        text = measure(arguments)
    except (OSError, subprocess.CalledProcessError) as error:
        sys.exit(f"bench_libraries: {error}")
    print(text, end="")
    if arguments.page:
        put_into(arguments.page, text)


if __name__ == "__main__":
    main()
