# SPDX-License-Identifier: Apache-2.0
"""Receipts of the last runs: whether the results were made with a config, and since when."""

import datetime
import glob
import json
import os
import re
import tomllib

RECEIPT = re.compile(r"receipt(?:_[\w-]+)?\.json", re.ASCII)
# The errors that reading a damaged receipt raises.
DAMAGED = (OSError, ValueError, LookupError, TypeError, AttributeError, StopIteration, ArithmeticError, RecursionError)


def read_receipt(path):
    """The receipt, whether its run was committed completely, and a modification time (ns) before that run. The receipt is
    renamed last, so a newer output comes from a later run that was killed. Folders may have been moved since, and the
    outputs may be older than the start of the run by a clock that was set back."""
    if not os.path.isfile(path):
        raise ValueError(f"{path}: not a file")
    with open(path, encoding="utf-8") as file:
        receipt = json.load(file)
    report = os.path.basename(path).replace("receipt", "report")
    outputs = [output["path"] for output in receipt["outputs"]]
    then = next(os.path.dirname(output) for output in outputs if os.path.basename(output) == report)
    now = os.path.dirname(path)
    times_ns = [os.stat(os.path.join(now, os.path.relpath(output, then))).st_mtime_ns for output in outputs]
    start_ns = int(datetime.datetime.fromisoformat(receipt["start_time"]).timestamp()) * 10**9
    return receipt, max(times_ns) <= os.stat(path).st_mtime_ns, min(start_ns, *times_ns)


def receipts_in(folders):
    found = [path for folder in folders for path in sorted(glob.glob(os.path.join(glob.escape(folder), "receipt*.json")))]
    return [path for path in found if RECEIPT.fullmatch(os.path.basename(path))]


def earliest_run_ns(paths, fits):
    """A time (ns) before the earliest run whose receipt is among `paths`, if all are whole and fits(receipt); else None. Receipts are
    left out of which it says None."""
    starts_ns = []
    for path in paths:
        try:
            receipt, whole, start_ns = read_receipt(path)
            fit = fits(receipt)
        except DAMAGED:
            return None
        if fit is not None and not (whole and fit):
            return None
        starts_ns += [start_ns] if fit else []
    return min(starts_ns, default=None)


def made_with(paths, program, config):
    """A time (ns) before the earliest run of a program, if all its receipts among `paths` name exactly this config; else None.
    (Programs may share a folder.)"""
    return earliest_run_ns(paths, lambda receipt: tomllib.loads(receipt["config"]) == config if receipt["stage"] == program else None)
