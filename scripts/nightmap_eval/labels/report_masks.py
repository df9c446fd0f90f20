# SPDX-License-Identifier: Apache-2.0
"""Section of the report on what masks leave out: pictures with their masks, and shares over time."""

import numpy as np
from PIL import Image

from nightmap_eval import drawing, html
from nightmap_eval.labels.mask_accuracy import mask_of, masked_frames, masking_job
from nightmap_eval.pictures import jpeg, open_picture
from nightmap_site.checked_reading import read_object

NUM_PICTURES = 6
WIDTH_PX = 320
MUCH_PERCENT = 50  # of a picture; odometry hangs on what is left
OFTEN_PERCENT = 10  # of the frames
TINT, OPACITY = np.array([178, 24, 43]), 0.6


def sections(site, metrics):
    frames = list(masked_frames(site))
    if not frames:
        return [html.section("What moves", html.paragraph("No frame has a mask.", "note"))]
    shares = np.array([100 * mask_of(*frame[1:]).mean() for frame in frames])
    parts = [html.paragraph(f"{len(frames)} frames have masks; what moves takes {shares.mean():.1f} % of their pixels, and "
                            f"{shares.max():.0f} % at most. It is left out of poses and map.")]  # fmt: skip
    parts += _ghosts(site)
    often = 100 * np.mean(shares > MUCH_PERCENT)
    if often > OFTEN_PERCENT:
        parts.append(html.paragraph(f"{often:.0f} % of these frames are masked by more than half: their poses hang on little.", "failed"))
    figure, axes = drawing.line_axes((7.5, 2.2), "time (s)", "masked (%)")
    times_s = np.array([int(row["time_ns"]) for row, *_ in frames]) / 1e9
    axes.plot(times_s - times_s[0], shares, color=drawing.RED, lw=1)
    axes.set_ylim(0, 100)
    parts += [html.image(drawing.to_png(figure), "share of what moves over time"), *_pictures(site, frames, shares), *_accuracy(site, metrics)]
    return [html.section("What moves", *parts)]


def _ghosts(site):
    """Things that may move, stand still, and are gone at another time."""
    path = site.made("ghosts", "report")
    if path is None:
        return []
    report = read_object(path, {"num_regions": int, "num_ghosts": int})
    return [html.paragraph(f"{report['num_regions']} things in keyframes may move by their label and stand still. Poses use them. "
                           f"{report['num_ghosts']} of them are gone at another time, and the map is made without these.")]  # fmt: skip


def _pictures(site, frames, shares):
    """Those in which most moves, of equal stretches of the recording."""
    if site.data is None:
        return []
    chosen = [part[np.argmax(shares[part])] for part in np.array_split(np.arange(len(frames)), min(NUM_PICTURES, len(frames)))]
    return [html.Raw('<p>' + " ".join(_picture(site, frames[i]) for i in chosen) + "</p>")]


def _picture(site, frame):
    """A picture with its mask in red."""
    def tinted():
        with open_picture(site.data / frame[0]["color_path"]) as picture:
            mask = mask_of(*frame[1:])[..., None]
            color = np.asarray(picture.convert("RGB").resize(mask.shape[1::-1]), float)
        red = Image.fromarray(np.where(mask, OPACITY * TINT + (1 - OPACITY) * color, color).astype(np.uint8))
        red.thumbnail((WIDTH_PX, WIDTH_PX))
        return red

    return jpeg(tinted, frame[0]["color_path"])


def _accuracy(site, metrics):
    found = metrics.get("sections", {}).get(masking_job(site), {})
    if found.get("num_frames_with_truth", 0) == 0:
        return []
    of_people = [(f"Masked pixels of what may move, while it {does} (%)", found[key]) for does, key in
                 (("moves", "masked_of_moving_percent"), ("pauses", "masked_of_pausing_percent")) if found.get(key) is not None]  # fmt: skip
    return [html.table(("Masks against the true pictures of the recording", ""), [
        ("Frames", found["num_frames_with_truth"]),
        ("Recall: masked pixels of what moves (%)", found["recall_percent"]),
        ("Precision: masked pixels that move (%)", found["precision_percent"]),
        ("Intersection over union", found["iou"]), *of_people])]  # fmt: skip
