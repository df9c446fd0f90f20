# SPDX-License-Identifier: Apache-2.0
"""Compares what a network labelled as moving with the label pictures of the recording, pixel by pixel."""

import zlib

import numpy as np

from nightmap_eval.artifacts import read_csv, read_hdf5, shard_names
from nightmap_eval.pictures import read_labels
from nightmap_site.checked_reading import REMEDY, using
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


def masking_job(site):
    """The job that masks the frames: moving, which finds what moves, or features, which labels what can."""
    return "moving" if site.has("moving") else "features"


def masked_frames(site):
    """See pipeline/io/masks_io.h: (row of the list of frames, path of the file of masks, its arrays, index in them) of each frame with a mask, in order."""
    job = masking_job(site)
    for name in shard_names(site):
        path = site.made(job, "masks", name)
        if path is None:
            continue
        arrays = [np.ravel(array) for array in read_hdf5(path, "time_ns", "size_px", "run_offset", "run")]
        rows = {row["time_ns"]: row for row in read_csv(site.path(job, "frames", name), ("time_ns", "color_path"))}
        with using(path):
            for i, time_ns in enumerate(arrays[0]):
                yield rows[str(time_ns)], path, arrays, i


def mask_of(path, arrays, i):
    """Boolean image: where frame i shows what moves."""
    _, size_px, offset, run = arrays
    with using(path):
        width, height = size_px[2 * i:2 * i + 2]
        runs = run[offset[i]:offset[i + 1]]
        return np.repeat(np.arange(len(runs)) % 2 == 1, runs).reshape(height, width)


def labels_at(path, time_ns, shape):
    """Class and confidence (0 .. 255) of the pixels of a labelled frame."""
    packed = read_hdf5(path, *(f"{kind}/{time_ns}" for kind in ("labels", "confidences")))
    try:
        return [np.frombuffer(zlib.decompress(array.tobytes()), np.uint8).reshape(shape) for array in packed]
    except (ValueError, zlib.error) as error:
        raise DataError(f"{path}: labels of the frame at {time_ns}: {error}; {REMEDY}") from None
