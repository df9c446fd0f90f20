# SPDX-License-Identifier: Apache-2.0
"""Two pictures side by side, with lines between what is the same in both: of loops, and of queries and the map."""

import numpy as np
from PIL import Image, ImageDraw

from nightmap_eval.artifacts import read_hdf5
from nightmap_eval.pictures import jpeg, open_picture
from nightmap_site.checked_reading import read_object, using

WIDTH_PX = 420  # of each picture
MAX_LINES = 40
GAP_PX = 6
LINE, DOT = (255, 176, 0), (255, 64, 64)


def pair_picture(data, paths, points, alt):
    """points: (n, 2) of each picture, as shares of its width and height, or None where nothing is known to be the same."""
    def draw():
        shown = [_small(data / path) for path in paths]
        whole = Image.new("RGB", (2 * WIDTH_PX + GAP_PX, max(picture.height for picture in shown)), (128, 128, 128))
        lefts = (0, WIDTH_PX + GAP_PX)
        for left, picture in zip(lefts, shown):
            whole.paste(picture, (left, 0))
        if points is not None and len(points[0]):
            chosen = np.linspace(0, len(points[0]) - 1, min(MAX_LINES, len(points[0]))).astype(int)
            ends = [np.asarray(of_one)[chosen] * picture.size + [left, 0] for of_one, picture, left in zip(points, shown, lefts)]
            _lines(ImageDraw.Draw(whole), *ends)
        return whole

    return jpeg(draw, alt, "pair")


def _small(path):
    with open_picture(path) as picture:
        picture = picture.convert("RGB")
    return picture.resize((WIDTH_PX, max(1, round(picture.height * WIDTH_PX / picture.width))))


def _lines(canvas, starts, ends):
    for (x, y), (u, v) in zip(starts, ends):
        canvas.line((x, y, u, v), fill=LINE)
        for a, b in ((x, y), (u, v)):
            canvas.ellipse((a - 2, b - 2, a + 2, b + 2), fill=DOT)


class Keypoints:
    """Keypoints of mapped frames, of one shard at a time, as shares of a picture's width and height."""

    def __init__(self, site):
        self.site, self.shard, self.sizes = site, None, _sizes_of_cameras(site)

    def of(self, frame_idx, camera_idx, shard):
        """(n, 2) of a frame; None where its features or its camera are not there."""
        path = self.site.made("features", "features", shard)
        if path is None or camera_idx >= len(self.sizes):
            return None
        if shard != self.shard:
            frames, first, pixels = read_hdf5(path, "frame_idx", "first_feature", "raw_keypoint_px")
            with using(path):
                self.first, self.pixels = first.ravel(), pixels.reshape(-1, 2)
                self.rows = {int(frame): row for row, frame in enumerate(frames.ravel())}
            self.shard = shard
        row = self.rows.get(frame_idx)
        return None if row is None else self.pixels[self.first[row] : self.first[row + 1]] / self.sizes[camera_idx]


def _sizes_of_cameras(site):
    path = site.made("frames", "cameras")
    if path is None:
        return []
    cameras = read_object(path, {"cameras": [{"color": {"width": int, "height": int}}]})["cameras"]
    return [np.array([camera["color"]["width"], camera["color"]["height"]], float) for camera in cameras]
