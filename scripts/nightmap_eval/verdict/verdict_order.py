# SPDX-License-Identifier: Apache-2.0
"""Checks of the times and the order of frames."""

import re
from pathlib import PurePath

import numpy as np

from nightmap_eval.verdict.verdict import check

NUMBER = re.compile(r"\d+(?:\.\d+)?(?!.*\d)")  # the last of a name
FEW_TRACKS, MANY_TRACKS = 0.15, 0.5
GAP_INTERVALS, GAP_S = 5, 0.4
USUAL = 0.75  # quantile of the intervals: where each frame is written twice, half of them are 1 ms


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
    found = [NUMBER.search(name.stem) for name in names]
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
