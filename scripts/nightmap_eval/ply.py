# SPDX-License-Identifier: Apache-2.0
"""Reads binary PLY files as stages write them: vertices, and triangles when there are any."""

import os

import numpy as np

from nightmap_site.checked_reading import using
from nightmap_site.script_errors import DataError

_TYPES = {
    "char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1", "short": "i2", "int16": "i2",
    "ushort": "u2", "uint16": "u2", "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4",
    "float": "f4", "float32": "f4", "double": "f8", "float64": "f8",
}  # fmt: skip


def _read_header(path, file):
    """Format, and elements as (name, count, [property words])."""
    if file.readline().strip() != b"ply":
        raise DataError(f"{path}: not a PLY file")
    file_format, elements = "", []
    for line in file:
        match line.decode("ascii", "replace").split():
            case ["format", name, *_]:
                file_format = name
            case ["element", name, count] if count.isdecimal() and len(count) < 19:
                elements.append((name, int(count), []))
            case ["property", *words] if elements and len(words) in (2, 4):
                elements[-1][2].append(words)
            case ["end_header"]:
                return file_format, elements
            case ["format" | "element" | "property", *_]:
                raise DataError(f"{path}: not a valid line of a PLY header: {line[:80]!r}")
    raise DataError(f"{path}: truncated in the header")


def _row_type(path, properties):
    """numpy type of one element; a list is taken to be a triangle."""
    fields = []
    for words in properties:
        if words[0] == "list" and len(words) == 4 and words[1] in _TYPES and words[2] in _TYPES:
            fields += [("num_" + words[3], "<" + _TYPES[words[1]])]
            fields += [(words[3], "<" + _TYPES[words[2]], (3,))]
        elif words[0] in _TYPES and len(words) == 2:
            fields += [(words[1], "<" + _TYPES[words[0]])]
        else:
            raise DataError(f"{path}: unknown property type {words[0]}")
    names = [name for name, *_ in fields]
    if not names or len(set(names)) != len(names):
        raise DataError(f"{path}: an element without properties, or with two of one name")
    return np.dtype(fields)


def _read_element(path, file, count, row_type):
    left, row_bytes = os.fstat(file.fileno()).st_size - file.tell(), row_type.itemsize
    if count * row_bytes > left:  # before any memory is taken
        raise DataError(f"{path}: truncated: {count} rows of {row_bytes} bytes, {left} bytes are left")
    return np.frombuffer(file.read(count * row_bytes), row_type)


def read_ply(path):
    """Vertices (n, 3) in metres and triangles (m, 3) of vertex indices (m = 0 for a cloud)."""
    elements = {}
    with open(path, "rb") as file, using(path):
        file_format, declared = _read_header(path, file)
        if file_format != "binary_little_endian":
            raise DataError(f"{path}: format {file_format}; expected binary_little_endian")
        for name, count, properties in declared:
            elements[name] = _read_element(path, file, count, _row_type(path, properties))
    if "vertex" not in elements:
        raise DataError(f"{path}: no element vertex")
    with using(path):
        vertices = np.stack([elements["vertex"][axis] for axis in "xyz"], axis=1).astype(float)
    if not np.all(np.isfinite(vertices)):
        raise DataError(f"{path}: NaN or infinity in a vertex")
    with using(path):
        return vertices, _triangles(path, elements.get("face"), len(vertices))


def _triangles(path, faces, num_vertices):
    if faces is None or len(faces) == 0:
        return np.zeros((0, 3), dtype=int)
    if len(faces.dtype.names) < 2 or faces.dtype[1].shape != (3,):
        raise DataError(f"{path}: element face does not begin with a list of vertices")
    name = faces.dtype.names[1]
    triangles = faces[name].astype(int)
    if np.any(faces["num_" + name] != 3):
        raise DataError(f"{path}: a face is not a triangle")
    if triangles.min() < 0 or triangles.max() >= num_vertices:
        raise DataError(f"{path}: a face names a vertex out of range")
    return triangles
