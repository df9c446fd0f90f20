# SPDX-License-Identifier: Apache-2.0
"""Reads odometry/ceiling_map.h5: landmarks of a ceiling, and what the filter said at each frame (pipeline/ceiling/ceiling_map_io.h)."""

from dataclasses import make_dataclass

import numpy as np

from nightmap_eval.artifacts import read_hdf5
from nightmap_site.checked_reading import REMEDY
from nightmap_site.script_errors import DataError

WITHOUT_ODOMETRY, SLIPPED = 1, 2  # bits of frame_flags
# name -> columns; 0: a list; 9: matrices (3, 3). The part before the first _ names what a row stands for.
ARRAYS = {
    "frame_time_ns": 0,
    "frame_pose": 3,  # x, y (m), heading (rad) by what was known at that frame
    "frame_covariance": 9,
    "frame_nis": 0,
    "frame_num_residuals": 0,  # degrees of freedom of frame_nis
    "frame_flags": 0,
    "anchor_pose": 3,  # by all that is known
    "landmark_position_m": 3,
    "landmark_covariance_m2": 9,
    "landmark_last_time_ns": 0,  # of the frame that saw it last
    "landmark_last_raw_px": 2,  # where
    "loop_anchors": 2,
}
CeilingMap = make_dataclass("CeilingMap", ARRAYS)  # its frame is the robot's at its start


def read_ceiling_map(path):
    arrays = {}
    num_rows = {}
    for (name, num_columns), array in zip(ARRAYS.items(), read_hdf5(path, *ARRAYS), strict=True):
        array = np.asarray(array)
        array = array.ravel() if num_columns == 0 else array.reshape(-1, num_columns) if array.size == 0 else array
        expected = array.shape[:1] if num_columns == 0 else (len(array), num_columns)
        kind = name.split("_")[0]
        if array.shape != expected or len(array) != num_rows.setdefault(kind, len(array)):
            raise DataError(f"{path}: array {name!r} has the shape {array.shape}; {REMEDY}")
        if not np.all(np.isfinite(array)):
            raise DataError(f"{path}: array {name!r} has NaN or infinity; {REMEDY}")
        arrays[name] = array.reshape(-1, 3, 3) if num_columns == 9 else array
    ends = arrays["loop_anchors"]
    if ends.size and not (0 <= ends.min() and ends.max() < num_rows["anchor"]):
        raise DataError(f"{path}: a loop ends at no anchor; {REMEDY}")
    return CeilingMap(**arrays)
