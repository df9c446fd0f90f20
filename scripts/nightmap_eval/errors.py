# SPDX-License-Identifier: Apache-2.0
"""Errors of the scripts, with the exit codes of the stages."""

import sys


class DataError(Exception):
    """A file that is missing, truncated or inconsistent. The message names it. Exit code 1."""


def run_main(main):
    """Calls main() and ends the process with the stages' exit codes: 0 done, 1 data, 2 usage."""
    try:
        main()
    except DataError as error:
        print(f"error: {error}", file=sys.stderr)
        sys.exit(1)
    except OSError as error:
        print(f"error: {error.filename}: {error.strerror}", file=sys.stderr)
        sys.exit(1)
