# SPDX-License-Identifier: Apache-2.0
"""Measures a robot's way and the map that it made of a ceiling: the section.evaluation of the job `odometry` of the profile `ceiling`.

Counts always, and how well the innovations fit what the filter expects (NIS). Where frames wrote the robot's truth: errors
of the poses and those of the wheels alone, and whether the filter's covariances are honest (NEES). Where the exact ceiling
is known: errors of the landmarks.
"""

from dataclasses import make_dataclass

import numpy as np

from nightmap_eval.artifacts import Frames, num_unusable_frames, read_hdf5
from nightmap_eval.ceiling.ceiling_consistency import errors_then, nees_figures, nis_figures
from nightmap_eval.ceiling.true_ceiling import landmark_figures, read_true_ceiling
from nightmap_eval.planar_poses import first_pose_alignment, planar, read_wheels
from nightmap_eval.trajectory import interpolated, path_length_m, read_tum
from nightmap_eval.trajectory_errors import MAX_TRUTH_GAP_NS, TRUTH_REMEDY, absolute_figures, coverage, robot_figures
from nightmap_site.checked_reading import REMEDY
from nightmap_site.script_errors import DataError

RATIOS = (("position", "ate_rmse_m"), ("heading", "rotation_rmse_deg"))
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
CeilingMap = make_dataclass("CeilingMap", ARRAYS)  # see pipeline/ceiling/ceiling_map_io.h; its frame is the robot's at its start


def evaluate(site):
    estimate, ceiling_map = read_results(site)
    frames = Frames(site)
    figures = {"coverage": coverage(frames, estimate, num_unusable_frames(site))}
    figures |= counts(ceiling_map) | {"nis": nis_figures(ceiling_map)}
    wheels = read_wheels(site, frames.times_ns)
    if wheels is not None:
        figures["wheels"] = {"path_length_m": path_length_m(wheels.positions_m)}
    truth = true_frames(site, frames.times_ns)
    if truth is None:
        return figures
    figures["trajectory"], alignments = pose_figures(estimate, truth, len(frames.times_ns))
    if wheels is not None:
        figures["wheels"] |= wheel_figures(wheels, truth, figures["trajectory"], len(frames.times_ns))
    figures["nees"] = nees_figures(errors_then(ceiling_map, truth))
    ceiling = read_true_ceiling(site)
    if ceiling is not None:
        figures["landmarks"] = landmark_figures(site, ceiling_map, ceiling, alignments)
    return figures


def read_results(site, job="odometry"):
    """(trajectory by all that is known, ceiling map) of a job that makes them."""
    estimate = planar(read_tum(site.needed(job, "trajectory")))
    return estimate, read_ceiling_map(site.needed(job, "map"))


def true_frames(site, times_ns):
    """Planar true poses of the frames that have one; None without a truth."""
    if not site.robot_truth.exists():
        return None
    return planar(interpolated(read_tum(site.robot_truth, TRUTH_REMEDY), times_ns, MAX_TRUTH_GAP_NS)[1])


def counts(ceiling_map):
    return {
        "num_landmarks": len(ceiling_map.landmark_position_m),
        "num_anchors": len(ceiling_map.anchor_pose),
        "num_loops": len(ceiling_map.loop_anchors),
        "num_frames_with_slipping_wheels": int(((ceiling_map.frame_flags & SLIPPED) != 0).sum()),
        "num_frames_without_odometry": int(((ceiling_map.frame_flags & WITHOUT_ODOMETRY) != 0).sum()),
        "num_frames_without_landmark": int((ceiling_map.frame_num_residuals == 0).sum()),
    }


def pose_figures(estimate, truth, num_frames):
    """Figures of the frames with a true pose, and the alignments (truth_from_map) by name.

    start: the first common pose is the true one. se3, sim3: the alignment with the least error."""
    figures, pairs, alignments = robot_figures(estimate, truth, num_frames, "frames")
    matched, matched_truth = estimate.select(pairs[:, 1]), truth.select(pairs[:, 0])
    start = first_pose_alignment(matched, matched_truth)
    return figures | {"start": absolute_figures(matched, matched_truth, start)}, alignments | {"start": start}


def wheel_figures(wheels, truth, ours, num_frames):
    """The same figures of the wheels alone, and how many times larger their errors are than ours."""
    figures, _ = pose_figures(wheels, truth, num_frames)
    for alignment in ("start", "se3"):
        for name, key in RATIOS:
            if ours[alignment][key] > 0:
                figures[f"{name}_ratio_{alignment}"] = figures[alignment][key] / ours[alignment][key]
    return figures


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
