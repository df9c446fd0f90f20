#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Makes what make was asked for of a site: checks the configs, writes the rules of the site, runs make on them, and
says in the end what was done.

The Makefile calls it with the goals; its variables come in the environment, its flags in MAKEFLAGS. Shards and tiles
are known when frames and tiles have run, so each of these is made first and the rules are written anew when its list
changed. With -n and -q, and for `why`, the rules are those of the lists as they are, and nothing is changed.
Exit codes: 0 made (-q: up to date), 1 (-q only) something is out of date, 2 an error; what a program returned is in
the log and in logs/run.json.
"""

import os
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

from nightmap_make.make_run import MakeRun  # noqa: E402
from nightmap_make.request import Asked, Refused  # noqa: E402


def main():
    try:
        return MakeRun(Asked(os.environ, sys.argv[1:])).run()
    except Refused as error:
        message = str(error).encode("utf-8", "backslashreplace").decode()
        print(f"nightmap: {message}", file=sys.stderr)
        return 2


if __name__ == "__main__":
    sys.exit(main())
