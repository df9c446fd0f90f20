# SPDX-License-Identifier: Apache-2.0
"""COLMAP's results of a fake site, written as COLMAP writes them, for tests without COLMAP."""

import json
import sqlite3
import struct

import numpy as np

from fake_site import moved, rotation_about
from nightmap_eval.trajectory import Trajectory, quaternion

# COLMAP's frame of reference and scale are its own.
TURN, SHIFT_M, UNITS_PER_METRE = rotation_about([3, 1, 2], 2.0), np.array([7.0, 8.0, -9.0]), 0.4


def in_colmaps_world(trajectory):
    turned = moved(trajectory, TURN, SHIFT_M)
    return Trajectory(turned.times_ns, UNITS_PER_METRE * turned.positions_m, turned.quaternions)


def image_bytes(image_id, name, rotation, position, num_observations, num_keypoints):
    x, y, z, w = quaternion(rotation.T)
    pose = [w, x, y, z, *(-rotation.T @ position)]
    keypoints = b"".join(
        struct.pack("<ddQ", 1.5, 2.5, i if i < num_observations else 2**64 - 1) for i in range(num_keypoints)
    )
    head = struct.pack("<I7dI", image_id, *pose, 1) + name.encode() + b"\0"
    return head + struct.pack("<Q", num_keypoints) + keypoints


def write_model(folder, names, trajectory, num_observations=50):
    """A model of images in the trajectory's frame of reference (world_from_camera), with 3 points."""
    folder.mkdir(parents=True)
    images = [
        image_bytes(i + 1, name, rotation, position, num_observations, num_observations + 5)
        for i, (name, rotation, position) in enumerate(zip(names, trajectory.rotations(), trajectory.positions_m))
    ]
    (folder / "images.bin").write_bytes(struct.pack("<Q", len(images)) + b"".join(images))
    (folder / "points3D.bin").write_bytes(struct.pack("<Q", 3) + bytes(129))
    (folder / "cameras.bin").write_bytes(bytes(8))


def write_receipt(folder, failed=None, parts=(), **figures):
    folder.mkdir(parents=True, exist_ok=True)
    receipt = {"format": "nightmap colmap receipt", "version": 1, "step": folder.name,
               "colmap": "COLMAP 3.8", "threads": 2, "failed": failed,
               "parts": [{"name": name, "wall_time_s": s} for name, s in parts], **figures}  # fmt: skip
    (folder / "receipt.json").write_text(json.dumps(receipt))


def write_database(path, names):
    """Cameras and images as COLMAP's database has them, without features and matches."""
    connection = sqlite3.connect(path)
    connection.executescript(
        "CREATE TABLE cameras (camera_id INTEGER PRIMARY KEY, model, width, height, params BLOB, prior);"
        "CREATE TABLE images (image_id INTEGER PRIMARY KEY, name TEXT, camera_id INTEGER);"
    )
    parameters = np.array([500.0, 501.0, 320.0, 240.0]).tobytes()
    connection.execute("INSERT INTO cameras VALUES (1, 1, 640, 480, ?, 1)", (parameters,))
    for i, name in enumerate(names, 1):
        connection.execute("INSERT INTO images VALUES (?, ?, 1)", (i, name))
    connection.commit()
    connection.close()
