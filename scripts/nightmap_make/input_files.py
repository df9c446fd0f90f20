# SPDX-License-Identifier: Apache-2.0
"""The files of the recordings and of the queries, pictures or scans: whether they are there, and when one of them last changed.

A folder's time does not show that a file was replaced in place, so the sizes and both times of all files count: config/recordings
and config/pictures hold their number and hash. (The stages then compare contents: a touch reruns nothing after them.)
"""

import contextlib
import os
import struct

from nightmap_make.changed_files import digest, settle
from nightmap_make.site_configs import tables
from nightmap_site.toml_file import PipelineError

FILE_KEYS = ("mask", "ground_truth", "file", "scans", "trajectory", "relations")
OF_TRUTH = ("odometry", "trajectory", "relations")  # keys of [robot_truth]
BYTES_PER_FRAME = 50_000  # of a video whose container does not say how many it has
LISTS = ("rgb.txt", "associations.txt")  # of layout tum
COLOR = (".color.png", ".color.jpg")
PARENTS = (b"moov", b"trak", b"mdia", b"minf", b"stbl")  # boxes of MP4 that hold boxes


def file_state(path):
    """(path, size, modification time, change time) of a file, or the kind of error when it is not readable (a broken
    link, say). The frames stage decides whether that matters. The change time tells of a file replaced by one of the
    same size with its old modification time; a link, a chmod or a copy changes it too, and `frames` finds the same bytes."""
    try:
        status = os.stat(path)
    except OSError as error:
        return path, error.errno, 0, 0
    return path, status.st_size, status.st_mtime_ns, status.st_ctime_ns


def _folder_id(folder):
    """The identity that all paths of a folder share; None when it does not exist."""
    if not os.path.exists(folder):
        return None
    status = os.stat(folder)
    return status.st_dev, status.st_ino


def _recording_files(folder, seen):
    """The state of every file below a folder, without hidden ones. `seen` holds the folders visited: links may
    form a circle."""
    try:
        if _folder_id(folder) in seen:
            return
        seen.add(_folder_id(folder))
        entries = sorted(os.scandir(folder), key=lambda entry: entry.name)
    except OSError:
        yield file_state(folder) + ("not readable",)
        return
    for entry in entries:
        if entry.name.startswith("."):
            continue
        if _is_folder(entry):
            yield from _recording_files(entry.path, seen)
        else:
            yield file_state(entry.path)


def _is_folder(entry):
    try:
        return entry.is_dir()
    except OSError:  # a link to itself
        return False


def _picture_files(path):
    """The pictures of a folder, list or file, and cameras.csv beside them."""
    if os.path.isdir(path):
        try:
            names = [name for name in os.listdir(path) if not name.startswith(".")]
        except OSError as error:
            raise PipelineError(f"{path}: {error.strerror}: make the folder readable")
        return [file for file in (os.path.join(path, name) for name in names) if os.path.isfile(file)]
    names = ["cameras.csv"]
    if path.lower().endswith(".txt") and os.path.isfile(path):
        with open(path, encoding="utf-8", errors="surrogateescape") as file:
            names += [line.strip() for line in file if line.strip() and not line.lstrip().startswith("#")]
    beside = [os.path.join(os.path.dirname(path), name) for name in names]
    return [path] + [file for file in beside if os.path.isfile(file)]


class InputFiles:
    """The files that tables of the site's config name. name: "recordings" or "pictures"; root: that of the site's config."""

    def __init__(self, name, data, root, parts):
        def in_data(path):
            return os.path.join(data, os.path.normpath(os.path.join(root, path)))

        self.name, self._data = name, data
        self._pictures = {in_data(part["pictures"]) for part in parts if "pictures" in part}
        self._folders = {in_data(part.get("folder", ".")) for part in parts if not {"mask", "pictures", "scans", "file", *OF_TRUTH} & set(part)}
        self._extra = {in_data(part[key]) for part in parts for key in FILE_KEYS if part.get(key)}

    def check(self, site_name):
        for path in sorted(self._folders | self._extra | self._pictures):
            if not os.path.exists(path):
                raise PipelineError(f"site {site_name}: {path} does not exist. datasets.md says where to get each recording; "
                                  f"DATA={self._data} is the folder it is looked for in")  # fmt: skip

    def settle(self, request):
        """Writes the file whose time is that of the last change; returns its path."""
        maps = os.path.dirname(os.path.dirname(request.config_dir))
        states = {(os.path.relpath(path, self._data), *rest) for path, *rest in self._states(maps)}
        text = f"{len(states)} files {digest(repr(sorted(states)))}\n"
        current, target = os.path.join(request.config_dir, self.name), os.path.join(request.work_dir, self.name)
        settle(current, target, text)
        return target

    def _states(self, maps):
        """The state of each file. The folder of the results may lie inside a recording, and is no part of it."""
        files = {file_state(path) for path in self._extra.union(*map(_picture_files, self._pictures))}
        seen = {_folder_id(maps)} - {_folder_id(folder) for folder in self._folders}
        for folder in sorted(self._folders):
            files.update(_recording_files(folder, seen))
        return files


def input_files(request, sites):
    """Recordings and queries. Make itself handles a recording that synthesize makes, including its queries; synthesize
    makes neither plain pictures nor what QUERY names."""
    def named_by(name, site, parts):
        return InputFiles(name, request.data, site.get("root", "."), parts)

    _, site = sites["site"]
    masks = [camera for camera in tables(site, "camera", request.site) if camera.get("mask")]  # made by hand, also of a made-up recording
    if request.reads_recordings:
        parts = tables(site, "sequence", request.site) + tables(site, "signal", request.site) + ([site["robot_truth"]] if "robot_truth" in site else [])
        parts = masks + ([] if request.is_synthetic else parts)
        yield named_by("recordings", site, parts)
    _, site = sites["queries"]
    own = [query for query in tables(site, "query", request.site) if "pictures" in query or not request.is_synthetic]
    yield named_by("pictures", site, masks + own + sites["asked"][1]["query"])


def num_recorded_frames(site, data):
    """Sums the [[sequence]] tables of a site's config, for the estimate of the disk: from lists, names and headers of videos, without a
    pixel. Anything that cannot be read counts as no frames; the frames stage says what is wrong with it."""
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
