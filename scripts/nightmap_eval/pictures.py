# SPDX-License-Identifier: Apache-2.0
"""Opens pictures of a recording for the report: of the formats that Pillow shares with the stages, and no others."""

from PIL import Image

FORMATS = ("PNG", "JPEG", "TIFF", "BMP", "PPM", "WEBP")


def open_picture(path):
    """A picture, to close after use. Raises OSError, also for a file of another kind: Pillow would open videos, and run programs."""
    if not path.is_file():  # opening a pipe would block
        raise OSError("no file")
    return Image.open(path, formats=FORMATS)
