# SPDX-License-Identifier: Apache-2.0
"""Reads PLY files (ASCII or binary little endian): vertices, and triangles when there are any."""

import os

import numpy as np

from nightmap_eval.errors import DataError
from nightmap_eval.reading import using

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
        words = line.decode("ascii", "replace").split()
        if words[:1] == ["format"]:
            file_format = words[1]
        elif words[:1] == ["element"]:
            elements.append((words[1], int(words[2]), []))
        elif words[:1] == ["property"]:
            elements[-1][2].append(words[1:])
        elif words[:1] == ["end_header"]:
            return file_format, elements
    raise DataError(f"{path}: truncated in the header")


def _row_type(path, properties):
    """numpy type of one element; a list is taken to be a triangle."""
    fields = []
    for words in properties:
        if words[0] == "list":
            fields += [("num_" + words[3], "<" + _TYPES[words[1]])]
            fields += [(words[3], "<" + _TYPES[words[2]], (3,))]
        elif words[0] in _TYPES:
            fields += [(words[1], "<" + _TYPES[words[0]])]
        else:
            raise DataError(f"{path}: unknown property type {words[0]}")
    return np.dtype(fields)


def _read_element(path, file, file_format, count, row_type):
    if not 0 <= count <= os.fstat(file.fileno()).st_size:
        raise DataError(f"{path}: truncated: it has fewer bytes than the {count} rows that it declares")
    if file_format == "ascii":
        words = b" ".join(file.readline() for _ in range(count)).split()
        width = len(np.zeros(1, row_type)[0].item()) if count else 0
        width += 2 * sum(1 for name in row_type.names if row_type[name].shape)
        if len(words) != count * width:
            raise DataError(f"{path}: {len(words)} values where {count * width} are declared")
        return _rows_from_words(np.array(words, dtype=float).reshape(count, width), row_type)
    if file_format != "binary_little_endian":
        raise DataError(f"{path}: format {file_format}; expected ascii or binary_little_endian")
    data = file.read(count * row_type.itemsize)
    if len(data) != count * row_type.itemsize:
        raise DataError(f"{path}: truncated: {len(data)} bytes of {count * row_type.itemsize}")
    return np.frombuffer(data, row_type)


def _rows_from_words(table, row_type):
    rows, column = np.zeros(len(table), row_type), 0
    for name in row_type.names:
        width = row_type[name].shape[0] if row_type[name].shape else 1
        rows[name] = table[:, column : column + width] if width > 1 else table[:, column]
        column += width
    return rows


def read_ply(path):
    """Vertices (n, 3) in metres and triangles (m, 3) of vertex indices (m = 0 for a cloud)."""
    elements = {}
    with open(path, "rb") as file, using(path):
        file_format, declared = _read_header(path, file)
        for name, count, properties in declared:
            row_type = _row_type(path, properties)
            elements[name] = _read_element(path, file, file_format, count, row_type)
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
    name = faces.dtype.names[1]
    triangles = faces[name].astype(int)
    if np.any(faces["num_" + name] != 3):
        raise DataError(f"{path}: a face is not a triangle")
    if triangles.min() < 0 or triangles.max() >= num_vertices:
        raise DataError(f"{path}: a face names a vertex out of range")
    return triangles
