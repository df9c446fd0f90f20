# SPDX-License-Identifier: Apache-2.0
"""Puts measured tables into a page, docs/figures.md, each with the date and the version of the programs that it measured; and reads them."""

import subprocess
from datetime import date
from pathlib import Path

from nightmap_eval.artifacts import put_between
from nightmap_site.checked_reading import read_text
from nightmap_site.script_errors import DataError

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


def read_cell(page, name, row, column):
    """The cell of a table of the page in the row that begins with the cells `row`, "a | b", and below the title `column`; None without a table."""
    text = read_text(page)
    table = text.partition(f"<!-- {name}:begin -->")[2].partition(f"<!-- {name}:end -->")[0]
    lines = [line for line in table.splitlines() if line.startswith("|")]
    titles = [title.strip() for title in lines[0].split("|")] if lines else []
    found = [line.split("|") for line in lines if line.startswith(f"| {row} |")]
    if not lines:
        return None
    if column not in titles or len(found) != 1:
        raise DataError(f"{page}: the table {name} has no row {row!r} with a column {column!r}; run make figures FIGURES={name}")
    return found[0][titles.index(column)].strip()
