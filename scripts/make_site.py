#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Makes the goals of a site: checks the configs, writes the rules of the site, runs make on them, and prints a
summary.

The Makefile passes the goals as arguments, its variables in the environment, its flags in MAKEFLAGS. Only the jobs
frames and tiles know the shards and tiles, so each of them runs first, and the rules are written again when its list
changed. With -n and -q, and for `why`, the rules follow the present lists, and nothing is changed.
Exit codes: 0 made (-q: up to date); 1 (-q: something is out of date) a file that cannot be read or written; 2 an error. The log
and logs/run.json hold the exit code of the program.
"""

import os
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

from nightmap_make.make_run import MakeRun  # noqa: E402
from nightmap_make.request import Asked  # noqa: E402
from nightmap_site.script_errors import DataError, os_error_text, printable  # noqa: E402
from nightmap_site.toml_file import PipelineError  # noqa: E402


def main():
    try:
        return MakeRun(Asked(os.environ, sys.argv[1:])).run()
    except (PipelineError, DataError) as error:
        print(f"nightmap: {printable(error)}", file=sys.stderr)
        return 2 if isinstance(error, PipelineError) else 1
    except OSError as error:
        print(f"nightmap: {printable(os_error_text(error))}", file=sys.stderr)
        return 1


if __name__ == "__main__":
    sys.exit(main())
