# SPDX-License-Identifier: Apache-2.0
"""Compares artifacts with the receipts of the jobs that wrote them, as the programs do with their inputs
(pipeline/program/written_inputs.h)."""

import json
import os

from nightmap_site.receipts import Hashes
from nightmap_site.script_errors import DataError


class WrittenFiles:
    def __init__(self):
        self._listed, self._hashes = {}, None

    def require(self, path):
        """Raises DataError when receipts beside a file list it, and none with its bytes."""
        folder, name = os.path.split(os.path.abspath(path))
        hashes = {self._outputs(folder, receipt).get(name) for receipt in _receipts_of(name)} - {None}
        if not hashes or not os.path.isfile(path):
            return
        self._hashes = self._hashes or Hashes()  # which loads a library
        if self._hashes.of(os.fspath(path)) not in hashes:
            raise DataError(f"{path}: is not the file that the job wrote (its receipt names other bytes): damaged, edited or of "
                            "another site; delete it and run make again ([import] takes an edited copy)")  # fmt: skip

    def _outputs(self, folder, name):
        receipt = os.path.join(folder, name)
        if receipt not in self._listed:
            self._listed[receipt] = _read_outputs(receipt)
        return self._listed[receipt]


def _receipts_of(name):
    """Where the receipt may be. The name of a unit may have underscores."""
    parts = os.path.splitext(name)[0].split("_")
    return ["receipt.json", *(f"receipt_{'_'.join(parts[at:])}.json" for at in range(1, len(parts)))]


def _read_outputs(receipt):
    """Name -> hash of the outputs in the receipt's folder, which may have been moved since. A file that is no receipt has none."""
    if not os.path.isfile(receipt):
        return {}
    try:
        with open(receipt, encoding="utf-8") as file:
            content = json.load(file)
        if content["format"] != "nightmap receipt":
            return {}
        paths = {entry["path"]: entry["xxh3"] for entry in content["outputs"] if "xxh3" in entry}
        folder = os.path.basename(os.path.dirname(receipt))
        return {os.path.basename(path): xxh3 for path, xxh3 in paths.items()
                if os.path.basename(os.path.dirname(os.path.abspath(path))) == folder}  # fmt: skip
    except (OSError, ValueError, LookupError, TypeError, AttributeError, RecursionError):
        return {}
