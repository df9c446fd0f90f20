# SPDX-License-Identifier: Apache-2.0
"""The camera of the pictures as stored, which may be larger than stages see them (frames_io.h)."""

SIZE = {"?picture_width": int, "?picture_height": int}  # of a camera of cameras.json


def picture_camera(camera):
    """The color camera of a camera of cameras.json, at the size of its pictures. A lens's distortion applies to rays, and stays."""
    color = dict(camera["color"])
    for size, focal, center in (("width", "fx", "cx"), ("height", "fy", "cy")):
        stored = camera.get(f"picture_{size}")
        if stored is None:
            continue
        scale = stored / color[size]
        color |= {size: stored, focal: color[focal] * scale, center: (color[center] + 0.5) * scale - 0.5}
    return color
