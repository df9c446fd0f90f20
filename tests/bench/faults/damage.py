#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""damage: writes a damaged copy of a recording, to learn whether nightmap notices.

One fault by name, or "random": one to three faults of random strength, from nothing to severe. The same seed gives the same copy.
Exit codes: 0 written; 2 wrong command line.
"""

import argparse
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
from PIL import Image, ImageFilter

from recording import edited, read_recording, write_recording


# ---- pixels ----

def blurred(sigma_px):
    return lambda pixels: np.array(Image.fromarray(pixels).filter(ImageFilter.GaussianBlur(sigma_px)))


def brighter(gain):
    return lambda pixels: np.clip(pixels * gain, 0, 255).astype(np.uint8)


def paler(contrast):
    """Pictures of less contrast, as of white walls in even light."""
    soft = blurred(3)
    return lambda pixels: np.clip(soft(pixels).astype(float) * contrast + 200 * (1 - contrast), 0, 255).astype(np.uint8)


def moved(shift_px, scale):
    """Depth as of another camera beside the color camera."""

    def edit(pixels):
        height, width = pixels.shape
        x = np.rint((np.arange(width) - width / 2) / scale + width / 2 - shift_px).astype(int)
        y = np.rint((np.arange(height) - height / 2) / scale + height / 2).astype(int)
        inside = ((x >= 0) & (x < width))[None, :] & ((y >= 0) & (y < height))[:, None]
        return np.where(inside, pixels[np.clip(y, 0, height - 1)[:, None], np.clip(x, 0, width - 1)[None, :]], 0).astype(pixels.dtype)

    return edit


def with_holes(share, random):
    """Square holes."""

    def edit(pixels):
        size = max(4, pixels.shape[0] // 40)
        cells = random.random((pixels.shape[0] // size + 1, pixels.shape[1] // size + 1)) < share
        mask = np.kron(cells, np.ones((size, size), bool))[: pixels.shape[0], : pixels.shape[1]]
        return np.where(mask, 0, pixels).astype(pixels.dtype)

    return edit


def noisy(sigma_share, random):
    def edit(pixels):
        return np.clip(pixels * (1 + sigma_share * random.standard_normal(pixels.shape)), 0, 65535).astype(pixels.dtype)

    return edit


class Heights:
    """Heights of measured pixels above the lowest that a recording measures. One of the world's axes y and z is up: that
    which the cameras' y axes point down."""

    def __init__(self, recording):
        self.units_per_m = recording.value("depth_units_per_m")
        self.focal_px = np.array([recording.value("fx"), recording.value("fy")])
        self.center_px = np.array([recording.value("cx"), recording.value("cy")])
        self.times_s, self.poses = read_truth(recording.truth)
        points = np.concatenate([self._some_points(frame) for frame in recording.frames[::20]])
        points = points[np.isfinite(points).all(axis=1)]
        self.up = next(axis for axis in (2, 1) if self._is_up(axis))
        self.floor_m = np.quantile(points[:, self.up], 0.01)

    def _some_points(self, frame):
        depth = np.array(Image.open(frame.depth))
        step = max(1, len(depth) // 30)
        return self._world(depth[::step, ::step], frame.time_s, step).reshape(-1, 3)

    def _is_up(self, axis):
        """Whether cameras, whose y points down, agree that this axis of the world is up."""
        return np.mean(self.poses[:, axis, 1]) < -0.5

    def _world(self, depth, time_s, step=1):
        """Points (height, width, 3) in the world of the truth, NaN where nothing is measured."""
        pose = self.poses[np.argmin(np.abs(self.times_s - time_s))]
        y, x = np.mgrid[0 : depth.shape[0], 0 : depth.shape[1]] * step
        z = np.where(depth > 0, depth / self.units_per_m, np.nan)
        in_camera = np.stack([(x - self.center_px[0]) / self.focal_px[0] * z, (y - self.center_px[1]) / self.focal_px[1] * z, z], axis=-1)
        return in_camera @ pose[:, :3].T + pose[:, 3]

    def without_low(self, time_s, least_m):
        """An edit of a frame's depth: nothing lower than least_m above the floor is measured."""
        return lambda pixels: np.where(self._world(pixels, time_s)[..., self.up] - self.floor_m < least_m, 0, pixels).astype(pixels.dtype)


def read_truth(path):
    """Times in s, and world_from_camera (n, 3, 4)."""
    rows = np.array([line.split() for line in path.read_text(encoding="utf-8").splitlines() if line and not line.startswith("#")], float)
    x, y, z, w = (rows[:, i] for i in range(4, 8))
    rotations = np.stack([1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w), 2 * (x * y + z * w), 1 - 2 * (x * x + z * z),
                          2 * (y * z - x * w), 2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)], axis=1)  # fmt: skip
    return rows[:, 0], np.concatenate([rotations.reshape(-1, 3, 3), rows[:, 1:4, None]], axis=2)


class Walker:
    """An upright shape with a texture of its own that walks to and fro in front of the camera."""

    def __init__(self, random, width_share, period_frames):
        noise = Image.fromarray(random.integers(0, 256, (60, 24, 3), dtype=np.uint8))
        self.texture = np.array(noise.resize((240, 600), Image.Resampling.BICUBIC))
        self.width_share, self.period_frames = width_share, period_frames
        self.phase, self.distance_m = random.uniform(0, 2 * math.pi), random.uniform(0.8, 1.5)

    def mask(self, shape, number):
        """Where it is in frame `number`, and the column of its left edge."""
        height, width = shape[:2]
        center = width * (0.5 + 0.45 * math.sin(2 * math.pi * number / self.period_frames + self.phase))
        half = self.width_share * width / 2
        x, y = np.arange(width)[None, :], np.arange(height)[:, None] / height
        return (np.abs(x - center) < half * np.clip(4 * y, 0.35, 1)) & (y > 0.05), int(center - half)

    def color(self, number):
        def edit(pixels):
            mask, left = self.mask(pixels.shape, number)
            y, x = np.nonzero(mask)
            pixels = pixels.copy()
            pixels[y, x] = self.texture[y % 600, (x - left) % 240]
            return pixels

        return edit

    def depth(self, number, units_per_m):
        return lambda pixels: np.where(self.mask(pixels.shape, number)[0], self.distance_m * units_per_m, pixels).astype(pixels.dtype)


# ---- frames ----

def in_runs(num_frames, share, random, length=(5, 30)):
    """Whether each frame is in one of the runs that together have this share of the frames."""
    chosen = np.zeros(num_frames, bool)
    while chosen.sum() < share * num_frames:
        first = random.integers(num_frames)
        chosen[first: first + random.integers(*length)] = True
    return chosen


def edit_runs(recording, share, random, **edits):
    chosen = in_runs(len(recording.frames), share, random)
    recording.frames = [edited(frame, **edits) if run else frame for frame, run in zip(recording.frames, chosen)]


def edit_all(recording, **edits):
    recording.frames = [edited(frame, **edits) for frame in recording.frames]


def shift_depth(recording, num_frames):
    frames = recording.frames
    recording.frames = [replace(a, depth=b.depth, edit_depth=b.edit_depth) for a, b in zip(frames, frames[num_frames:])]


def scramble(recording):
    """The order of names sorted as text, with the times of a list in that order."""
    frames, times_s = recording.frames, [frame.time_s for frame in recording.frames]
    names = sorted(range(1, len(frames) + 1), key=str)
    recording.frames = [replace(frames[number - 1], time_s=time_s, name=str(number)) for number, time_s in zip(names, times_s)]


def freeze(recording, share, random):
    chosen = in_runs(len(recording.frames), share, random, (10, 40))
    result = []
    for frame, run in zip(recording.frames, chosen):
        result.append(replace(result[-1], time_s=frame.time_s) if run and result else frame)
    recording.frames = result


def cut(recording, num_gaps, share, random):
    num_frames = len(recording.frames)
    keep = np.ones(num_frames, bool)
    for first in random.integers(num_frames // 10, 9 * num_frames // 10, num_gaps):
        keep[first: first + max(1, int(share * num_frames))] = False
    recording.frames = [frame for frame, kept in zip(recording.frames, keep) if kept]


def repeat_times(recording, share, random):
    frames = recording.frames
    for i in np.flatnonzero(random.random(len(frames)) < share):
        if i > 0:
            frames[i] = replace(frames[i], time_s=frames[i - 1].time_s)


def scale_depth(recording, factor):
    """The factor of measured depth."""
    recording.scale("depth_units_per_m", 1 / factor)


def scale_focal(recording, factor):
    recording.scale("fx", factor)
    recording.scale("fy", factor)


def swap_channels(recording):
    recording.frames = [replace(frame, color=frame.depth, depth=frame.color) for frame in recording.frames]


def jump_exposure(recording, random):
    edit_runs(recording, 0.3, random, color=brighter(random.choice([0.35, 2.2])))


def hide_floor(recording, share, random):
    """Nothing lower than a table is measured in this share of the frames: the largest level surface is a table or a counter."""
    heights = Heights(recording)
    recording.frames = [edited(frame, depth=heights.without_low(frame.time_s, 0.55)) if random.random() < share else frame
                        for frame in recording.frames]  # fmt: skip


def people(recording, share, random):
    """Walkers that cover about this share of the picture."""
    units_per_m = recording.value("depth_units_per_m")
    for walker in [Walker(random, share / 2, random.uniform(50, 120)) for _ in range(3)]:
        recording.frames = [edited(frame, walker.color(number), walker.depth(number, units_per_m))
                            for number, frame in enumerate(recording.frames)]  # fmt: skip


FAULTS = {
    "depth_x5": lambda recording, random: scale_depth(recording, 5),
    "depth_by_5": lambda recording, random: scale_depth(recording, 0.2),
    "color_depth_swapped": lambda recording, random: swap_channels(recording),
    "depth_shifted": lambda recording, random: shift_depth(recording, 3),
    "scrambled_order": lambda recording, random: scramble(recording),
    "blurred_30": lambda recording, random: edit_runs(recording, 0.3, random, color=blurred(4)),
    "frozen": lambda recording, random: freeze(recording, 0.15, random),
    "exposure_jump": jump_exposure,
    "unregistered_depth": lambda recording, random: edit_all(recording, depth=moved(25, 1.08)),
    "intrinsics_10": lambda recording, random: scale_focal(recording, random.choice([0.9, 1.1])),
    "low_texture": lambda recording, random: edit_runs(recording, 0.6, random, color=paler(0.15)),
    "gaps": lambda recording, random: cut(recording, 5, random.uniform(0.03, 0.06), random),
    "people": lambda recording, random: people(recording, 0.6, random),
    "duplicate_times": lambda recording, random: repeat_times(recording, 0.03, random),
    "counter_as_floor": lambda recording, random: hide_floor(recording, 0.9, random),
}


def strength(random, least, most):
    """Between the two, as many small ones as large ones."""
    return math.exp(random.uniform(math.log(least), math.log(most)))


def random_damage(recording, random):
    """Applies one to three kinds; returns a text that says which."""
    kinds = {
        "depth scale": lambda: _said(strength(random, 1.01, 5) ** random.choice([-1, 1]), lambda s: scale_depth(recording, s)),
        "depth shift": lambda: _said(int(random.integers(1, 5)), lambda s: shift_depth(recording, s)),
        "blur": lambda: _said(strength(random, 0.5, 6), lambda s: edit_runs(recording, random.uniform(0.05, 0.7), random, color=blurred(s))),
        "focal": lambda: _said(strength(random, 1.005, 1.25) ** random.choice([-1, 1]), lambda s: scale_focal(recording, s)),
        "principal point": lambda: _said(strength(random, 1, 60) * random.choice([-1, 1]), lambda s: recording.scale("cx", 1, s)),
        "drop": lambda: _said(random.uniform(0.05, 0.8), lambda s: _drop(recording, s, random)),
        "holes": lambda: _said(strength(random, 0.02, 0.9), lambda s: edit_all(recording, depth=with_holes(s, random))),
        "noise": lambda: _said(strength(random, 0.003, 0.08), lambda s: edit_all(recording, depth=noisy(s, random))),
        "exposure": lambda: _said(strength(random, 1.1, 4) ** random.choice([-1, 1]),
                                  lambda s: edit_runs(recording, random.uniform(0.05, 0.5), random, color=brighter(s))),
        "gaps": lambda: _said(strength(random, 0.003, 0.08), lambda s: cut(recording, int(random.integers(1, 6)), s, random)),
        "paleness": lambda: _said(strength(random, 0.05, 0.9), lambda s: edit_runs(recording, random.uniform(0.1, 0.8), random, color=paler(s))),
        "people": lambda: _said(strength(random, 0.05, 0.7), lambda s: people(recording, s, random)),
        "unregistered": lambda: _said(strength(random, 1, 40), lambda s: edit_all(recording, depth=moved(s, 1 + s / 400))),
    }  # fmt: skip
    names = random.choice(sorted(kinds), size=random.integers(1, 4), replace=False)
    return ", ".join(f"{name} {kinds[name]():.3g}" for name in names)


def _said(value, apply):
    apply(value)
    return value


def _drop(recording, share, random):
    recording.frames = [frame for frame in recording.frames if random.random() >= share]


def damage(fault, seed, site_toml, data, out, name):
    """Writes OUT/data/name and OUT/sites/name.toml; returns what was done."""
    recording, random = read_recording(site_toml, data), np.random.default_rng(seed)
    said = fault
    if fault == "random":
        said = random_damage(recording, random)
    elif fault != "clean":
        FAULTS[fault](recording, random)
    write_recording(recording, out / "data", out / "sites", name)
    return said


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("fault", choices=["clean", "random", *FAULTS])
    parser.add_argument("site_toml", type=Path, help="configs/sites/<site>.toml of a recording of layout tum")
    parser.add_argument("name", help="of the copy: OUT/data/<name> and OUT/sites/<name>.toml")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--data", type=Path, required=True, help="folder of the recordings")
    parser.add_argument("--out", type=Path, required=True, help="folder of the copy and its site config")
    arguments = parser.parse_args()
    print(damage(arguments.fault, arguments.seed, arguments.site_toml, arguments.data, arguments.out, arguments.name))


if __name__ == "__main__":
    main()
