# SPDX-License-Identifier: Apache-2.0
"""Checks of how the frames of a map hang together: pairs, guessed motion, loops."""

import math

from nightmap_eval.artifacts import Frames, bridged_frames, frames_apart, num_unusable_frames
from nightmap_eval.verdict.verdict import check
from nightmap_site.checked_reading import read_object
from nightmap_site.job_results import StageResult

LOOPS = {"?num_loops_verified": int, "?num_loops_accepted": int}


def checks(site):
    if site.has_camera():
        yield from _frame_checks(site)
    report = read_object(site.path("pose_graph", "report"), LOOPS)
    verified = report.get("num_loops_verified", 0)
    if verified:
        refused = 100 * (verified - report.get("num_loops_accepted", 0)) / verified
        yield check("loops refused", refused, "%", (0, 75), "pairs that look alike and contradict the way between them: rooms furnished "
                    "alike, or a way that is wrong",
                    "{value:.0f} % of the loops contradict the odometry: look at the loops of the report")  # fmt: skip


def _frame_checks(site):
    num_frames = len(Frames(site)) + num_unusable_frames(site)
    lost = set(bridged_frames(site)) | set(frames_apart(site))
    mapped = 100 * (num_frames - len(lost) - num_unusable_frames(site)) / max(1, num_frames)
    yield check("frames mapped", mapped, "%", (95, 100), "frames whose motion was measured, and that hang together with the most",
                "only {value:.0f} % of the frames are in the map by measured motion: see the frames without a pose in the report; wrong "
                "intrinsics, depth of another scale or moment, blur and bare walls cause this", usable=(50, 100))  # fmt: skip
    yield from _depth_checks(site)
    yield from _pair_checks(site)


def _depth_checks(site):
    if not site.has("features"):
        return
    figures = StageResult(site.folder_of("features")).figures()
    if figures.get("num_features_with_depth"):
        share = 100 * figures["num_features_with_depth"] / max(1, figures.get("num_features", 0))
        yield check("features with depth", share, "%", (30, 100), "the motion is found by features whose depth is measured",
                    "only {value:.0f} % of the features have a depth: the sensor's range ends before what the camera sees, min_depth_m is too "
                    "large, or depth is not where the color is", usable=(5, 100))  # fmt: skip


def _pair_checks(site):
    if not site.has("matches"):
        return
    figures = StageResult(site.folder_of("matches")).figures()
    accepted = 100 * figures.get("num_accepted", 0) / max(1, figures.get("num_pairs", 0))
    yield check("pairs of frames accepted", accepted, "%", (70, 100), "frames in succession show the same place, and one motion explains "
                "their features and their depth",
                "no one motion explains {value:.0f} % of the pairs of frames in succession".replace("{value:.0f}", f"{100 - accepted:.0f}")
                + ": check intrinsics, depth_units_per_m, that depth belongs to its color, the order of frames, and what moves",
                usable=(25, math.inf))  # fmt: skip
