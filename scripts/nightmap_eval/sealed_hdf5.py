# SPDX-License-Identifier: Apache-2.0
"""The hashes in the HDF5 files of the stages (pipeline/io/hdf5_hashes.h): reads arrays that are as they were written, and seals files
that a script or a test writes."""

import os
from contextlib import contextmanager

import h5py
import numpy as np

from nightmap_site.receipts import hash_bytes

HASH = "xxh3"


def checked_array(path, file, name):
    """An array that a stage wrote; takes memory only for the values that the file holds."""
    array = file[name] if isinstance(file.get(name, getlink=True), h5py.HardLink) else None
    if not isinstance(array, h5py.Dataset):
        raise KeyError(f"no array {name!r}")
    if not _is_whole(array) or array.nbytes > os.path.getsize(path):
        raise ValueError(f"array {name!r} declares more than the file holds")
    values = array[()]
    if _hash_of(array) != _array_hash(name, values):
        raise ValueError(f"array {name!r} is not as it was written (its hash differs)")
    return values


def checked_text(file, name):
    """A text that a stage wrote beside the arrays."""
    if _text_line(file, name) not in _hash_of(file).splitlines():
        raise ValueError(f"text {name!r} is not as it was written (its hash differs)")
    return _text(file.attrs[name])


@contextmanager
def sealed(path, mode="w"):
    """An open file, whose arrays and texts get their hashes at the end."""
    with h5py.File(path, mode) as file:
        yield file
        seal(file)


def seal(file):
    """Gives its hash to each array that the file holds wholly."""
    arrays = []
    file.visititems(lambda name, item: arrays.append(item) if isinstance(item, h5py.Dataset) and _is_whole(item) else None)
    for array in arrays:
        array.attrs[HASH] = np.bytes_(_array_hash(array.name.lstrip("/"), array[()]))
    file.attrs[HASH] = np.bytes_("".join(f"{_text_line(file, name)}\n" for name in file.attrs if name != HASH))


def _hash_of(item):
    if HASH not in item.attrs:
        raise ValueError(f"{item.name!r} has no hash: an older nightmap or another program wrote the file")
    return _text(item.attrs[HASH])


def _is_whole(array):
    return array.chunks is None and array.nbytes == array.id.get_storage_size()


def _array_hash(name, values):
    """Lists of made-up files may have one dimension; those of the stages have two."""
    rows, cols = (*np.shape(values), 1, 1)[:2]
    return hash_bytes(f"{name} {rows} {cols} {hash_bytes(np.ascontiguousarray(values).tobytes())}".encode())


def _text_line(file, name):
    return f"{name} {hash_bytes(_text(file.attrs[name]).encode())}"


def _text(value):
    return value.decode() if isinstance(value, bytes) else str(value)
