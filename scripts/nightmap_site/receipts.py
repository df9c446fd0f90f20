# SPDX-License-Identifier: Apache-2.0
"""Compares receipts with the files they name: finds altered outputs and changed inputs."""

import ctypes
import ctypes.util
import functools
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
