# SPDX-License-Identifier: Apache-2.0
"""Compares the masks of what moves with the truth that the recording brings (`moving_folder`), pixel by pixel."""

import numpy as np

from nightmap_eval.mask_accuracy import overlap, read_truth
from nightmap_eval.masks import mask_of, masked_frames
from nightmap_site.script_errors import DataError


def evaluate(site):
    """Recall and precision over the frames in which something moves, and the share that is masked in the others."""
    counts, shares_of_others = np.zeros(3), []  # pixels: masked and moving, masked, moving
    num_moving = 0
    for row, *frame in masked_frames(site):
        if not row.get("moving_path") or site.data is None:
            continue
        mask = mask_of(*frame)
        truth = read_truth(site.data / row["moving_path"], mask.shape) != 0
        if truth.shape != mask.shape:
            raise DataError(f"{site.data / row['moving_path']}: its size is not that of the frame's mask")
        if not truth.any():
            shares_of_others.append(100 * mask.mean())
            continue
        num_moving += 1
        counts += [np.sum(mask & truth), np.sum(mask), np.sum(truth)]
    return {"num_frames_with_truth": num_moving + len(shares_of_others), "num_frames_with_motion": num_moving, **overlap(*counts),
            "masked_without_motion_percent": np.mean(shares_of_others) if shares_of_others else None}  # fmt: skip
