# SPDX-License-Identifier: Apache-2.0
"""Damage to files: what power cuts, other programs and hostile people leave behind. Each function changes
one file in place; all draws come from the `random.Random` it is given."""
import contextlib
import os
import re
import socket
import struct
import zlib

import h5py
import numpy as np
from nightmap_eval.sealed_hdf5 import seal

WORDS = ("nan", "inf", "-1", "0", "1e308", "-1e308", "99999999999999999999", "2147483648", "4294967296", "",
         "../../outside/canary.txt", "/dev/zero", "$(shell touch owned)", "'; touch owned; '", "a\tb", "é", "\x00")
TEXT_SUFFIXES = (".csv", ".tum", ".json", ".toml", ".txt", ".yaml", ".g2o", ".mk", ".log")


def replace(path, content):
    """Writes a new file: the tree may share the old one with others by hard links."""
    path.unlink(missing_ok=True)
    path.write_bytes(content)


def truncate(draw, path):
    content = path.read_bytes()
    replace(path, content[:draw.randrange(len(content) + 1)])


def flip_bytes(draw, path):
    content = bytearray(path.read_bytes())
    for _ in range(draw.choice((1, 4, 64))):
        if content:
            content[draw.randrange(min(len(content), draw.choice((512, len(content)))))] = draw.randrange(256)
    replace(path, bytes(content))


def zero_tail(draw, path):
    content = path.read_bytes()
    kept = draw.randrange(len(content) + 1)
    replace(path, content[:kept] + bytes(len(content) - kept))


def append_garbage(draw, path):
    replace(path, path.read_bytes() + draw.randbytes(draw.choice((1, 100, 10000))))


def empty(draw, path):
    replace(path, b"")


def garbage(draw, path):
    replace(path, draw.randbytes(draw.choice((16, 1000, 100000))))


def replace_word(draw, path):
    """Another word for one of a text: a number, a name, a field."""
    text = path.read_text(encoding="utf-8", errors="surrogateescape")
    words = list(re.finditer(r"[^\s,:\[\]{}\"=]+", text))
    if words:
        word = draw.choice(words)
        text = text[:word.start()] + draw.choice(WORDS) + text[word.end():]
    replace(path, text.encode("utf-8", errors="surrogateescape"))


def shuffle_lines(draw, path):
    lines = path.read_bytes().split(b"\n")
    draw.shuffle(lines)
    replace(path, b"\n".join(lines))


def repeat_line(draw, path):
    lines = path.read_bytes().split(b"\n")
    line = draw.choice(lines)
    lines[draw.randrange(len(lines)):0] = [line] * draw.choice((1, 2, 50))
    replace(path, b"\n".join(lines))


def nest_deeply(draw, path):
    opening, closing = draw.choice((("[", "]"), ('{"a":', "}"), ("a = [", "]")))
    depth = draw.choice((200, 100000))
    replace(path, (opening * depth + closing * depth).encode())


def hostile_line(draw, path):
    """A line for whoever executes or follows what a list says."""
    lines = ("$(shell touch owned)", "include ../../outside/canary.txt", "all: ; touch owned", "SHARDS := 0000 ../x",
             "../../../outside/canary.txt", "1.0 rgb/../../../../outside/canary.txt", "tile=$(touch owned)")
    replace(path, path.read_bytes() + draw.choice(lines).encode() + b"\n")


LOG_LINES = ("FLASER 999999999 1 2 3", "FLASER 99999999999999999999 1", "FLASER -1 1 2 3 4 5 6 7 h 7", "FLASER 100000 1 2 3", "FLASER",
             "FLASER 0 1 2 3 4 5 6 1e9 h 1", "FLASER 2 1 2 1 2 3 4 5 6 1e300 h 1", "FLASER 2 nan inf 1 2 3 nan 5 6 3 h 3", "ODOM", "ODOM 1 2",
             "ODOM nan 0 0 0 0 0 1 h 1", "ODOM 1e9 0 0 0 0 0 1 h 1", "ODOM 0 0 0 0 0 0 -1e18 h 1", "ROBOTLASER1 0 0 0 0 0 0 0 4294967297 1",
             "FLASER " + "9" * 5000, "PARAM " + "x" * 100000, "\x00" * 1000)  # fmt: skip


def damage_log(draw, path):
    """Lines of a log of CARMEN that are none, that lie, or that say too much; -> what it did."""
    lines = path.read_bytes().split(b"\n")
    kind = draw.choice(("lines", "times", "counts", "words", "gzip"))
    if kind == "lines":
        for _ in range(draw.choice((1, 20, 2000))):
            lines.insert(draw.randrange(len(lines)), draw.choice(LOG_LINES).encode())
    elif kind == "gzip":
        packed = zlib.compressobj(wbits=31)
        content = packed.compress(path.read_bytes()) + packed.flush()
        replace(path, content[:draw.choice((10, len(content) // 2, len(content) - 1, len(content)))])
        return kind
    else:
        column, values = {"times": (-1, (b"0", b"-5", b"1e9", b"nan", b"1e300")), "counts": (1, (b"0", b"89", b"91", b"999999999")),
                          "words": (draw.choice((2, 5, -4)), (b"nan", b"inf", b"-1", b"1e308", b"x", b""))}[kind]  # fmt: skip
        for at in draw.sample(range(len(lines)), draw.choice((1, 5, len(lines)))):
            words = lines[at].split(b" ")
            places = (column - 2, column) if kind == "times" else (column,)
            for place in places:
                if -len(words) <= place < len(words):
                    words[place] = draw.choice(values)
            lines[at] = b" ".join(words)
    replace(path, b"\n".join(lines))
    return kind


CELLS = (b"", b"nan", b"inf", b"-1", b"1e308", b"x", b'"', b"1,2", b"9" * 400, b"\x00", b"0x1p3", b"1e-400")


def damage_table(draw, path):
    """Cells, columns and times of a CSV that lie or are missing; -> what it did."""
    rows = [line.split(b",") for line in path.read_bytes().split(b"\n")]
    kind = draw.choice(("cells", "times", "columns", "header", "short rows"))
    if kind == "header":
        rows[:1] = draw.choice(([], [rows[0], rows[0]], [[b"time_s"]], [[b"a", b"b"]], [[b"\xef\xbb\xbf" + rows[0][0], *rows[0][1:]]]))
    elif kind == "columns":
        rows = [row[draw.choice((1, 2)):] if draw.random() < 0.5 else row + row for row in rows]
    else:
        for at in draw.sample(range(1, len(rows)), draw.choice((1, 5, len(rows) - 1))):
            if kind == "short rows":
                rows[at] = rows[at][:draw.randrange(len(rows[at]) + 1)]
            else:
                rows[at][0 if kind == "times" else draw.randrange(len(rows[at]))] = draw.choice(CELLS)
    replace(path, b"\n".join(b",".join(row) for row in rows))
    return kind


YAML_LINES = ("image: [map.png]", "image: ../../outside/picture.png", "resolution: .nan", "resolution: -0.05", "resolution: 1e-300",
              "resolution: 1e300", "origin: [1e300, 0, 0]", "origin: [0, 0]", "origin: {x: 1}", "origin: [0, 0, 0, 0, 0, 0, 0, 0]",
              "negate: maybe", "negate: 2",
              "occupied_thresh: 0.1", "free_thresh: 7", "mode: raw", "mode: scale", "mode: none", "a: &a [*a, *a]", "? [1, 2]", "- x", "\t", "%YAML 3.0", "---",
              "...", "!!binary x", "image: !!python/object:os.system x", "&a image: *b", "<<: *a", "image: |", "  - - -")  # fmt: skip


def damage_yaml(draw, path):
    """Lines of a YAML that say something else, twice, or nothing; -> what it did."""
    lines = path.read_text(encoding="utf-8", errors="surrogateescape").split("\n")
    kind = draw.choice(("line added", "line replaced", "line gone", "all at once"))
    for _ in range({"all at once": 8}.get(kind, draw.choice((1, 2)))):
        at = draw.randrange(len(lines))
        lines[at : at + (kind != "line added")] = [] if kind == "line gone" else [draw.choice(YAML_LINES)]
        lines = lines or [""]
    replace(path, "\n".join(lines).encode("utf-8", errors="surrogateescape"))
    return kind


def _is_text(path):
    return path.suffix in TEXT_SUFFIXES


def damage(draw, path):
    """Any of the above that fits the file; -> its name."""
    if path.suffix == ".h5" and draw.random() < 0.7:
        return damage_hdf5(draw, path)
    kinds = [truncate, flip_bytes, zero_tail, append_garbage, empty, garbage]
    if _is_text(path):
        kinds += 2 * [replace_word, replace_word, shuffle_lines, repeat_line, nest_deeply, hostile_line]
    kind = draw.choice(kinds)
    kind(draw, path)
    return kind.__name__


# ---- HDF5 ---------------------------------------------------------------------------------------
def _attribute(draw, file):
    name = draw.choice(list(file.attrs) or ["version"])
    value = draw.choice((np.arange(4096), "variable length", np.array(["a", "b"], dtype="S5"), -1, 2**62, 1.5,
                         np.zeros(0), h5py.Empty("f"), np.array([("a", 1)], dtype="S4,i8"), np.bytes_(b"\xff\x00\xfe"), None))
    file.attrs.pop(name, None)
    if value is not None:
        file.attrs[name] = value
    return f"attribute {name}"


def _datasets(file):
    found = []
    file.visititems(lambda name, item: found.append(name) if isinstance(item, h5py.Dataset) else None)
    return found


def _dataset(draw, file):
    names = _datasets(file)
    if not names:
        return "no dataset"
    name = draw.choice(names)
    old = file[name][()]
    del file[name]
    kind = draw.choice(("missing", "type", "rank", "huge", "chunked", "link", "outward", "group", "values", "rows"))
    if kind == "type":
        file[name] = draw.choice((old.astype("f2"), old.astype("S4"), old.astype(">i8")))
    elif kind == "rank":
        file[name] = draw.choice((old.ravel(), old.reshape(1, *old.shape), old.sum()))
    elif kind == "huge":
        file.create_dataset(name, shape=(10**draw.choice((9, 12, 15)), old.shape[1] if old.ndim == 2 else 1), dtype=old.dtype)
    elif kind == "chunked":
        file.create_dataset(name, shape=(10**10, max(1, old.shape[-1])), dtype=old.dtype, chunks=(1024, 1), compression="gzip")
    elif kind == "link":
        file[name] = h5py.SoftLink("/" + name)
    elif kind == "outward":
        file[name] = h5py.ExternalLink("../../outside/canary.txt", "/x")
    elif kind == "group":
        file.create_group(name)
    elif kind == "rows":
        file[name] = old[:draw.randrange(len(old) + 1)]
    elif kind == "values" and old.size:
        flat = old.ravel().copy()
        extremes = (0, 1, 255) if old.dtype == np.uint8 else (-1, 2**31 - 1, -2**31, len(old))
        if old.dtype.kind == "f":
            extremes = (np.nan, np.inf, 1e30, -1e30)
        flat[draw.randrange(flat.size)] = draw.choice(extremes)
        file[name] = flat.reshape(old.shape)
    return f"dataset {name} {kind}"


def damage_hdf5(draw, path):
    copy = path.with_name("damaged.tmp")
    copy.write_bytes(path.read_bytes())
    with h5py.File(copy, "r+") as file:
        what = draw.choice((_attribute, _dataset))(draw, file)
        if draw.random() < 0.5:  # as a program that writes nonsense would leave it
            with contextlib.suppress(ValueError, TypeError):
                seal(file)
            what += " sealed"
    os.replace(copy, path)
    return what


# ---- other things than plain files --------------------------------------------------------------
def make_special(draw, path):
    """Something that is no plain file, at a path that is free; -> what it is."""
    kind = draw.choice(("fifo", "socket", "device", "folder", "dangling link", "looping link", "link to a device"))
    if kind == "fifo":
        os.mkfifo(path)
    elif kind == "socket":
        with socket.socket(socket.AF_UNIX) as server:
            folder = os.open(path.parent, os.O_RDONLY)
            server.bind(f"/proc/self/fd/{folder}/{path.name}")  # an address has room for 107 characters
            os.close(folder)
    elif kind == "device":
        try:
            os.mknod(path, 0o666 | 0o020000, os.makedev(1, 3))
        except PermissionError:  # only root makes devices
            os.mkfifo(path)
    elif kind == "folder":
        path.mkdir()
    else:
        path.symlink_to({"dangling link": "nothing/there", "looping link": path.name,
                         "link to a device": "/dev/null"}[kind])
    return kind


def write_bomb(path, size_px=30000):
    """A PNG of few bytes whose pixels take gigabytes once they are decoded."""
    def chunk(kind, body):
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))

    packer, row = zlib.compressobj(1), bytes(1 + 3 * size_px)
    rows = b"".join(packer.compress(row) for _ in range(size_px)) + packer.flush()
    header = struct.pack(">IIBBBBB", size_px, size_px, 8, 2, 0, 0, 0)
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", rows) + chunk(b"IEND", b""))
