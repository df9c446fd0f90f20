# SPDX-License-Identifier: Apache-2.0
"""Compares receipts with the files they name: finds altered outputs and changed inputs."""

import ctypes
import ctypes.util
import functools
import json
import os
from pathlib import Path

from nightmap_site.checked_reading import read_object, using
from nightmap_site.script_errors import DataError

CHUNK_BYTES = 1 << 20
FILE = {"path": str, "name": str, "?xxh3": str}
RECEIPT = {"inputs": [FILE], "outputs": [FILE], "?config": str}


@functools.cache
def load_xxhash():
    name = ctypes.util.find_library("xxhash") or "libxxhash.so.0"
    try:
        library = ctypes.CDLL(name)
    except OSError:
        raise DataError(f"{name}: the library of the hashes in receipts is missing; run make deps") from None
    library.XXH3_createState.restype = ctypes.c_void_p
    library.XXH3_64bits_reset.argtypes = [ctypes.c_void_p]
    library.XXH3_64bits_update.argtypes = [ctypes.c_void_p, ctypes.c_char_p, ctypes.c_size_t]
    library.XXH3_64bits_digest.argtypes = [ctypes.c_void_p]
    library.XXH3_64bits_digest.restype = ctypes.c_uint64
    library.XXH3_freeState.argtypes = [ctypes.c_void_p]
    library.XXH3_64bits.argtypes = [ctypes.c_char_p, ctypes.c_size_t]
    library.XXH3_64bits.restype = ctypes.c_uint64
    return library


def hash_bytes(content):
    """XXH3 of bytes, in the form of the receipts."""
    return f"{load_xxhash().XXH3_64bits(content, len(content)):016x}"


class Hashes:
    """64-bit XXH3 hashes of the present files, in the form of the receipts. Each file is read once."""

    def __init__(self):
        self._library, self.known = load_xxhash(), {}

    def of(self, path):
        """Returns None when the file is missing or unreadable."""
        if path not in self.known:
            try:
                self.known[path] = self._hash(path) if os.path.isfile(path) else None
            except OSError:
                self.known[path] = None
        return self.known[path]

    def _hash(self, path):
        state = self._library.XXH3_createState()
        try:
            self._library.XXH3_64bits_reset(state)
            with open(path, "rb") as file:
                while chunk := file.read(CHUNK_BYTES):
                    self._library.XXH3_64bits_update(state, chunk, len(chunk))
            return f"{self._library.XXH3_64bits_digest(state):016x}"
        finally:
            self._library.XXH3_freeState(state)


class Receipt:
    """A receipt under maps/<site>/<stage>/. The folders may have been moved since its run."""

    def __init__(self, path):
        self.path = Path(path)
        self.content = read_object(path, RECEIPT)
        report = self.path.name.replace("receipt", "report")
        outputs = [Path(entry["path"]) for entry in self.content["outputs"]]
        with using(path):
            self._root_then = outputs[[output.name for output in outputs].index(report)].parents[1]

    def changed(self, kind, hashes):
        """(path, present hash) of the changed `inputs` or `outputs`; the hash of a missing file is None."""
        for entry in self.content[kind]:
            if "xxh3" not in entry or "config/" in entry["path"]:
                continue
            path = Path(entry["path"])
            if path.is_relative_to(self._root_then):
                path = self.path.parents[1] / path.relative_to(self._root_then)
            digest = hashes.of(path)
            if digest != entry["xxh3"]:
                yield path, digest


class WrittenFiles:
    """Compares artifacts with the receipts of the jobs that wrote them, as the programs do with their inputs (written_inputs.h)."""

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
