# SPDX-License-Identifier: Apache-2.0
"""A small site folder of a robot with an upward camera, for the tests of its evaluation and report.

Two rooms, 2.6 m high, with a doorway between them under a lintel of 2.1 m. The map's frame is the building's, turned and moved.
"""

import json

import numpy as np
from PIL import Image

import fake_site
from fake_site import write_tum
from nightmap_eval.planar_poses import compose, inverse, to_rows, to_trajectory
from nightmap_eval.sealed_hdf5 import sealed

NUM_FRAMES = 60
CAMERA = {"width": 640, "height": 480, "fx": 320.0, "fy": 320.0, "cx": 319.5, "cy": 239.5, "k1": 0.0, "k2": 0.0, "p1": 0.0, "p2": 0.0,
          "k3": 0.0}  # fmt: skip
CAMERA_HEIGHT_M = 0.35
RECTANGLES = ((0.0, -2.0, 4.0, 2.0, 2.6), (4.0, -0.5, 4.2, 0.5, 2.1), (4.2, -2.0, 8.0, 2.0, 2.6))  # x0 y0 x1 y1 height
ADJUSTMENT = {"num_keyframes": 30, "num_landmarks": 12, "median_error_px": 0.2, "ceiling_height_m": 2.6, "wheel_scale_error": 0.004,
              "wheel_heading_error_rad_per_m": 0.001}  # fmt: skip


def drive():
    """The truth: rows x, y, heading in the building: a round through the first room, then through the doorway."""
    turn = np.linspace(0, 2 * np.pi, NUM_FRAMES // 2, endpoint=False)
    rounds = np.column_stack([2 - np.cos(turn), np.sin(turn), np.pi / 2 - turn])
    straight = np.column_stack([np.linspace(1, 6, NUM_FRAMES // 2), np.zeros(NUM_FRAMES // 2), np.zeros(NUM_FRAMES // 2)])
    return np.concatenate([rounds, straight])


def times_ns():
    return 1_000_000_000 + np.arange(NUM_FRAMES, dtype=np.int64) * 100_000_000


def in_map(rows):
    """Rows of the building's frame in the map: the robot starts at its origin."""
    return compose(inverse(drive()[:1]), rows)


def points_in_map(points_m):
    rows = in_map(np.column_stack([points_m[:, :2], np.zeros(len(points_m))]))
    return np.column_stack([rows[:, :2], points_m[:, 2]])


def ceiling_points():
    """The true landmarks: points of the ceiling right above the robot and 0.3 m to its left, at every fifth frame."""
    rows = compose(drive()[::5], np.array([[0.0, 0.3, 0.0]]))
    heights_m = np.array([next((h for x0, y0, x1, y1, h in RECTANGLES if x0 <= x <= x1 and y0 <= y <= y1), np.nan) for x, y, _ in rows])
    return np.column_stack([rows[:, :2], heights_m])


def map_arrays():
    """Arrays of ceiling_map.h5 without an error."""
    points_m = ceiling_points()
    num = len(points_m)
    depths_m = points_m[:, 2] - CAMERA_HEIGHT_M
    pixels = np.column_stack([np.full(num, CAMERA["cx"]), CAMERA["cy"] + CAMERA["fy"] * 0.3 / depths_m])
    residuals = np.full(NUM_FRAMES, 8)
    residuals[:3] = 0
    flags = np.zeros(NUM_FRAMES, np.uint8)
    flags[4], flags[5:7] = 3, 2
    return {
        "frame_time_ns": times_ns(), "frame_pose": in_map(drive()),
        "frame_covariance": np.tile(np.diag([1e-4, 1e-4, 1e-5]).ravel(), (NUM_FRAMES, 1)),
        "frame_nis": np.full(NUM_FRAMES, 8.0), "frame_num_residuals": residuals.astype(np.int32), "frame_flags": flags,
        "anchor_pose": in_map(drive()[::20]),
        "landmark_position_m": points_in_map(points_m),
        "landmark_covariance_m2": np.tile(np.diag([1e-4, 1e-4, 1e-4]).ravel(), (num, 1)),
        "landmark_last_time_ns": times_ns()[::5], "landmark_last_raw_px": pixels.astype(np.float32),
        "loop_anchors": np.array([[2, 0]], np.int32),
    }  # fmt: skip


def write_ceiling_map(site_dir, arrays, job="odometry"):
    path = site_dir / job / "ceiling_map.h5"
    path.parent.mkdir(parents=True, exist_ok=True)
    with sealed(path) as file:
        for name, array in arrays.items():
            file[name] = array


def write_mosaic(site_dir):
    """A gray picture of 4 x 2 m."""
    folder = site_dir / "mosaic"
    folder.mkdir()
    Image.new("RGB", (40, 20), (90, 90, 90)).save(folder / "mosaic.png")
    (folder / "mosaic.pgw").write_text("0.1\n0\n0\n-0.1\n-0.95\n1.95\n")
    (folder / "report.json").write_text(json.dumps({"num_views": 3, "covered_m2": 23.5, "median_deviation": 2.0}))


def write_wheels(site_dir, *sensors):
    """odometry.h5 of wheels at the robot's origin: rows of each sensor, with a sample at each frame."""
    with sealed(site_dir / "frames" / "odometry.h5") as file:
        for i in range(len(sensors)):
            file.attrs[f"sensor_{i}"] = f"wheels_{i}"
        file["robot_from_sensor"] = np.tile([0.0, 0, 0, 0, 0, 0, 1], (len(sensors), 1))
        file["sample_offset"] = np.cumsum([0, *map(len, sensors)])[:, None]
        file["time_ns"] = np.concatenate([times_ns()[: len(rows), None] for rows in sensors])
        file["value"] = np.concatenate(sensors)


def write_estimate(site_dir, rows, kept=slice(None), job="odometry"):
    write_tum(site_dir / job / "trajectory.tum", to_trajectory(times_ns(), rows).select(np.arange(NUM_FRAMES)[kept]))


def write_true_ceiling(data, site_dir):
    """truth/ceiling.json and the camera's way, in the folder that the site config names."""
    config = site_dir / "config" / "site" / f"{site_dir.name}.toml"
    config.parent.mkdir(parents=True)
    config.write_text('root = "built"\n')
    (data / "built" / "truth").mkdir(parents=True)
    rectangles = [dict(zip(("x0", "y0", "x1", "y1", "height_m"), values)) for values in RECTANGLES]
    (data / "built" / "truth" / "ceiling.json").write_text(json.dumps({"rectangles": rectangles}))
    camera = to_trajectory(times_ns(), drive())
    camera.positions_m[:, 2] = CAMERA_HEIGHT_M
    write_tum(data / "built" / "camera_groundtruth.txt", camera)


def write_site(site_dir, data):
    """A site without errors, of the profile `ceiling`; returns the rows of its estimate."""
    truth = to_trajectory(times_ns(), drive())
    (site_dir / "config").mkdir(parents=True)
    (site_dir / "config" / "profile.toml").write_text('profile = "ceiling"\nimports = []\n')
    fake_site.write_frames(site_dir, truth)
    (site_dir / "frames" / "cameras.json").write_text(json.dumps({"cameras": [{"color": CAMERA}]}))
    write_tum(site_dir / "frames" / "robot_truth.tum", truth)
    write_wheels(site_dir, to_rows(truth))
    write_ceiling_map(site_dir, map_arrays())
    write_true_ceiling(data, site_dir)
    write_estimate(site_dir, in_map(drive()))
    write_ceiling_map(site_dir, map_arrays(), "adjust")
    write_estimate(site_dir, in_map(drive()), job="adjust")
    (site_dir / "adjust" / "report.json").write_text(json.dumps(ADJUSTMENT))
    return in_map(drive())
