# SPDX-License-Identifier: Apache-2.0
"""Binary PLY files as stages write them."""

import os

import numpy as np

from nightmap_site.checked_reading import using

_TYPES = {
    "char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1", "short": "i2", "int16": "i2",
    "ushort": "u2", "uint16": "u2", "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4",
    "float": "f4", "float32": "f4", "double": "f8", "float64": "f8",
}  # fmt: skip


def _read_header(file):
    """(name, count, fields of numpy) of each element; a list is taken to be a triangle."""
    elements = []
    if file.readline().strip() != b"ply":
        raise ValueError("not a PLY file")
    for line in file:
        match line.decode("ascii", "replace").split():
            case ["format", "binary_little_endian", *_] | ["comment" | "obj_info", *_]:
                pass
            case ["element", name, count] if count.isdecimal() and len(count) < 19:
                elements.append((name, int(count), []))
            case ["property", "list", size, kind, name] if elements:
                elements[-1][2].extend([("num_" + name, "<" + _TYPES[size]), (name, "<" + _TYPES[kind], (3,))])
            case ["property", kind, name] if elements:
                elements[-1][2].append((name, "<" + _TYPES[kind]))
            case ["end_header"]:
                return elements
            case _:
                raise ValueError(f"not a valid line of the header of a binary_little_endian PLY: {line[:80]!r}")
    raise ValueError("truncated in the header")


def read_ply(path):
    """Vertices (n, 3) in metres and triangles (m, 3) of vertex indices (m = 0 for a cloud)."""
    with open(path, "rb") as file, using(path):
        elements = {name: _read_element(file, count, np.dtype(fields)) for name, count, fields in _read_header(file)}
        vertices = np.stack([elements["vertex"][axis] for axis in "xyz"], axis=1).astype(float)
        if not np.all(np.isfinite(vertices)):
            raise ValueError("NaN or infinity in a vertex")
        return vertices, _triangles(elements.get("face", ()), len(vertices))


def vertex_chunks(path, most):
    """The number of vertices, and an iterator over arrays of at most `most` vertices as the file has them, in order. The vertices must be
    its first element. Raises DataError, the iterator too."""
    with open(path, "rb") as file, using(path):
        [(name, count, fields), *_] = _read_header(file)
        if name != "vertex":
            raise ValueError(f"begins with {name}, not with vertices")
        row_type, start = np.dtype(fields), file.tell()
        _require(file, count, row_type)
    return count, _chunks(path, start, count, row_type, most)


def _chunks(path, start, count, row_type, most):
    with open(path, "rb") as file:
        file.seek(start)
        for first in range(0, count, most):
            with using(path):
                yield _read_element(file, min(most, count - first), row_type)


def _read_element(file, count, row_type):
    _require(file, count, row_type)
    return np.frombuffer(file.read(count * row_type.itemsize), row_type)


def _require(file, count, row_type):
    """Before any memory is taken."""
    left, row_bytes = os.fstat(file.fileno()).st_size - file.tell(), row_type.itemsize
    if row_bytes == 0 or count * row_bytes > left:
        raise ValueError(f"truncated: {count} rows of {row_bytes} bytes, {left} bytes are left")


def _triangles(faces, num_vertices):
    if len(faces) == 0:
        return np.zeros((0, 3), dtype=int)
    size, name, *_ = faces.dtype.names
    triangles = faces[name].astype(int).reshape(-1, 3)
    if np.any(faces[size] != 3) or triangles.min() < 0 or triangles.max() >= num_vertices:
        raise ValueError("a face is not a triangle, or names a vertex out of range")
    return triangles
