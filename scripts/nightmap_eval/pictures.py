# SPDX-License-Identifier: Apache-2.0
"""Opens pictures of a recording for the report: of the formats that Pillow shares with the stages, and no others."""

import numpy as np
from PIL import Image

FORMATS = ("PNG", "JPEG", "TIFF", "BMP", "PPM", "WEBP")
_SCALE_OF_BITS = {"L;2": 85, "L;4": 17}  # by which Pillow scales gray values of 2 and 4 bits


def open_picture(path):
    """A picture, to close after use. Raises OSError, also for a file of another kind: Pillow would open videos, and run programs."""
    if not path.is_file():  # opening a pipe would block
        raise OSError("no file")
    return Image.open(path, formats=FORMATS)


def read_labels(path):
    """The values of a label picture as stored, as an array; of a palette, the indices. Raises OSError."""
    with open_picture(path) as picture:
        raw_mode = next((tile[3] for tile in picture.tile), None)
        return np.asarray(picture) // _SCALE_OF_BITS.get(raw_mode, 1)
