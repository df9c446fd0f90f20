# SPDX-License-Identifier: Apache-2.0
"""Pictures of a recording: opened of the formats that Pillow shares with the stages, and no others; and their cameras."""

import io

import numpy as np
from PIL import Image

from nightmap_eval import html

FORMATS = ("PNG", "JPEG", "TIFF", "BMP", "PPM", "WEBP")
_SCALE_OF_BITS = {"L;2": 85, "L;4": 17}  # by which Pillow scales gray values of 2 and 4 bits
SIZE = {"?picture_width": int, "?picture_height": int}  # of a camera of cameras.json


def open_picture(path):
    """A picture, to close after use. Raises OSError, also for a file of another kind: Pillow would open videos, and run programs."""
    if not path.is_file():  # opening a pipe would block
        raise OSError("no file")
    return Image.open(path, formats=FORMATS)


def jpeg(draw, alt, css_class=""):
    """The picture that draw() returns, in the page, or a note: a missing picture must not prevent the report."""
    buffer = io.BytesIO()
    try:
        draw().save(buffer, "JPEG", quality=80)
    except Exception:  # on a damaged picture Pillow may raise any exception
        return html.Raw('<span class="note">no picture</span>')
    return html.image(buffer.getvalue(), alt, css_class, "image/jpeg")


def no_recordings():
    """A note in place of pictures."""
    return html.paragraph("The pictures are not shown: the folder of the recordings was not found; give it to make report as DATA.", "failed")


def read_labels(path):
    """The values of a label picture as stored, as an array; of a palette, the indices. Raises OSError."""
    with open_picture(path) as picture:
        raw_mode = next((tile[3] for tile in picture.tile), None)
        return np.asarray(picture) // _SCALE_OF_BITS.get(raw_mode, 1)


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
