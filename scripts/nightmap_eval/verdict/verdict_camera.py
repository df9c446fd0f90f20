# SPDX-License-Identifier: Apache-2.0
"""Checks of the cameras of the site config: whether their intrinsics are those of pictures of this size."""

import math

from nightmap_eval.picture_camera import SIZE, picture_camera
from nightmap_eval.verdict.verdict import check
from nightmap_site.checked_reading import NUMBER, read_object

COLOR = {"width": int, "height": int, "fx": NUMBER, "fy": NUMBER, "cx": NUMBER, "cy": NUMBER}
CAMERAS = {"cameras": [{"camera_id": str, "color": COLOR, **SIZE}]}
SAME = 0.05  # two scales that differ by less are one: principal points are within a few percent of the middle


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
