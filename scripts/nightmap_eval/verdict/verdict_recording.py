# SPDX-License-Identifier: Apache-2.0
"""Checks of a recording by its survey: what keeps a map of it from being good, before the map is made."""

import math

import numpy as np

from nightmap_eval.artifacts import Frames, truths_apart
from nightmap_eval.picture_camera import SIZE, picture_camera
from nightmap_eval.survey import Survey, largest_fixed_part
from nightmap_eval.verdict.verdict import check, escaped
from nightmap_eval.verdict.verdict_depth import depth_checks
from nightmap_eval.verdict.verdict_order import is_right_after, order_checks
from nightmap_site.checked_reading import NUMBER, read_object

BLUR_PX = 3.3  # sigma, as after a shift by 11 pixels; the sharpest octaves of features are gone then
GAIN = 1.6  # automatic exposure takes several frames for as much
COLOR = {"width": int, "height": int, "fx": NUMBER, "fy": NUMBER, "cx": NUMBER, "cy": NUMBER}
CAMERAS = {"cameras": [{"camera_id": str, "color": COLOR, **SIZE}]}
SAME = 0.05  # two scales that differ by less are one: principal points are within a few percent of the middle


def checks(site):
    survey, frames = Survey(site), Frames(site)
    return [_fixed_parts_check(site), *_truth_checks(site), *camera_checks(site), *order_checks(survey, frames),
            *_picture_checks(survey), *_repeat_checks(survey, frames), *depth_checks(site, survey)]  # fmt: skip


def _truth_checks(site):
    for file, apart_s, what in truths_apart(site):
        yield check("ground truth apart from the frames", apart_s, "s", (0, 0), "from a frame to the nearest time of the truth that the "
                    "site config names: without a pose of the same time no accuracy can be measured",
                    escaped(f"{file} {what}"))  # fmt: skip


def _fixed_parts_check(site):
    part = largest_fixed_part(site)
    advice = "" if part is None else (
        f"{{value:.1f}} % of the picture of camera {escaped(part['camera_id'])} is the same in every view: a part of the robot, or a "
        f"border, which a map would take for the world. survey/{part['mask']} in the folder of the map is white there: look at it, copy it to "
        'mask.png in the root folder of the site config, and write mask = "mask.png" in the [[camera]]')  # fmt: skip
    return check("parts of the robot in the picture", 100 * part["share"] if part else 0.0, "% of the area", (-math.inf, 0),
                 "they stay in place while the camera moves, and say that it does not", advice, usable=(-math.inf, 10))  # fmt: skip


def _picture_checks(survey):
    def percent(name, holds):
        return 100 * survey.share(name, holds)

    yield check("blurred frames", percent("blur_px", lambda blur: blur > BLUR_PX), "%", (0, 15),
                f"edges blurred by a sigma over {BLUR_PX} px give few features, and inaccurate ones",
                "{value:.0f} % of the frames are blurred: move slower, give more light or a shorter exposure, or check the focus")  # fmt: skip
    jumps = percent("gain", lambda gain: np.abs(np.log(gain)) > math.log(GAIN))
    yield check("exposure jumps", jumps, "%", (0, 0.5), f"a lens's automatic exposure changes brightness by less than {GAIN} per frame",
                "brightness jumps at {value:.1f} % of the frames: fix exposure and gain while recording, or leave these frames out")  # fmt: skip
    yield check("dark frames", percent("dark_share", lambda share: share > 0.6), "%", (0, 10), "black pixels show no features",
                "{value:.0f} % of the frames are mostly black: record with more light or a longer exposure, or, if 16-bit pictures use fewer "
                "bits, as of infrared cameras, write their number as picture_bits in the [[camera]]")  # fmt: skip
    yield check("overexposed frames", percent("bright_share", lambda share: share > 0.5), "%", (0, 10), "white pixels show no features",
                "{value:.0f} % of the frames are mostly white: record with a shorter exposure")  # fmt: skip
    yield check("frames without texture", percent("textured_share", lambda share: share < 0.3), "%", (0, 15),
                "where less than a third of the picture has corners, motion is found by few points or none",
                "{value:.0f} % of the frames show hardly any texture: turn the camera from bare walls, or keep more of the room in view")  # fmt: skip


def _repeat_checks(survey, frames):
    same_color = survey.column("same_color")
    repeats = same_color[~np.isnan(same_color)] > 0
    is_copy = repeats & is_right_after(frames)[np.searchsorted(frames.frame_idxs, survey.frame_idxs[~np.isnan(same_color)])]
    frozen, copies = (100 * float(np.mean(which)) if len(repeats) else 0.0 for which in (repeats & ~is_copy, is_copy))
    yield check("frozen pictures", frozen, "%", (0, 1), "a sensor's noise differs from picture to picture, even where nothing moves",
                "{value:.0f} % of the frames repeat the picture before them: the recorder or the camera's driver stalled")  # fmt: skip
    yield check("copied frames", copies, "%", (0, 1), "that come in less than half the usual interval and show the same",
                "{value:.0f} % of the frames are a copy of the frame just before them: the recorder writes frames twice, and the map takes "
                "as much longer; leave the copies out")  # fmt: skip
    same_depth = survey.column("same_depth")
    known = ~np.isnan(same_depth)
    share = float(np.mean((same_depth[known] > 0) & (same_color[known] == 0))) if known.any() else 0.0
    yield check("frozen depth", 100 * share, "%", (0, 1), "as frozen pictures",
                "{value:.0f} % of the frames repeat the depth before them under a new picture: the depth camera stalled")  # fmt: skip


def camera_checks(site):
    for camera in read_object(site.path("frames", "cameras"), CAMERAS)["cameras"]:
        name, color = camera["camera_id"], picture_camera(camera)
        scale = scale_of_intrinsics(color)
        off_middle = max(abs(color["cx"] / color["width"] - 0.5), abs(color["cy"] / color["height"] - 0.5))
        if scale:
            likely = nearest_ratio(scale)
            scaled = ", ".join(f"{key} = {color[key] / likely:.6g}" for key in ("fx", "fy", "cx", "cy"))
            yield check(f"size of the pictures of camera {name}", scale, "times", (0.9, 1.1), "the picture that cx and cy are the middle "
                        "of, over width and height",
                        f"the intrinsics are of pictures {likely:.3g} times as large as width and height say: scale them too ({scaled})",
                        usable=(0.7, 1.4))  # fmt: skip
        else:
            yield check(f"principal point of camera {name}", 100 * off_middle, "% of the size", (0, 15), "from the middle of the picture, "
                        "where lenses put it unless pictures are cropped",
                        "cx, cy lie {value:.0f} % of the picture's size from its middle: are they of pictures of another size, in another "
                        "order, or were the pictures cropped?", usable=(0, 40))  # fmt: skip


def nearest_ratio(scale):
    """The ratio of small numbers that the scale is, but for a principal point off the middle; else the scale itself."""
    ratio = min((p / q for p in range(1, 5) for q in range(1, 5)), key=lambda ratio: abs(math.log(scale / ratio)))
    return ratio if abs(math.log(scale / ratio)) < SAME else scale


def scale_of_intrinsics(color):
    """How many times as large as declared the picture is whose middle the principal point is; None where its axes disagree."""
    across, down = (color[center] * 2 / color[size] for center, size in (("cx", "width"), ("cy", "height")))
    if min(across, down) <= 0 or abs(math.log(across / down)) > 2 * SAME:
        return None
    return math.sqrt(across * down)
