# SPDX-License-Identifier: Apache-2.0
"""Masks of what moves or can move, as a job writes them (pipeline/io/masks_io.h), and the labels that some were made of."""

import zlib

import numpy as np

from nightmap_eval.artifacts import read_csv, read_hdf5, shard_names
from nightmap_site.checked_reading import REMEDY, using
from nightmap_site.script_errors import DataError


def masking_job(site):
    """The job that masks the frames: moving, which finds what moves, or features, which labels what can."""
    return "moving" if site.has("moving") else "features"


def masked_frames(site):
    """(row of the list of frames, path of the file of masks, its arrays, index in them) of each frame with a mask, in order."""
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
