# SPDX-License-Identifier: Apache-2.0
"""Cuts things out of the pictures of the recording."""

from PIL import ImageDraw

from nightmap_eval.pictures import jpeg, open_picture

WIDTH_PX = 220
MARGIN = 0.25  # around the thing, of its longer side
COLOR = (178, 24, 43)


def thumbnail(site, thing):
    """The part of its best view with the thing, framed."""
    def framed():
        if site.data is None or not thing.color_path:
            raise OSError("no file")
        with open_picture(site.data / thing.color_path) as picture:
            return cut_out(picture.convert("RGB"), thing.rectangle_px)

    return jpeg(framed, thing.color_path, "thumbnail")


def cut_out(picture, rectangle_px):
    """The rectangle with a margin and a frame around it, as far as the picture reaches, and no wider or higher than WIDTH_PX."""
    left, top, right, bottom = rectangle_px
    margin = round(MARGIN * max(right - left, bottom - top))
    outer = (max(0, left - margin), max(0, top - margin), min(picture.width, right + margin), min(picture.height, bottom + margin))
    if outer[0] >= outer[2] or outer[1] >= outer[3]:
        raise ValueError("the rectangle lies outside of the picture")
    picture = picture.copy()
    ImageDraw.Draw(picture).rectangle((left, top, right - 1, bottom - 1), outline=COLOR, width=max(1, (outer[2] - outer[0]) // 100))
    cut = picture.crop(outer)
    cut.thumbnail((WIDTH_PX, WIDTH_PX))
    return cut
