# SPDX-License-Identifier: Apache-2.0
"""Checks of depth: its scale, its holes, and whether it belongs to the colors of its frame."""

import math

import numpy as np

from nightmap_eval.verdict.verdict import check, unknown
from nightmap_site.checked_reading import NUMBER, read_object

MIN_FLOW_PX = 2  # of a picture 320 wide, per frame: less moves the edges too little
CAMERAS = {"cameras": [{"depth_units_per_m": NUMBER, "?depth_along_ray": bool}]}
SURE_OF_FRAME, SURE_OF_SHIFT = 4, 3  # standard errors between two means
MIN_GAIN = 1.05  # colors of another frame, or of shifted pixels, must agree so much better


def depth_checks(site, survey):
    if not len(survey.known("measured_share")):
        return
    units = " or ".join(sorted({f"{camera['depth_units_per_m'] or 1:g}" for camera in read_object(site.path("frames", "cameras"), CAMERAS)["cameras"]}))
    near_m, far_m = (float(np.median(survey.known(name))) if len(survey.known(name)) else 0.0 for name in ("depth_p10_m", "depth_p90_m"))
    yield check("near surfaces", near_m, "m", (0.2, 3.5), "a tenth of the depth pictures is nearer: indoors walls, floor or furniture are "
                "within 3.5 m, and no depth camera sees nearer than 0.2 m",
                f"the nearest tenth of depth lies at {{value:.2f}} m: is depth_units_per_m = {units} right?", usable=(0.1, 10))  # fmt: skip
    yield check("far surfaces", far_m, "m", (0.9, 8), "a tenth of the depth pictures is farther: rooms are larger than 0.9 m, and depth "
                "cameras for rooms reach 4 to 8 m",
                f"the farthest tenth of depth begins at {{value:.2f}} m: is depth_units_per_m = {units} right?", usable=(0.4, 20))  # fmt: skip
    yield check("depth measured", 100 * float(np.median(survey.known("measured_share"))), "%", (20, 100),
                "of the pixels of the median frame: motion is estimated by features with depth",
                "only {value:.0f} % of the depth pixels are measured: check the range of the sensor, sunlight and its projector")  # fmt: skip
    yield check("frames without depth", 100 * survey.share("measured_share", lambda share: share == 0), "%", (0, 5), "no pixel of their "
                "depth picture is measured: the motion at these frames is not known",
                "no depth measured in {value:.0f} % of the frames: sunlight, surfaces out of the sensor's range, or a covered projector")  # fmt: skip
    yield from _flatness_checks(site, survey)
    yield from _alignment_checks(survey)


def _flatness_checks(site, survey):
    shares = survey.known("planar_share")
    if not (shares > 0).any():
        yield unknown("flatness of depth", "walls and floors are flat", "too little depth to see a plane")
        return
    is_along_ray = any(camera.get("depth_along_ray", False) for camera in read_object(site.path("frames", "cameras"), CAMERAS)["cameras"])
    now, other = ("along the ray", "z") if is_along_ray else ("z", "along the ray")
    remedy = "remove depth_along_ray" if is_along_ray else "set depth_along_ray = true, as for depth that simulators give,"
    yield check("flatness of depth", float(np.sum(survey.known("planar_share_otherwise")) / np.sum(shares)), f"times that as {other}", (0, 1.1),
                f"share of the depth on the largest plane: walls and floors are flat if depth is {now}, as declared",
                f"depth lies on planes {{value:.2f}} times as much if it is {other} and not {now}: {remedy} in the [[camera]]",
                usable=(0, 1.3))  # fmt: skip


def _alignment_checks(survey):
    if len(survey.by_frame_offset) < 3:
        yield unknown("depth against color", "edges of depth are edges of the color picture", "too few frames for statistics")
        return
    offset = best_offset(survey.by_frame_offset)
    yield check("depth against color, frames", offset, "frames", (0, 0), "edges of depth are edges of the color picture of the same moment",
                "depth fits the color pictures {value:+.0f} frames away better: pair depth and color by time")  # fmt: skip
    yield check("depth against color, place", 100 * shift_of(survey), "% of the width", (0, 2), "edges of depth are edges of color at the "
                "same pixel",
                "depth fits colors {value:.1f} % of the picture's width away better: it is not registered to color: give the "
                "[[camera]] depth_registered = false and the depth camera's calibration, or register it")  # fmt: skip
    flow_px = survey.column("flow_px")[survey.column("same_color") == 0]  # a frame written twice does not tell of the camera's motion
    if not len(flow_px) or float(np.median(flow_px)) < MIN_FLOW_PX:
        return  # frames apart show the same
    yield check("color at edges of depth", own_agreement(survey.by_frame_offset), "times that of other frames", (1.25, math.inf),
                "edges of depth are edges of the colors of their own frame, and not of those three or four frames away",
                "colors change at the edges of depth hardly more than in other frames ({value:.2f} times): depth is not registered to "
                "color (depth_registered, the depth camera's calibration), or the pictures do not belong together")  # fmt: skip


def own_agreement(by_frame_offset):
    """Mean strength of colors at the edges of their own frame's depth, over that at the edges of frames far away."""
    mean = np.mean(by_frame_offset, axis=0)
    return float(mean[len(mean) // 2] / max(1e-9, np.mean(mean[[0, 1, -2, -1]])))


def is_better(scores, than, sure):
    """Whether the mean of scores per window is larger than another, beyond chance."""
    difference = scores - than
    error = np.std(difference, ddof=1) / math.sqrt(len(difference))
    return np.mean(scores) > MIN_GAIN * np.mean(than) and np.mean(difference) > sure * error


def best_offset(by_frame_offset):
    """Frames from depth to the colors that fit it best; 0 unless others fit better beyond chance."""
    middle = by_frame_offset.shape[1] // 2
    best = int(np.argmax(np.mean(by_frame_offset, axis=0)))
    return best - middle if is_better(by_frame_offset[:, best], by_frame_offset[:, middle], SURE_OF_FRAME) else 0


def shift_of(survey):
    """Length of the best shift as a share of the width; 0 unless it fits better beyond chance."""
    better = is_better(survey.at_best_shift, survey.at_no_shift, SURE_OF_SHIFT)
    return float(np.linalg.norm(survey.best_shift)) if better else 0.0
