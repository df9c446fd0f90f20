# SPDX-License-Identifier: Apache-2.0
"""Compares what a network labelled as moving with the label pictures of the recording, pixel by pixel."""

import numpy as np

from nightmap_eval.artifacts import read_hdf5
from nightmap_eval.labels.masks import labels_at, mask_of, masked_frames
from nightmap_eval.pictures import read_labels
from nightmap_site.script_errors import DataError

IGNORED = 255  # a pixel of which the truth says nothing


def evaluate(site):
    """Recall and precision over all pixels of the frames with a label picture; without the margin of the masks."""
    counts = np.zeros(3)  # labelled and true, labelled, true
    num_frames = 0
    for row, path, arrays, i in masked_frames(site):
        if not row.get("label_path") or site.data is None:
            continue
        labels_path = path.with_name(path.name.replace("masks_", "labels_"))
        moving = np.ravel(read_hdf5(labels_path, "moving")[0]).astype(bool)
        shape = mask_of(path, arrays, i).shape
        truth = read_truth(site.data / row["label_path"], shape)
        labels, _ = labels_at(labels_path, row["time_ns"], shape)
        if truth.shape != labels.shape or max(labels.max(), truth[truth != IGNORED].max(initial=0)) >= len(moving):
            raise DataError(f"{site.data / row['label_path']}: does not fit the labels of the frame; its classes must be those of the model")
        known = truth != IGNORED
        true, labelled = moving[np.where(known, truth, 0)] & known, moving[labels] & known
        counts += [np.sum(true & labelled), np.sum(labelled), np.sum(true)]
        num_frames += 1
    return {"num_frames_with_truth": num_frames, **overlap(*counts)}


def overlap(both, found, true):
    return {"recall_percent": 100 * both / true if true else None,
            "precision_percent": 100 * both / found if found else None,
            "iou": both / (found + true - both) if found + true else None}  # fmt: skip


def read_truth(path, shape):
    """The pixels of a picture of one channel; every so many of one that is larger than stages see it."""
    try:
        truth = read_labels(path)
    except OSError as error:
        raise DataError(f"{path}: {error}; give the recording its label pictures again") from None
    if truth.ndim != 2 or truth.shape[0] < shape[0] or truth.shape[1] < shape[1]:
        return truth
    rows, columns = ((2 * np.arange(size) + 1) * stored // (2 * size) for size, stored in zip(shape, truth.shape, strict=True))
    return truth[np.ix_(rows, columns)]
