# SPDX-License-Identifier: Apache-2.0
"""A recording of layout "tum" with its site config, in memory: frames that can be damaged and written again."""

import re
import shutil
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from PIL import Image

MAX_GAP_S = 0.04  # between a color picture and its depth


@dataclass(frozen=True)
class Frame:
    """color, depth: source files; edit_*: what changes their pixels, in order. depth None: without."""

    time_s: float
    color: Path
    depth: Path
    edit_color: tuple = ()
    edit_depth: tuple = ()
    name: str = ""  # of the color file; empty: the frame's number


@dataclass
class Recording:
    """config: text of the site's config; truth: the file; frames: in order of time."""

    config: str
    truth: Path
    frames: list = field(default_factory=list)

    def value(self, key):
        return float(re.search(rf"(?m)^{key} = ([-+.\deE]+)", self.config).group(1))

    def scale(self, key, factor, offset=0.0):
        self.config = re.sub(rf"(?m)^({key}) = ([-+.\deE]+)", lambda found: f"{found[1]} = {float(found[2]) * factor + offset!r}", self.config)


def read_recording(site_toml, data):
    config = Path(site_toml).read_text(encoding="utf-8")
    root = re.search(r'(?m)^root = "(.*)"', config).group(1)
    folder = Path(data) / root
    depths = _lines(folder / "depth.txt")
    depth_times_s = np.array([time_s for time_s, _ in depths])
    frames = []
    for time_s, color in _lines(folder / "rgb.txt"):
        nearest = int(np.argmin(np.abs(depth_times_s - time_s)))
        if abs(depth_times_s[nearest] - time_s) <= MAX_GAP_S:
            frames.append(Frame(time_s, folder / color, folder / depths[nearest][1]))
    config = re.sub(r"(?ms)^\[\[query\]\].*?(?=^\[|\Z)", "", config)
    config = re.sub(r"(?m)^synthetic = true.*\n", "", config)
    return Recording(config, folder / "groundtruth.txt", frames)


def _lines(path):
    rows = [line.split() for line in path.read_text(encoding="utf-8").splitlines() if line and not line.startswith("#")]
    return [(float(row[0]), row[1]) for row in rows]


def write_recording(recording, data, sites, name):
    """Writes DATA/name and SITES/name.toml."""
    folder = Path(data) / name
    for channel in ("rgb", "depth"):
        (folder / channel).mkdir(parents=True, exist_ok=True)
    lists = {"rgb": [], "depth": []}
    for number, frame in enumerate(recording.frames):
        for channel, source, edits in (("rgb", frame.color, frame.edit_color), ("depth", frame.depth, frame.edit_depth)):
            path = folder / channel / f"{frame.name if channel == 'rgb' and frame.name else f'{number:06d}'}{'.png' if edits else source.suffix}"
            _write_picture(source, edits, path)
            lists[channel].append(f"{frame.time_s:.6f} {channel}/{path.name}\n")
    for channel, lines in lists.items():
        (folder / f"{channel}.txt").write_text("".join(lines), encoding="utf-8")
    shutil.copyfile(recording.truth, folder / "groundtruth.txt")
    Path(sites).mkdir(parents=True, exist_ok=True)
    config = re.sub(r'(?m)^root = ".*"', f'root = "{name}"', recording.config)
    (Path(sites) / f"{name}.toml").write_text(config, encoding="utf-8")


def _write_picture(source, edits, path):
    if not edits:
        shutil.copyfile(source, path)
        return
    pixels = np.array(Image.open(source))
    for edit in edits:
        pixels = edit(pixels)
    Image.fromarray(pixels).save(path, compress_level=1)


def edited(frame, color=None, depth=None):
    """The frame with one more edit of its color or depth."""
    return replace(frame, edit_color=frame.edit_color + ((color,) if color else ()), edit_depth=frame.edit_depth + ((depth,) if depth else ()))
