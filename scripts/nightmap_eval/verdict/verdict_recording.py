# SPDX-License-Identifier: Apache-2.0
"""Checks of a recording by its survey: what keeps a map of it from being good, before the map is made."""

import math
import re
from pathlib import PurePath

import numpy as np

from nightmap_eval.artifacts import Frames, read_csv, to_ints, truths_apart
from nightmap_eval.pictures import SIZE, picture_camera
from nightmap_eval.verdict.verdict import check, escaped
from nightmap_eval.verdict.verdict_depth import depth_checks
from nightmap_site.checked_reading import NUMBER, REMEDY, read_object
from nightmap_site.script_errors import DataError

BLUR_PX = 3.3  # sigma, as after a shift by 11 pixels; the sharpest octaves of features are gone then
GAIN = 1.6  # automatic exposure takes several frames for as much
COLOR = {"width": int, "height": int, "fx": NUMBER, "fy": NUMBER, "cx": NUMBER, "cy": NUMBER}
CAMERAS = {"cameras": [{"camera_id": str, "color": COLOR, **SIZE}]}
SAME = 0.05  # two scales that differ by less are one: principal points are within a few percent of the middle
COLUMNS = ("brightness", "dark_share", "bright_share", "blur_px", "textured_share", "measured_share", "depth_p10_m", "depth_median_m",
           "depth_p90_m", "planar_share", "planar_share_otherwise", "same_color", "same_depth", "tracked_share", "flow_px", "gain")  # fmt: skip
WINDOW = {"num_edges": int, "by_frame_offset": [NUMBER], "at_best_shift": NUMBER, "at_no_shift": NUMBER}
REPORT = {"num_frames": int, "alignment": {"best_shift_x": NUMBER, "best_shift_y": NUMBER, "windows": [WINDOW]}}
FIXED_PARTS = {"fixed_parts": [{"camera_id": str, "share": NUMBER, "?mask": str}]}
NUMBER_OF_NAME = re.compile(r"\d+(?:\.\d+)?(?!.*\d)")  # the last of a name
FEW_TRACKS, MANY_TRACKS = 0.15, 0.5
GAP_INTERVALS, GAP_S = 5, 0.4
USUAL = 0.75  # quantile of the intervals: where each frame is written twice, half of them are 1 ms


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


class Survey:
    """Columns of frames.csv by name, one number per surveyed frame; NaN where a frame lacks it: without depth, or without a
    frame before it."""

    def __init__(self, site):
        path = site.path("survey", "frames")
        rows = read_csv(path, ("frame_idx", "time_ns", "sequence_idx", *COLUMNS))
        if not rows:
            raise DataError(f"{path}: no frames; {REMEDY}")
        self.frame_idxs = to_ints(rows, "frame_idx", path)
        self._columns = {name: _numbers(rows, name, path) for name in COLUMNS}
        alignment = read_object(site.path("survey", "report"), REPORT)["alignment"]
        self.best_shift = np.array([alignment["best_shift_x"], alignment["best_shift_y"]])
        windows = alignment["windows"]
        self.by_frame_offset = np.array([window["by_frame_offset"] for window in windows])
        self.at_best_shift = np.array([window["at_best_shift"] for window in windows])
        self.at_no_shift = np.array([window["at_no_shift"] for window in windows])

    def known(self, name):
        """The numbers of a column, without those that frames lack."""
        values = self._columns[name]
        return values[~np.isnan(values)]

    def share(self, name, holds):
        """Share of the numbers of a column for which holds(numbers) is true; 0 without any."""
        values = self.known(name)
        return float(np.mean(holds(values))) if len(values) else 0.0

    def column(self, name):
        return self._columns[name]


def _numbers(rows, name, path):
    try:
        return np.array([float(row[name]) if row[name] else np.nan for row in rows])
    except ValueError as error:
        raise DataError(f"{path}: column {name}: {error}; {REMEDY}") from None


def largest_fixed_part(site):
    """Part that stays in place in all pictures of a camera, of the camera of which it covers most: its camera_id, its share of the picture,
    and mask, the name of the proposed one beside frames.csv. None where nothing stays in place."""
    cameras = read_object(site.path("survey", "report"), FIXED_PARTS)["fixed_parts"]
    return max((camera for camera in cameras if "mask" in camera), key=lambda camera: camera["share"], default=None)


def order_checks(survey, frames):
    lost = 100 * survey.share("tracked_share", lambda share: share < FEW_TRACKS)
    yield check("frames unlike the one before", lost, "%", (0, 5), f"less than {100 * FEW_TRACKS:.0f} % of the corners are seen again: "
                "the motion between these frames is not known",
                "{value:.0f} % of the frames show another place than the frame before: are they in the order of recording, and none left "
                "out? Else move slower, or record at a higher rate", usable=(0, 40))  # fmt: skip
    yield check("names against times", 100 * names_against_times(frames), "%", (0, 1), "recorders number pictures in the order of time",
                "at {value:.0f} % of the frames the number in the file's name goes down: " + _names_or_times(survey, frames))  # fmt: skip
    gaps = gaps_s(frames)
    yield check("gaps in time", len(gaps), "", (0, 0), f"longer than {GAP_INTERVALS} usual intervals and {GAP_S} s: the camera may have "
                "gone anywhere meanwhile",
                f"{{value:.0f}} gaps of up to {max(gaps, default=0):.1f} s: look for pictures that were lost in recording or copying")  # fmt: skip


def names_against_times(frames):
    """Share of the frames whose name has a smaller number than that of the frame before; 0 where names do not count."""
    goes_down, is_counted = _where_names_go_down(frames)
    return float(np.mean(goes_down[is_counted])) if is_counted.any() else 0.0


def _where_names_go_down(frames):
    """Per frame whether its name has a smaller number than that of the frame before, and whether both names count in one folder."""
    names = [PurePath(row["color_path"]) for row in frames.rows]
    found = [NUMBER_OF_NAME.search(name.stem) for name in names]
    numbers = np.array([float(match.group()) for match in found if match])
    if len(names) < 2 or len(set(numbers.tolist())) < len(names):
        return np.zeros((2, len(names)), bool)
    same = np.array([a.parent == b.parent for a, b in zip(names, names[1:])]) & (np.diff(frames.sequence_idxs) == 0)
    return np.array([[False, *(np.diff(numbers) < 0) & same], [False, *same]])


def _names_or_times(survey, frames):
    """The one of the two that the pictures support: frames in the order of recording show the same corners."""
    goes_down, _ = _where_names_go_down(frames)
    tracked = survey.column("tracked_share")[goes_down[np.searchsorted(frames.frame_idxs, survey.frame_idxs)]]
    tracked = tracked[~np.isnan(tracked)]
    if not len(tracked):
        return "look at these pictures in the order of time: where they jump, correct the times, else leave them"
    share = float(np.median(tracked))
    seen = f"{100 * share:.0f} % of the corners are seen again"
    if share >= MANY_TRACKS:
        return f"the pictures go on there ({seen}), so the times are right: leave them, and sort nothing by name"
    return (f"the pictures jump there ({seen}), so the times are wrong, as of names sorted as text (1, 10, 100, 2): correct the times, and "
            "sort nothing by them")


def gaps_s(frames):
    """Lengths of the gaps within sequences."""
    steps_s = _steps_s(frames)
    if np.isnan(steps_s).all():
        return []
    return steps_s[(steps_s > GAP_INTERVALS * _usual_interval_s(steps_s)) & (steps_s > GAP_S)].tolist()


def is_right_after(frames):
    """Whether each frame comes after less than half the usual interval."""
    steps_s = _steps_s(frames)
    return steps_s < (0 if np.isnan(steps_s).all() else _usual_interval_s(steps_s) / 2)


def _steps_s(frames):
    """Time since the frame before; NaN where a sequence begins."""
    together = np.diff(frames.sequence_idxs) == 0
    return np.concatenate([[np.nan], np.where(together, np.diff(frames.times_ns) / 1e9, np.nan)])


def _usual_interval_s(steps_s):
    return np.nanquantile(steps_s, USUAL)
