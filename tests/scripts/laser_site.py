# SPDX-License-Identifier: Apache-2.0
"""A small site folder of a robot with a laser and without a camera, for the tests of its evaluation and report."""

import json
import shutil
from unittest import mock

import numpy as np

import fake_site
from fake_site import moved, rotation_about, write_tum
from folder_case import SiteFolderTest
from nightmap_eval.sealed_hdf5 import sealed
from nightmap_eval.trajectory import Trajectory, quaternion
from nightmap_site.pipeline import read_pipeline

KEPT = ("frames", "pose_graph", "map_frame", "grid", "plan")  # and the scripts
TRUTH_FROM_MAP_YAW_RAD, TRUTH_FROM_MAP_M = 0.5, np.array([1.0, -2.0, 0.0])


def write_configs(folder):
    """Configs whose profile `scans` has the kept jobs alone; its grid brings the figures and the section of a laser."""
    shutil.copytree(fake_site.CHECKOUT / "configs", folder, ignore=shutil.ignore_patterns("sites"))
    text = ""
    jobs = read_pipeline(str(folder)).jobs
    kept = {name for name, job in jobs.items() if name in KEPT or job.script}
    for name, job in jobs.items():
        if name not in kept:
            text += f"[{name}]\nleave_out = true\n"
            continue
        cut = [reference.port for reference in job.inputs if reference.job and reference.job not in kept]
        text += f"[{name}]\n" + "".join(f"in.{port} = false\n" for port in dict.fromkeys(cut))
        if name == "grid":
            text += ('section.report = "scripts/nightmap_eval/laser/report_laser.py"\n'
                     'section.evaluation = "scripts/nightmap_eval/laser/laser_accuracy.py"\n')  # fmt: skip
    (folder / "scans").mkdir()
    (folder / "scans" / "pipeline.toml").write_text(text)


class LaserFolderTest(SiteFolderTest):
    """The scripts read the configs of write_configs."""

    SITE = "hall"

    def setUp(self):
        write_configs(self.folder / "configs")
        self.enterContext(mock.patch("nightmap_site.site.CONFIGS", self.folder / "configs"))


def drive(num_poses=401):
    """The truth: three rounds of 2 m radius on the floor, 37.7 m, a pose every 0.1 s."""
    phase = np.linspace(0, 6 * np.pi, num_poses)
    positions = np.column_stack([2 * np.cos(phase), 2 * np.sin(phase), np.zeros(num_poses)])
    quaternions = np.array([quaternion(rotation_about([0, 0, 1], angle + np.pi / 2)) for angle in phase])
    return Trajectory(1_000_000_000 + np.arange(num_poses) * 100_000_000, positions, quaternions)


def in_map(truth):
    rotation = rotation_about([0, 0, 1], TRUTH_FROM_MAP_YAW_RAD).T
    return moved(truth, rotation, -rotation @ TRUTH_FROM_MAP_M)


def write_scans(path, *times_ns):
    """scans.h5 with the times of each scanner and no ranges."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with sealed(path) as file:
        file["time_ns"] = np.concatenate(times_ns).astype(np.int64)[:, None]
        file["sample_offset"] = np.cumsum([0, *map(len, times_ns)]).astype(np.int64)[:, None]


def write_site(site_dir, truth=True):
    """A site without errors; returns its estimate, of every scan, in the map frame."""
    true_drive = drive()
    estimate = in_map(true_drive)
    (site_dir / "config").mkdir(parents=True)
    (site_dir / "config" / "profile.toml").write_text('profile = "scans"\nimports = []\n')
    write_scans(site_dir / "frames" / "scans.h5", np.arange(7), true_drive.times_ns)
    write_tum(site_dir / "map_frame" / "trajectory.tum", estimate)
    write_tum(site_dir / "map_frame" / "keyframes.tum", estimate.select(range(0, len(estimate), 10)))
    write_tum(site_dir / "pose_graph" / "trajectory.tum", true_drive)
    (site_dir / "pose_graph" / "loops.csv").write_text(
        "frame_a,frame_b,status,reason\n0,133,accepted,\n5,300,rejected,inconsistent\n")  # fmt: skip
    fake_site.write_map(site_dir / "grid", "map", fake_site.room_pixels())
    floors = [{"number": 0, "height_m": 0.0, "yaml": "map.yaml"}]
    content = {"format": "nightmap floors", "version": 2, "floors": floors}
    (site_dir / "grid" / "floors.json").write_text(json.dumps(content))
    if truth:
        write_tum(site_dir / "frames" / "robot_truth.tum", true_drive)
    return estimate
