# SPDX-License-Identifier: Apache-2.0
"""Copies of a shard's artifacts, which differ in indices, looks (descriptors), noise, and points of the copy before."""

import numpy as np

NUM_CELLS = 128  # bytes of a RootSIFT descriptor
JOINT_SIGMA_PX = 0.5
NOISE_PX, NOISE_DESCRIPTOR, NOISE_DEPTH_RATIO = 0.3, 3.0, 0.002  # of a later visit
MIN_DEPTH_M = 0.3  # of a point in the next picture


def permutation(seed, copy):
    """The order of a copy's descriptor bytes: distances within the copy stay, those to other copies are large."""
    return np.arange(NUM_CELLS) if copy == 0 else np.random.default_rng([seed, copy]).permutation(NUM_CELLS)


def is_described(features):
    return features["reference_frame_idx"][:, 0] < 0


def rows_of(features, frame):
    """Rows of the features of the frame at this place, among all features of the shard."""
    return slice(*features["first_feature"][frame : frame + 2, 0])


def descriptor_rows(features, frame):
    """Likewise of its descriptors, among those of the described frames."""
    counts = np.diff(features["first_feature"][:, 0]) * is_described(features)
    end = np.cumsum(counts)[frame]
    return slice(end - counts[frame], end)


def shifted_features(features, shift):
    """The same features of frames that lie `shift` further on."""
    reference = features["reference_frame_idx"]
    return features.with_arrays(frame_idx=features["frame_idx"] + shift, reference_frame_idx=np.where(reference < 0, -1, reference + shift))


def shifted_pairs(pairs, shift):
    return pairs.with_arrays(frame=pairs["frame"] + shift)


def shifted_odometry(odometry, shift):
    return odometry.with_arrays(frame_idx=odometry["frame_idx"] + shift, edge_frame=odometry["edge_frame"] + shift,
                                observation=odometry["observation"] + np.array([0, shift, 0]))  # fmt: skip


def repainted(features, order, joined=None, joined_order=None):
    """The features with their descriptors' bytes in another order; those that the flags `joined` name have an order of their own."""
    descriptors = features["descriptor"][:, order]
    if joined is not None:
        descriptors[joined] = features["descriptor"][joined][:, joined_order]
    return features.with_arrays(descriptor=descriptors)


def noised(features, rng):
    """The features as another visit would see them: moved a little, with other noise of depth and descriptors."""
    shape = features["keypoint_px"].shape
    moved_px = rng.normal(0, NOISE_PX, shape)
    noise = np.rint(rng.standard_normal(features["descriptor"].shape, np.float32) * np.float32(NOISE_DESCRIPTOR))
    return features.with_arrays(
        keypoint_px=features["keypoint_px"] + moved_px, raw_keypoint_px=features["raw_keypoint_px"] + moved_px,
        depth_m=features["depth_m"] * (1 + rng.normal(0, NOISE_DEPTH_RATIO, features["depth_m"].shape)),
        descriptor=np.clip(features["descriptor"] + noise, 0, 255),
    )  # fmt: skip


def seen_from(features, frame, next_from_camera, source, rng):
    """Points of the frame at this place, as a camera at another pose sees them: (rows of the features, pixels, depths)."""
    rows = np.arange(rows_of(features, frame).start, rows_of(features, frame).stop)
    depths_m = features["depth_m"][rows, 0].astype(float)
    rays = np.c_[(features["keypoint_px"][rows] - source.centre_px) / source.focal_px, np.ones(len(rows))]
    points_m = (rays * depths_m[:, None]) @ next_from_camera[:3, :3].T + next_from_camera[:3, 3]
    ahead = np.flatnonzero((depths_m > 0) & (points_m[:, 2] > MIN_DEPTH_M))
    points_m = points_m[ahead]
    pixels = points_m[:, :2] / points_m[:, 2:] * source.focal_px + source.centre_px
    pixels += rng.normal(0, JOINT_SIGMA_PX, pixels.shape)
    inside = np.all((pixels >= 0) & (pixels <= source.size_px - 1), axis=1)
    return rows[ahead[inside]], pixels[inside], points_m[inside, 2]


def joined(features, before, cameras_from_last, source, rng):
    """Features of a shard whose described frames at these places also see, behind their own features, the points of the last frame
    of `before`; and a flag per descriptor: whether it is such a one. cameras_from_last: place in the shard -> pose of that frame."""
    last, is_joined = len(before["frame_idx"]) - 1, np.zeros(len(features["descriptor"]), bool)
    looks = before["descriptor"][descriptor_rows(before, last)]
    for frame in sorted(cameras_from_last, reverse=True):
        rows, pixels, depths_m = seen_from(before, last, cameras_from_last[frame], source, rng)
        depths_m = depths_m * (1 + rng.normal(0, NOISE_DEPTH_RATIO, len(rows)))
        scales_px = before["scale_px"][rows, 0] * before["depth_m"][rows, 0] / depths_m
        added = {"keypoint_px": pixels, "raw_keypoint_px": pixels, "scale_px": scales_px[:, None], "depth_m": depths_m[:, None]}
        at, described_at = rows_of(features, frame).stop, descriptor_rows(features, frame).stop
        arrays = {name: np.insert(features[name], at, values, axis=0) for name, values in added.items()}
        first_feature = features["first_feature"].copy()
        first_feature[frame + 1 :] += len(rows)
        is_joined = np.insert(is_joined, [described_at] * len(rows), True)
        descriptors = np.insert(features["descriptor"], described_at, looks[rows - rows_of(before, last).start], axis=0)
        features = features.with_arrays(**arrays, first_feature=first_feature, descriptor=descriptors)
    return features, is_joined
