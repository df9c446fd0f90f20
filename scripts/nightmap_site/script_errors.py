# SPDX-License-Identifier: Apache-2.0
"""Command lines and errors of the scripts, with the exit codes of the stages."""

import contextlib
import errno
import sys

REMEDIES = {
    errno.ENOSPC: "the disk is full: free space there, or name a folder on another disk with MAPS, and run again",
    errno.EDQUOT: "the quota is used up: free space there, or name a folder on another disk with MAPS, and run again",
    errno.EFBIG: "raise the limit of file sizes (ulimit -f), and run again",
}


class DataError(Exception):
    """A file that is missing, truncated or inconsistent. The message names it. Exit code 1."""


def printable(text):
    """Text as one line that every terminal can show: file names may contain any byte."""
    shown = str(text).encode("utf-8", "backslashreplace").decode()
    return "".join(letter if letter.isprintable() or letter == "\n" else f"\\x{ord(letter):02x}" for letter in shown)


@contextlib.contextmanager
def writing(path):
    """Names the file in an OSError of its writing: that of write() names none, that of a temporary another."""
    try:
        yield
    except OSError as error:
        error.filename, error.filename2 = str(path), None
        raise


def os_error_text(error, remedy=""):
    """FILE: REASON: REMEDY. The given remedy is for what no full disk causes."""
    remedy = REMEDIES.get(error.errno, remedy)
    return ": ".join(str(part) for part in (error.filename, error.strerror or error, remedy) if part)


def paths_parser(about, **meanings):
    """A parser of a script's command line with a path for each name; one whose meaning begins with ? may be left out. about: docstring."""
    import argparse  # which no make needs
    from pathlib import Path

    parser = argparse.ArgumentParser(description=about.splitlines()[0])
    for name, meaning in meanings.items():
        parser.add_argument("--" + name.replace("_", "-"), type=Path, required=meaning[0] != "?", help=meaning.lstrip("?"))
    return parser


def run_main(main):
    """Calls main() and ends the process with the stages' exit codes: 0 done, 1 data, 2 usage."""
    try:
        main()
    except DataError as error:
        print(f"error: {printable(error)}", file=sys.stderr)
        sys.exit(1)
    except OSError as error:
        print(f"error: {printable(os_error_text(error))}", file=sys.stderr)
        sys.exit(1)
    except MemoryError:
        print("error: out of memory: raise the limit of memory (ulimit -v), or use a machine with more", file=sys.stderr)
        sys.exit(1)
