# SPDX-License-Identifier: Apache-2.0
"""Measures a robot's way and the map that it made of a ceiling: the section.evaluation of the job `odometry` of the profile `ceiling`.

Counts always, and how well the innovations fit what the filter expects (NIS). Where frames wrote the robot's truth: errors
of the poses and those of the wheels alone, and whether the filter's covariances are honest (NEES). Where the exact ceiling
is known: errors of the landmarks.
"""

from nightmap_eval.artifacts import Frames, num_unusable_frames
from nightmap_eval.ceiling.ceiling_consistency import errors_then, nees_figures, nis_figures
from nightmap_eval.ceiling.ceiling_landmarks import landmark_figures
from nightmap_eval.ceiling.ceiling_map import SLIPPED, WITHOUT_ODOMETRY, read_ceiling_map
from nightmap_eval.ceiling.true_ceiling import read_true_ceiling
from nightmap_eval.planar_poses import first_pose_alignment, planar
from nightmap_eval.robot_accuracy import MAX_TRUTH_GAP_NS, TRUTH_REMEDY, robot_figures
from nightmap_eval.trajectory import interpolated, path_length_m, read_tum
from nightmap_eval.trajectory_errors import absolute_figures, coverage
from nightmap_eval.wheel_poses import read_wheels

RATIOS = (("position", "ate_rmse_m"), ("heading", "rotation_rmse_deg"))


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
