# SPDX-License-Identifier: Apache-2.0
"""People cut out of photographs, as slightly round boards in a room: what a camera with depth sees of them. Pure.

A board is a rigid surface with the colors of its cut-out, seen by rays, so that color and depth agree from everywhere.
"""

import numpy as np
from scipy import ndimage

PERSON, PERSON_COLOR = 15, (192, 128, 128)  # of PASCAL VOC
SMALLEST_PX = 6000  # of a cut-out
ROUND_M = 0.06  # the middle of a board stands out by this
NEAREST_M = 0.3  # a camera sees nobody who is nearer
NOISE_M, NOISE_PER_M = 0.0015, 0.0015
MARGIN_PX = 16  # for distortion
NUM_STEPS = 5  # to where a ray meets a round board; each leaves a third of the error


def cut_outs(photograph, label):
    """RGBA pictures of all large groups of people in a photograph, by its label image."""
    groups, _ = ndimage.label(np.all(np.asarray(label.convert("RGB")) == PERSON_COLOR, axis=2))
    rgb, found = np.asarray(photograph.convert("RGB")), []
    for i, box in enumerate(ndimage.find_objects(groups), 1):
        mask = groups[box] == i
        if mask.sum() >= SMALLEST_PX:
            rgba = np.pad(np.dstack([rgb[box], 255 * mask]).astype(float), ((1, 1), (1, 1), (0, 0)), mode="edge")
            rgba[[0, -1], :, 3] = rgba[:, [0, -1], 3] = 0  # so that people fade out at their edges
            found.append(rgba)
    return found


def rays_of(width, height, fx, fy, cx, cy, distortion):
    """The ray of each pixel (height, width, 2), at depth 1; distortion as OpenCV has it: k1 k2 p1 p2 k3."""
    k1, k2, p1, p2, k3 = distortion
    x0, y0 = np.meshgrid((np.arange(width) - cx) / fx, (np.arange(height) - cy) / fy)
    x, y = x0, y0
    for _ in range(20):
        r2 = x * x + y * y
        factor = 1 + r2 * (k1 + r2 * (k2 + r2 * k3))
        x, y = ((x0 - 2 * p1 * x * y - p2 * (r2 + 2 * x * x)) / factor, (y0 - p1 * (r2 + 2 * y * y) - 2 * p2 * x * y) / factor)
    return np.stack([x, y], axis=-1)


def window(rays, corners_m):
    """The part of the picture in which corners (n, 3) in the camera's frame lie; all of it when one is behind."""
    height, width = rays.shape[:2]
    if corners_m[:, 2].min() < NEAREST_M:
        return np.s_[:, :]
    # Rays grow along rows and columns nearly evenly: the middle ones tell where a corner is.
    columns, rows = (np.searchsorted(axis, (corners_m[:, i] / corners_m[:, 2]).astype(float))
                     for i, axis in enumerate((rays[height // 2, :, 0], rays[:, width // 2, 1])))  # fmt: skip
    left, top = max(0, columns.min() - MARGIN_PX), max(0, rows.min() - MARGIN_PX)
    return np.s_[top : rows.max() + MARGIN_PX, left : columns.max() + MARGIN_PX]


def meet(rays, camera_m, person_from_camera, size_m):
    """Depth of each ray where it meets a board, and the place there in shares of the board's width and height."""
    directions = np.concatenate([rays, np.ones((*rays.shape[:2], 1))], axis=2) @ person_from_camera.T
    ahead = np.where(np.abs(directions[..., 2]) > 1e-6, directions[..., 2], 1e-6)
    depth_m = -camera_m[2] / ahead
    for _ in range(NUM_STEPS):
        u = 0.5 + (camera_m[0] + depth_m * directions[..., 0]) / size_m[0]
        depth_m = (-ROUND_M * (1 - (2 * np.clip(u, 0, 1) - 1) ** 2) - camera_m[2]) / ahead
    return depth_m, u, 0.5 + (camera_m[1] + depth_m * directions[..., 1]) / size_m[1]


def sampled(picture, u, v):
    """Bilinear values of a picture at these shares of its size; nothing outside."""
    height, width = picture.shape[:2]
    inside = (u >= 0) & (u <= 1) & (v >= 0) & (v <= 1)
    x, y = np.clip(u * width - 0.5, 0, width - 1.001), np.clip(v * height - 0.5, 0, height - 1.001)
    i, j = x.astype(int), y.astype(int)
    a, b = (x - i)[..., None], (y - j)[..., None]
    upper = picture[j, i] * (1 - a) + picture[j, i + 1] * a
    return (upper * (1 - b) + (picture[j + 1, i] * (1 - a) + picture[j + 1, i + 1] * a) * b) * inside[..., None]


class Board:
    """A cut-out, mapped on a rectangle."""

    def __init__(self, picture, length_m):
        """length_m: of its longer side."""
        self.picture, self.size_m = picture, np.array(picture.shape[1::-1]) / max(picture.shape[:2]) * length_m

    def paste(self, rays, camera_m, camera_rotation, pose, moves, frame, random):
        """Draws it into the arrays color, depth_m, label and moving of a frame. pose: as of a Way."""
        position_m, rotation = pose
        half = np.array([[x, y, 0] for x in (-0.5, 0.5) for y in (-0.5, 0.5)]) * [*self.size_m, 0]
        view = window(rays, (position_m + half @ rotation.T - camera_m) @ camera_rotation)
        depth_m, u, v = meet(rays[view], rotation.T @ (camera_m - position_m), rotation.T @ camera_rotation, self.size_m)
        values = sampled(self.picture, u, v)
        color, measured_m = frame["color"][view], frame["depth_m"][view]
        alpha = values[..., 3] / 255 * ((depth_m > NEAREST_M) & ((measured_m <= 0) | (measured_m > depth_m)))
        color += (alpha[..., None] * (values[..., :3] - color)).astype(color.dtype)
        solid = alpha > 0.5
        noise_m = random.normal(size=solid.shape) * (NOISE_M + NOISE_PER_M * depth_m**2)
        measured_m[solid] = (depth_m + noise_m)[solid]
        frame["label"][view][solid] = PERSON
        frame["moving"][view][solid] = 255 if moves else 0
