# SPDX-License-Identifier: Apache-2.0
"""Measures what ceiling_adjust made of the filter's map: the section.evaluation of the job `adjust` of the profile `ceiling`.

The same figures of poses and landmarks as of the filter (ceiling_accuracy.py). Covariances are the filter's and not measured here.
"""

from nightmap_eval.artifacts import Frames, num_unusable_frames
from nightmap_eval.ceiling.ceiling_accuracy import pose_figures, read_results, true_frames
from nightmap_eval.ceiling.true_ceiling import landmark_figures, read_true_ceiling
from nightmap_eval.trajectory_errors import coverage

JOB = "adjust"


def evaluate(site):
    estimate, ceiling_map = read_results(site, JOB)
    frames = Frames(site)
    figures = {"coverage": coverage(frames, estimate, num_unusable_frames(site)),
               "num_landmarks": len(ceiling_map.landmark_position_m)}  # fmt: skip
    truth = true_frames(site, frames.times_ns)
    if truth is None:
        return figures
    figures["trajectory"], alignments = pose_figures(estimate, truth, len(frames.times_ns))
    ceiling = read_true_ceiling(site)
    if ceiling is not None:
        figures["landmarks"] = landmark_figures(site, ceiling_map, ceiling, alignments)
    return figures
