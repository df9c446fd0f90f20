#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Hashes the artifacts of a site again and compares each with the receipt of the run that made it.

Skips receipts of shards and tiles that no longer exist. Exit code 1 when a file is missing or altered, or when
an input changed since.
"""

import pathlib
import sys

from nightmap_site.receipts import Hashes, Receipt
from nightmap_site.script_errors import DataError, printable, run_main
from nightmap_site.unit_lists import CurrentRuns

ALTERED = {"outputs": "altered since it was written", "inputs": "not the input it was made from"}


def check_receipt(path, hashes):
    try:
        receipt = Receipt(path)
    except DataError as error:
        return [str(error)]
    except OSError as error:
        return [f"{path}: {error.strerror}"]
    return [f"{path}: {file}: {'missing or not readable' if digest is None else ALTERED[kind]}"
            for kind in ("outputs", "inputs") for file, digest in receipt.changed(kind, hashes)]


def main():
    if len(sys.argv) != 2 or sys.argv[1].startswith("-"):
        print(f"usage: {sys.argv[0]} SITE_FOLDER", file=sys.stderr)
        sys.exit(2)
    site_dir = pathlib.Path(sys.argv[1])
    runs = CurrentRuns(site_dir)
    receipts = [path for path in sorted(site_dir.glob("*/receipt*.json")) if runs.has(path)]
    if not receipts:
        raise DataError(f"{site_dir}: no receipts; run make map first")
    hashes = Hashes()
    problems = [problem for path in receipts for problem in check_receipt(path, hashes)]
    for problem in problems:
        print(printable(problem), file=sys.stderr)
    print(f"{len(receipts)} receipts, {len(hashes.known)} files: "
          + (f"{len(problems)} problems" if problems else "all as written"))
    if problems:
        sys.exit(1)


if __name__ == "__main__":
    run_main(main)
