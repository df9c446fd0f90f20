# SPDX-License-Identifier: Apache-2.0
"""Errors of the scripts, with the exit codes of the stages."""

import sys


class DataError(Exception):
    """A file that is missing, truncated or inconsistent. The message names it. Exit code 1."""


def printable(text):
    """Text as one line that every terminal can show: file names may contain any byte."""
    shown = str(text).encode("utf-8", "backslashreplace").decode()
    return "".join(letter if letter.isprintable() or letter == "\n" else f"\\x{ord(letter):02x}" for letter in shown)


def run_main(main):
    """Calls main() and ends the process with the stages' exit codes: 0 done, 1 data, 2 usage."""
    try:
        main()
    except DataError as error:
        print(f"error: {printable(error)}", file=sys.stderr)
        sys.exit(1)
    except OSError as error:
        what = f"{error.filename}: {error.strerror}" if error.filename else error
        print(f"error: {printable(what)}", file=sys.stderr)
        sys.exit(1)
