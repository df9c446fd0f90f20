# SPDX-License-Identifier: Apache-2.0
"""Wheels enter the real pose graph by the folder of a stage and the folder of a profile. A copy of the tree without them maps the
small building by its camera alone; then it gets the two folders, and maps it by camera and wheels."""
import json
import shutil
import sys

import numpy as np
from add_wing_test import build_stage, copy_of_the_tree, programs_but
from nightly import IS_NIGHT
from workspace import REPOSITORY, SITE, SiteTest, Workspace, write_small_site

sys.path.append(str(REPOSITORY / "scripts"))
from nightmap_eval.trajectory import quaternion, read_tum  # noqa: E402

ADDED = ("stages/graph/wheel_edges", "configs/wheels")
PITCH_RAD = 0.16  # of the camera, which is ahead of the axle, to its left and above it
AXES = np.array([[0, -np.sin(PITCH_RAD), np.cos(PITCH_RAD)], [-1, 0, 0], [0, -np.cos(PITCH_RAD), -np.sin(PITCH_RAD)]])
POSITION_M = np.array([0.3, 0.1, 1.0])
SAMPLE_PERIOD_S = 0.02
WHEELS = """
[[sensor]]
id = "wheels"
kind = "odometry"

[[signal]]
sensor = "wheels"
format = "text"
file = "wheels.txt"
"""


def path_of_the_wheels(truth, times_s):
    """x, y and heading (n, 3) of the axle, from the poses of the camera."""
    rotations = truth.rotations() @ AXES.T  # world_from_robot
    positions_m = truth.positions_m - rotations @ POSITION_M
    headings_rad = np.unwrap(np.arctan2(rotations[:, 1, 0], rotations[:, 0, 0]))
    columns = (positions_m[:, 0], positions_m[:, 1], headings_rad)
    return np.stack([np.interp(times_s, truth.times_ns / 1e9, column) for column in columns], axis=1)


def as_measured(path, rng):
    """The path as wheels count it: each step and turn is 1 % too long, and off by another 3 % at random."""
    pose, measured = np.zeros(3), [np.zeros(3)]
    for before, step in zip(path, np.diff(path, axis=0)):
        turn = pose[2] - before[2]
        cos, sin = np.cos(turn), np.sin(turn)
        in_measured = np.array([cos * step[0] - sin * step[1], sin * step[0] + cos * step[1], step[2]])
        pose = pose + in_measured * (1.01 + 0.03 * rng.standard_normal(3))
        measured.append(pose)
    return np.array(measured)


def write_wheels(data):
    truth = read_tum(data / "groundtruth.txt")
    times_s = np.arange(truth.times_ns[0] / 1e9 - 0.01, truth.times_ns[-1] / 1e9 + 0.01 + SAMPLE_PERIOD_S, SAMPLE_PERIOD_S)
    poses = as_measured(path_of_the_wheels(truth, times_s), np.random.default_rng(1))
    lines = [f"{time_s:.6f} {x:.6f} {y:.6f} {heading:.6f}\n" for time_s, (x, y, heading) in zip(times_s, poses)]
    (data / "wheels.txt").write_text("".join(lines))


class WheelsTest(SiteTest):
    @classmethod
    def setUpClass(cls):
        cls.folder = copy_of_the_tree()
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        for name in ADDED:
            shutil.rmtree(cls.folder / name)
        write_small_site(cls.folder)
        if not IS_NIGHT:  # at night each make builds its programs itself
            programs_but(cls.folder, "wheel_edges")
            (cls.folder / "build/programs.mk").touch()
        cls.site = cls.folder / f"configs/sites/{SITE}.toml"
        pose = ", ".join(f"{value:.9f}" for value in [*POSITION_M, *quaternion(AXES)])
        cls.site.write_text(cls.site.read_text().replace('id = "color"\n', f'id = "color"\nrobot_from_camera = [{pose}]\n'))
        cls.work = Workspace(cls.folder)

    def read(self, name):
        return json.loads(self.work.path(name).read_text())

    def ate_m(self):
        return self.read("evaluate/metrics.json")["trajectory"]["se3"]["ate_rmse_m"]

    def test_two_folders_add_the_wheels_to_the_pose_graph(self):
        self.assertIn("no profile 'wheels'", self.make("map", "PROFILE=wheels", code=2))
        self.make("map", "evaluate")
        self.assertNotIn("sensors", self.read("pose_graph/report.json"))
        alone_m = self.ate_m()
        for name in ADDED:
            shutil.copytree(REPOSITORY / name, self.folder / name)
        if not IS_NIGHT:
            shutil.rmtree(self.folder / "build")
            build_stage(self.folder, "wheel_edges")
        self.assertIn("add a [[sensor]]", self.make("map", "PROFILE=wheels", code=2))
        self.site.write_text(self.site.read_text() + WHEELS)
        write_wheels(self.work.data())
        before = self.work.runs()
        self.make("map", "evaluate", "PROFILE=wheels")
        after = self.work.runs()
        reran = {job for job in after if after[job] != before.get(job)}
        self.assertTrue({"frames", "wheel_edges", "pose_graph"} <= reran and not reran & {"features", "odometry", "loops"}, reran)

        edges = self.read("wheel_edges/report.json")
        self.assertEqual((edges["num_edges"], edges["num_motions_without_edge"]), (edges["num_frames"] - 1, 0))
        (wheels,) = self.read("pose_graph/report.json")["sensors"]
        self.assertEqual((wheels["sensor"], wheels["num_odometry"], wheels["num_refused"]), ("wheels", edges["num_edges"], 0))
        self.assertLess(wheels["median_normalized_residual"], 2.3)  # what exact covariances give; the default ones are cautious
        self.assertLessEqual(self.ate_m(), 1.1 * alone_m)
