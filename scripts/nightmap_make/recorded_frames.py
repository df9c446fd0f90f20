# SPDX-License-Identifier: Apache-2.0
"""How many frames the recordings of a site have, for the estimate of the disk: from lists, names and headers of videos, without a
pixel. Anything that cannot be read counts as no frames; the frames stage says what is wrong with it."""

import contextlib
import os
import struct

BYTES_PER_FRAME = 50_000  # of a video whose container does not say how many it has
LISTS = ("rgb.txt", "associations.txt")  # of layout tum
COLOR = (".color.png", ".color.jpg")
PARENTS = (b"moov", b"trak", b"mdia", b"minf", b"stbl")  # boxes of MP4 that hold boxes


def num_recorded_frames(site, data):
    """Sums the [[sequence]] tables of a site's config."""
    root = os.path.join(data, site.get("root", "."))
    total = 0
    for sequence in site.get("sequence", []):
        count = COUNTS.get(str(sequence.get("layout")), lambda *_: 0)  # the frames stage refuses others
        with contextlib.suppress(KeyError, OSError, struct.error, RecursionError):
            total += count(os.path.join(root, sequence.get("folder", ".")), sequence)
    return total


def _num_listed_frames(folder, _sequence):
    name = next((name for name in LISTS if os.path.exists(os.path.join(folder, name))), LISTS[0])
    with open(os.path.join(folder, name), encoding="utf-8", errors="replace") as file:
        return sum(not line.lstrip().startswith("#") and not line.isspace() for line in file)


def _num_video_frames(folder, sequence):
    path = os.path.join(folder, sequence["video"])
    size = os.path.getsize(path)
    with open(path, "rb") as file:
        start = file.read(52)
        if start[:4] == b"RIFF" and start[8:12] == b"AVI ":
            return struct.unpack_from("<I", start, 48)[0]
        return _num_mp4_frames(file, size) or size // BYTES_PER_FRAME


def _num_mp4_frames(file, size):
    """Samples (stsz) of the tracks with a header of video (vmhd); 0 when there is none."""
    is_video, num_frames = False, 0
    for kind, start in _boxes(file, 0, size):
        if kind == b"tkhd":  # a track begins
            is_video = False
        elif kind == b"vmhd":
            is_video = True
        elif kind == b"stsz" and is_video:
            file.seek(start + 8)
            num_frames += struct.unpack(">I", file.read(4))[0]
    return num_frames


def _boxes(file, start, end):
    """(kind, start of the content) of each box that holds no boxes, in order."""
    while start + 8 <= end:
        file.seek(start)
        size, kind = struct.unpack(">I4s", file.read(8))
        header = 8
        if size == 1:
            size, header = struct.unpack(">Q", file.read(8))[0], 16
        size = size or end - start
        if size < header:
            return
        if kind in PARENTS:
            yield from _boxes(file, start + header, min(start + size, end))
        else:
            yield kind, start + header
        start += size


COUNTS = {"tum": _num_listed_frames, "seven_scenes": lambda folder, _: sum(name.endswith(COLOR) for name in os.listdir(folder)), "video": _num_video_frames}  # by layout of a recording
