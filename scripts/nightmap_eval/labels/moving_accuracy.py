# SPDX-License-Identifier: Apache-2.0
"""Compares the masks of what moves with the truth that the recording brings (`moving_folder`), pixel by pixel.

With the true labels too (`label_folder`), it tells those who move from those who pause: of the pixels of all classes that may move,
how many are masked while they do, and while they do not. A network says which classes may move; without one, those of which
something moves in the recording. Masks have a margin, and all of it counts as masked.
"""

import numpy as np

from nightmap_eval.artifacts import read_hdf5
from nightmap_eval.labels.mask_accuracy import IGNORED, mask_of, masked_frames, overlap, read_truth
from nightmap_site.script_errors import DataError

NONE = 0  # the label of what has no class


def evaluate(site):
    """Recall and precision over the frames in which something moves, the share that is masked in the others, and the shares of
    the pixels that are masked of who moves and of who pauses."""
    counts, shares_of_others = np.zeros(3), []  # pixels: masked and moving, masked, moving
    of_classes, may_move = np.zeros((2, 2, 256)), None  # pixels of each class: still or moving, and masked or not
    num_moving = 0
    for row, path, *frame in masked_frames(site):
        if not row.get("moving_path") or site.data is None:
            continue
        mask = mask_of(path, *frame)
        truth = _truth_of(site.data / row["moving_path"], mask.shape) != 0
        if row.get("label_path"):
            labels = np.minimum(_truth_of(site.data / row["label_path"], mask.shape), IGNORED)
            of_classes += np.bincount(((truth.astype(int) * 2 + mask) * 256 + labels).ravel(), minlength=1024).reshape(2, 2, 256)
            labelled = site.made("labels", "labels", path.stem.removeprefix("masks_"))  # none where no network labels the frames
            may_move = None if labelled is None else np.ravel(read_hdf5(labelled, "moving")[0]).astype(bool)
        if not truth.any():
            shares_of_others.append(100 * mask.mean())
            continue
        num_moving += 1
        counts += [np.sum(mask & truth), np.sum(mask), np.sum(truth)]
    return {"num_frames_with_truth": num_moving + len(shares_of_others), "num_frames_with_motion": num_moving, **overlap(*counts),
            "masked_without_motion_percent": np.mean(shares_of_others) if shares_of_others else None,
            **_masked_of(of_classes, may_move)}  # fmt: skip


def _truth_of(path, shape):
    truth = read_truth(path, shape)
    if truth.shape != shape:
        raise DataError(f"{path}: its size is not that of the frame's mask")
    return truth


def _masked_of(pixels, may_move):
    """Shares of the pixels of the classes that may move, of those that move now and of those that do not."""
    chosen = np.zeros(256, bool)
    if may_move is None:
        chosen = pixels[1].sum(axis=0) > 0
    else:
        chosen[:len(may_move)] = may_move[:len(chosen)]
    chosen[[NONE, IGNORED]] = False
    pausing, moving = (part[:, chosen].sum(axis=1) for part in pixels)
    return {f"masked_of_{name}_percent": 100 * masked / (masked + not_masked) if masked + not_masked else None
            for name, (not_masked, masked) in (("pausing", pausing), ("moving", moving))}  # fmt: skip
