# SPDX-License-Identifier: Apache-2.0
"""Reads what `survey` measured of a sample of the frames."""

import numpy as np

from nightmap_eval.artifacts import read_csv, to_ints
from nightmap_site.checked_reading import NUMBER, REMEDY, read_object
from nightmap_site.script_errors import DataError

COLUMNS = ("brightness", "dark_share", "bright_share", "blur_px", "textured_share", "measured_share", "depth_p10_m", "depth_median_m",
           "depth_p90_m", "planar_share", "planar_share_otherwise", "same_color", "same_depth", "tracked_share", "flow_px", "gain")  # fmt: skip
WINDOW = {"num_edges": int, "by_frame_offset": [NUMBER], "at_best_shift": NUMBER, "at_no_shift": NUMBER}
REPORT = {"num_frames": int, "alignment": {"best_shift_x": NUMBER, "best_shift_y": NUMBER, "windows": [WINDOW]}}
FIXED_PARTS = {"fixed_parts": [{"camera_id": str, "share": NUMBER, "?mask": str}]}


class Survey:
    """Columns of frames.csv by name, one number per surveyed frame; NaN where a frame lacks it: without depth, or without a
    frame before it."""

    def __init__(self, site):
        path = site.path("survey", "frames")
        rows = read_csv(path, ("frame_idx", "time_ns", "sequence_idx", *COLUMNS))
        if not rows:
            raise DataError(f"{path}: no frames; {REMEDY}")
        self.frame_idxs = to_ints(rows, "frame_idx", path)
        self._columns = {name: _numbers(rows, name, path) for name in COLUMNS}
        alignment = read_object(site.path("survey", "report"), REPORT)["alignment"]
        self.best_shift = np.array([alignment["best_shift_x"], alignment["best_shift_y"]])
        windows = alignment["windows"]
        self.by_frame_offset = np.array([window["by_frame_offset"] for window in windows])
        self.at_best_shift = np.array([window["at_best_shift"] for window in windows])
        self.at_no_shift = np.array([window["at_no_shift"] for window in windows])

    def known(self, name):
        """The numbers of a column, without those that frames lack."""
        values = self._columns[name]
        return values[~np.isnan(values)]

    def share(self, name, holds):
        """Share of the numbers of a column for which holds(numbers) is true; 0 without any."""
        values = self.known(name)
        return float(np.mean(holds(values))) if len(values) else 0.0

    def column(self, name):
        return self._columns[name]


def _numbers(rows, name, path):
    try:
        return np.array([float(row[name]) if row[name] else np.nan for row in rows])
    except ValueError as error:
        raise DataError(f"{path}: column {name}: {error}; {REMEDY}") from None


def largest_fixed_part(site):
    """Part that stays in place in all pictures of a camera, of the camera of which it covers most: its camera_id, its share of the picture,
    and mask, the name of the proposed one beside frames.csv. None where nothing stays in place."""
    cameras = read_object(site.path("survey", "report"), FIXED_PARTS)["fixed_parts"]
    return max((camera for camera in cameras if "mask" in camera), key=lambda camera: camera["share"], default=None)
