# SPDX-License-Identifier: Apache-2.0
"""Builds landmark maps of any size from real ones, to measure how localization time grows with the map.

A larger map is the real one with copies of real maps beside it, like further rooms of the same kind. The map
of another building is copied unchanged first. In all further copies, and in each of the site's own map, half of
each descriptor's cells come from another landmark, and each landmark gets the look of a third: the landmarks are
new points in new places, of which none is like the real one or its mirror image, but their cells, and so their
visual words, are distributed as in real maps.
"""

import shutil
from dataclasses import dataclass, replace

import h5py
import numpy as np

import checkout  # noqa: F401  first: it makes the packages of scripts/ importable
from nightmap_eval.artifacts import read_hdf5, read_landmarks
from nightmap_eval.sealed_hdf5 import sealed
from nightmap_site.script_errors import DataError

NORM = 512  # dimensions of a RootSIFT descriptor
CELLS = (4, 4, 8)  # rows, columns, orientations
APART_M = 1000.0  # gap between a map and the next copy
REGION_LANDMARKS = 250_000  # of a region of several maps, about
PIECE = 1 << 19  # descriptors whose words are computed at a time
FARTHEST_M = np.finfo(np.float64).max  # where a region has no bound


@dataclass
class SparseMap:
    """The arrays of landmarks.h5 that localization reads, except the words, which are computed again."""

    positions_m: np.ndarray
    sigmas_m: np.ndarray
    descriptors: np.ndarray
    landmark_idxs: np.ndarray  # of each descriptor, ascending
    poses: np.ndarray  # of the keyframes: tx ty tz qx qy qz qw
    seen: np.ndarray  # landmark, keyframe; ascending

    def __len__(self):
        return len(self.positions_m)

    def seen_per_keyframe(self):
        return len(self.seen) / len(self.poses)


def read_map(path):
    """Reads landmarks.h5; only SIFT's descriptors have cells."""
    kind, poses = read_hdf5(path, "kind", "keyframes/map_from_camera")
    if kind[0, 0] != 0:
        raise DataError(f"{path}: made with another detector than sift")
    positions_m, sigmas_m, offsets, keyframes, descriptors, idxs = read_landmarks(
        path, "landmarks/position_in_map_m", "landmarks/position_sigma_m", "observations/offsets",
        "observations/keyframe_idx", "descriptors/values", "descriptors/landmark_idx",
    )  # fmt: skip
    counts = np.diff(offsets.ravel())
    seen = np.column_stack([np.repeat(np.arange(len(counts)), counts), keyframes.ravel()])
    return SparseMap(positions_m, sigmas_m.ravel(), descriptors, idxs.ravel(), poses, seen)


def thin(sparse, count, rng):
    """`count` of the landmarks, drawn uniformly."""
    kept = np.zeros(len(sparse), dtype=bool)
    kept[rng.permutation(len(sparse))[:count]] = True
    new_idx = np.cumsum(kept) - 1
    rows, seen = kept[sparse.landmark_idxs], sparse.seen[kept[sparse.seen[:, 0]]]
    return SparseMap(
        sparse.positions_m[kept], sparse.sigmas_m[kept], sparse.descriptors[rows],
        new_idx[sparse.landmark_idxs[rows]], sparse.poses,
        np.column_stack([new_idx[seen[:, 0]], seen[:, 1]]),
    )  # fmt: skip


def shuffled(sparse, rng):
    """Gives each landmark the descriptors of another one: then no camera sees what one of the map before saw."""
    order = rng.permutation(len(sparse))
    of = np.empty_like(order)
    of[order] = np.roll(order, 1)  # never the landmark itself
    idxs = of[sparse.landmark_idxs]
    rows = np.argsort(idxs, kind="stable")
    return replace(sparse, descriptors=sparse.descriptors[rows], landmark_idxs=idxs[rows])


def mixed(sparse, rng):
    """Takes half of the cells of each landmark's descriptors from another landmark."""
    cells = sparse.descriptors.reshape(-1, 16, CELLS[2])
    first = np.searchsorted(sparse.landmark_idxs, np.arange(len(sparse)))
    order = rng.permutation(len(sparse))
    other = np.empty(len(sparse), dtype=first.dtype)
    other[order] = first[np.roll(order, 1)]  # never the landmark itself
    is_others = np.argsort(rng.random((len(sparse), 16)), axis=1) < 8
    of = sparse.landmark_idxs
    values = np.where(is_others[of][:, :, None], cells[other[of]], cells).reshape(-1, 128)
    norms = np.maximum(1, np.linalg.norm(values.astype(np.float32), axis=1, keepdims=True))
    descriptors = np.minimum(255, np.rint(values * (NORM / norms))).astype(np.uint8)
    return replace(sparse, descriptors=descriptors)


def moved(sparse, x_m):
    return replace(
        sparse,
        positions_m=sparse.positions_m + [x_m, 0, 0],
        poses=sparse.poses + [x_m, 0, 0, 0, 0, 0, 0],
    )


def joined(maps):
    """Joins several maps; indices of each follow those of the one before."""
    landmarks = np.cumsum([0, *map(len, maps)])
    keyframes = np.cumsum([0, *(len(part.poses) for part in maps)])
    return SparseMap(
        np.concatenate([part.positions_m for part in maps]),
        np.concatenate([part.sigmas_m for part in maps]),
        np.concatenate([part.descriptors for part in maps]),
        np.concatenate([part.landmark_idxs + n for part, n in zip(maps, landmarks)]),
        np.concatenate([part.poses for part in maps]),
        np.concatenate([part.seen + [n, k] for part, n, k in zip(maps, landmarks, keyframes)]),
    )


def pad(base, own, donors, count, rng):
    """`base`, which is thinned from `own`, plus copies of `donors` and `own` in turn, `count` landmarks in total.
    Each keyframe sees about as many landmarks as those of the base."""
    sources = [*donors, own]
    parts, missing = [base], count - len(base)
    while missing > 0:
        turn, number = divmod(len(parts) - 1, len(sources))
        source = sources[number]
        share = min(1.0, base.seen_per_keyframe() / source.seen_per_keyframe())
        part = thin(source, max(1, min(missing, round(share * len(source)))), rng)
        if turn > 0 or source is own:
            part = shuffled(mixed(part, rng), rng)
        parts.append(moved(part, APART_M * len(parts)))
        missing -= len(part)
    return joined(parts)


def word_paths(tree, descriptors):
    """Vocabulary nodes on the path of each descriptor, one per level, with the leaf repeated; as
    VocabularyTree::Path."""
    nodes, centres = tree["nodes"][:], tree["centres"][:].astype(np.float32)
    depth = int(tree["depth"][0, 0])
    pieces = np.split(descriptors, range(PIECE, len(descriptors), PIECE))
    return np.concatenate([_word_paths(nodes, centres, depth, piece) for piece in pieces])


def _word_paths(nodes, centres, depth, descriptors):
    values = descriptors.astype(np.float32)
    squares = np.einsum("ij,ij->i", centres, centres)
    at = np.zeros(len(values), dtype=np.int32)
    paths = np.empty((len(values), depth), dtype=np.int32)
    for level in range(paths.shape[1]):
        order = np.argsort(at, kind="stable")
        starts = np.flatnonzero(np.r_[True, np.diff(at[order]) > 0])
        for rows in np.split(order, starts[1:]):
            first, num_children, _ = nodes[at[rows[0]]]
            if num_children > 0:
                children = slice(first, first + num_children)
                # Integers below 2^24: exact, also as float.
                far = squares[children] - 2 * (values[rows] @ centres[children].T)
                at[rows] = first + np.argmin(far, axis=1)
        paths[:, level] = at
    return paths


def _put(file, name, values, dtype):
    values = np.asarray(values, dtype=dtype)
    if name in file:
        del file[name]
    file.create_dataset(name, data=values.reshape(len(values), -1), track_times=False)


def _put_regions(file, sparse, paths):
    """Regions of whole maps that were joined: these lie APART_M from each other in x, one after the other."""
    at = np.rint(sparse.positions_m[:, 0] / APART_M).astype(np.int64)
    starts = np.r_[0, np.flatnonzero(np.diff(at)) + 1]
    _, kept = np.unique(starts // REGION_LANDMARKS, return_index=True)
    firsts = np.r_[starts[kept], len(sparse)]
    bounds_m = np.r_[-FARTHEST_M, APART_M * (at[firsts[1:-1]] - 0.5), FARTHEST_M]
    whole = np.full(len(firsts) - 1, FARTHEST_M)
    _put(file, "regions/min_m", np.column_stack([bounds_m[:-1], -whole]), np.float64)
    _put(file, "regions/max_m", np.column_stack([bounds_m[1:], whole]), np.float64)
    _put(file, "regions/num_landmarks", np.diff(firsts), np.int64)
    rows = np.searchsorted(sparse.landmark_idxs, firsts)
    views = np.searchsorted(sparse.seen[:, 0], firsts)
    keyframes = [np.unique(sparse.seen[begin:end, 1]) for begin, end in zip(views, views[1:])]
    _put(file, "regions/keyframe_offsets", np.r_[0, np.cumsum([len(seen) for seen in keyframes])], np.int64)
    _put(file, "regions/keyframe_idx", np.concatenate(keyframes), np.int32)
    for i, first in enumerate(firsts[:-1]):
        own, of, seen = slice(first, firsts[i + 1]), slice(rows[i], rows[i + 1]), slice(views[i], views[i + 1])
        group = file.create_group(f"region_{i}")
        _put(group, "landmarks/position_in_map_m", sparse.positions_m[own], np.float64)
        _put(group, "landmarks/position_sigma_m", sparse.sigmas_m[own], np.float32)
        _put(group, "descriptors/values", sparse.descriptors[of], np.uint8)
        _put(group, "descriptors/landmark_idx", sparse.landmark_idxs[of] - first, np.int32)
        _put(group, "descriptors/words", paths[of], np.int32)
        counts = np.bincount(sparse.seen[seen, 0] - first, minlength=own.stop - first)
        _put(group, "observations/offsets", np.r_[0, np.cumsum(counts)], np.int64)
        _put(group, "observations/keyframe_idx", sparse.seen[seen, 1], np.int32)
        _put(group, "observations/feature_idx", np.zeros(views[i + 1] - views[i]), np.int32)


def write_map(template, vocabulary, sparse, num_base_keyframes, path):
    """Writes landmarks.h5 like `template` with the landmarks of `sparse`: regions of the base and its copies.
    Keyframes beyond the base's become new frames after those of `vocabulary` (an open file). Returns the words of the descriptors."""
    paths = word_paths(vocabulary["tree"], sparse.descriptors)
    num_added = len(sparse.poses) - num_base_keyframes
    num_frames = len(vocabulary["frames/word_offsets"]) - 1
    shutil.copyfile(template, path)
    with sealed(path, "r+") as file:
        frames = np.ravel(file["keyframes/frame_idx"])
        times_ns = np.ravel(file["keyframes/time_ns"])
        added = np.arange(num_added)
        _put(file, "keyframes/frame_idx", np.r_[frames, num_frames + added], np.int32)
        _put(file, "keyframes/time_ns", np.r_[times_ns, times_ns.max() + 1 + added], np.int64)
        _put(file, "keyframes/map_from_camera", sparse.poses, np.float64)
        for name in [name for name in file if name.startswith("region")]:
            del file[name]
        _put_regions(file, sparse, paths)
    return paths


def postings(offsets, words):
    """The inverted file of vocabulary.h5 over the words of frames: begins, frames and weights, as InvertedFile computes them."""
    num_frames = len(offsets) - 1
    frame_of = np.repeat(np.arange(num_frames), np.diff(offsets))
    keys, counts = np.unique(words.astype(np.int64) * num_frames + frame_of, return_counts=True)
    of_word, frames = np.divmod(keys, num_frames)
    sizes = np.bincount(of_word)
    idf = np.log((num_frames + 1) / np.maximum(sizes, 1)).astype(np.float32)
    weights = counts.astype(np.float32) * idf[of_word]
    norms = np.sqrt(np.bincount(frames, weights=weights.astype(np.float64) ** 2, minlength=num_frames))
    return np.r_[0, np.cumsum(sizes)], frames, weights / norms[frames].astype(np.float32)


def write_vocabulary(template, sparse, leaves, num_base_keyframes, path, rng):
    """Writes vocabulary.h5 like `template` with a new frame per added keyframe: the words of the landmarks it
    sees, filled up with words of the same map to the number of a real frame."""
    shutil.copyfile(template, path)
    with sealed(path, "r+") as file:
        offsets, words = np.ravel(file["frames/word_offsets"]), np.ravel(file["frames/words"])
        counts = np.diff(offsets)
        num_words = int(np.median(counts[counts > 0]))
        first = np.searchsorted(sparse.landmark_idxs, np.arange(len(sparse)))
        by_keyframe = sparse.seen[np.argsort(sparse.seen[:, 1], kind="stable")]
        ends = np.cumsum(np.bincount(by_keyframe[:, 1], minlength=len(sparse.poses)))
        added = []
        for rows in np.split(by_keyframe[:, 0], ends[:-1])[num_base_keyframes:]:
            own = leaves[first[rows]]
            others = leaves[rng.integers(len(leaves), size=max(0, num_words - len(own)))]
            added.append(np.r_[own, others])
        sizes = [len(frame) for frame in added]
        offsets = np.r_[offsets, offsets[-1] + np.cumsum(sizes, dtype=np.int64)]
        words = np.concatenate([words, *added])
        begins, frames, weights = postings(offsets, words)
        _put(file, "frames/word_offsets", offsets, np.int64)
        _put(file, "frames/words", words, np.int32)
        _put(file, "postings/begins", begins, np.int64)
        _put(file, "postings/frame_idx", frames, np.int32)
        _put(file, "postings/weight", weights, np.float32)
