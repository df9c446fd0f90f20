# SPDX-License-Identifier: Apache-2.0
"""Puts measured tables into a page, docs/figures.md, each with the date and the version of the programs that it measured."""

import subprocess
from datetime import date
from pathlib import Path

from nightmap_eval.artifacts import put_between

CHECKOUT = Path(__file__).resolve().parents[2]
PROGRAM_SOURCES = ("CMakeLists.txt", "pipeline", "stages")


def _git(*arguments):
    result = subprocess.run(["git", "-C", CHECKOUT, *arguments], capture_output=True, text=True, check=False)
    return result.stdout.strip() if result.returncode == 0 else ""


def program_version():
    """The commit of the programs' sources, and whether these were changed since."""
    commit = _git("rev-parse", "--short=10", "HEAD")
    if not commit:
        return "an unknown version (no checkout of git)"
    return f"commit {commit}" + (", changed since" if _git("status", "--porcelain", "--", *PROGRAM_SOURCES) else "")


def put_figure(page, name, text):
    """Replaces what stands between `<!-- name:begin -->` and `<!-- name:end -->`. Raises DataError without these markers."""
    note = f"Measured on {date.today().isoformat()} with the programs of {program_version()}."
    put_between(page, f"<!-- {name}:begin -->", f"<!-- {name}:end -->", f"{text.rstrip()}\n\n{note}\n")
