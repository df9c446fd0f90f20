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

from checkout import CHECKOUT
from nightmap_eval.figure_page import put_figure
from nightmap_site.script_errors import DataError, run_main


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("sites", nargs="*", type=Path, metavar="MAPS/SITE")
    parser.add_argument("--data", type=Path, required=True, help="recordings")
    parser.add_argument("--build", type=Path, default=CHECKOUT / "build")
    parser.add_argument("--page", type=Path, help="page that receives the table, as docs/ours_instead_of.md")
    return parser.parse_args()


def measure(arguments):
    """The table, and how busy the machine was before."""
    load = os.getloadavg()[0]
    try:
        subprocess.run(["ninja", "-C", arguments.build, "bench_libraries"], check=True, stdout=sys.stderr)
        command = [arguments.build / "bench_libraries", arguments.data, *arguments.sites]
        table = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout
    except (OSError, subprocess.CalledProcessError) as error:
        raise DataError(f"bench_libraries: {error}") from None
    return f"{table}\nTwo cores, with a load of {load:.1f} by other programs.\n"


def main():
    arguments = parse_arguments()
    text = measure(arguments)
    print(text, end="")
    if arguments.page:
        put_figure(arguments.page, "bench_libraries", text)


if __name__ == "__main__":
    run_main(main)
