# SPDX-License-Identifier: Apache-2.0
"""A robot with an upward camera, mapped from what a user has: a video and a CSV of the odometry. The video is of a made-up office, whose
truth is compared afterwards and is no input."""
import json
import shutil
import sys

import numpy as np
from PIL import Image
from workspace import REPOSITORY, SiteTest, Workspace

sys.path.append(str(REPOSITORY / "scripts"))
from nightmap_eval.artifacts import read_hdf5  # noqa: E402
from nightmap_eval.trajectory import read_tum  # noqa: E402

RATE_HZ = 10
FIRST_S = 1000  # of the made-up recording; a video begins at 0
OPTIONS = """
layout = "office"
image_width_px = 320
image_height_px = 240
focal_length_px = 160.0
duration_s = 30.0
"""
SITE = f"""
root = "lab"
profile = "ceiling"

[[camera]]
id = "up"
width = 320
height = 240
fx = 160.0
fy = 160.0
cx = 159.5
cy = 119.5
depth_units_per_m = 1000
robot_from_camera = [0.0, 0.0, 0.35, 0.0, 0.0, 0.0, 1.0]

[[sequence]]
layout = "video"
folder = "."
video = "up.mjpeg"
frame_rate_hz = {RATE_HZ}
depth = "none"
camera = "up"

[[sensor]]
id = "wheels"
kind = "odometry"

[[signal]]
sensor = "wheels"
format = "csv"
file = "odometry.csv"
columns = "time_s,x_m,y_m,heading_rad"
time_offset_s = -{FIRST_S}
"""


def heading_rad(trajectory):
    rotations = trajectory.rotations()
    return np.unwrap(np.arctan2(rotations[:, 1, 0], rotations[:, 0, 0]))


def from_start(trajectory):
    """(n, 2) positions in the frame of the first pose, and headings."""
    heading = heading_rad(trajectory)
    cos, sin = np.cos(heading[0]), np.sin(heading[0])
    away = trajectory.positions_m[:, :2] - trajectory.positions_m[0, :2]
    return away @ np.array([[cos, -sin], [sin, cos]]), heading - heading[0]


def rms_errors(estimate, truth):
    """Errors of the positions in m, and of the headings in degrees, both from the start."""
    (positions_m, heading), (true_positions_m, true_heading) = from_start(estimate), from_start(truth)
    position_m = np.sqrt(np.mean(np.sum((positions_m - true_positions_m) ** 2, axis=1)))
    return position_m, np.degrees(np.sqrt(np.mean((heading - true_heading) ** 2)))


def mosaic_gradients(maps):
    """Medians of the steepest gradient within a pixel of each landmark, and of the gradient of all that was seen."""
    points_m = read_hdf5(maps / "adjust/ceiling_map.h5", "landmark_position_m")[0]
    size_m, _, _, down_m, x_m, y_m = map(float, (maps / "mosaic/mosaic.pgw").read_text().split())
    with Image.open(maps / "mosaic/mosaic.png") as picture:
        gray = np.asarray(picture.convert("L"), float)
    gradient = np.hypot(*np.gradient(gray))
    columns, rows = np.rint((points_m[:, :2] - [x_m, y_m]) / [size_m, down_m]).astype(int).T
    return np.median([gradient[y - 1 : y + 2, x - 1 : x + 2].max() for x, y in zip(columns, rows)]), np.median(gradient[gray > 0])


def record(work):
    """Puts a video and a CSV of a made-up office into a workspace, as the site `lab`; returns the number of pictures, and the true way."""
    lab, made_up = work.folder / "data/lab", work.folder / "made_up"
    lab.mkdir(parents=True)
    made_up.mkdir()
    (made_up / "options.toml").write_text(OPTIONS)
    work.run("synthesize_ceiling", "--config", made_up / "options.toml", "--out", f"site={made_up}/synthesize.json")
    pictures = sorted((made_up / "rgb").glob("*.jpg"))
    (lab / "up.mjpeg").write_bytes(b"".join(path.read_bytes() for path in pictures))
    shutil.copy(made_up / "odometry.csv", lab)
    (work.folder / "configs/sites/lab.toml").write_text(SITE)
    return len(pictures), read_tum(made_up / "robot_groundtruth.txt")


class CeilingTest(SiteTest):
    @classmethod
    def setUpClass(cls):
        cls.work = Workspace()
        cls.addClassCleanup(shutil.rmtree, cls.work.folder)
        cls.num_pictures, cls.truth = record(cls.work)

    def test_1_maps_from_a_video_and_a_csv(self):
        self.make("report", "SITE=lab")
        maps = self.work.folder / "maps/lab"
        estimate = read_tum(maps / "odometry/trajectory.tum")
        self.assertEqual(len(estimate), self.num_pictures)
        true_positions_m, true_heading = from_start(self.truth)
        self.assertGreater(np.linalg.norm(np.diff(true_positions_m, axis=0), axis=1).sum(), 8)  # it drove, and turned
        self.assertGreater(np.ptp(true_heading), 3)
        position_m, heading_deg = rms_errors(estimate, self.truth)
        self.assertLess(position_m, 0.15)
        self.assertLess(heading_deg, 1)
        heights_m = read_hdf5(maps / "odometry/ceiling_map.h5", "landmark_position_m")[0][:, 2]
        self.assertGreater(len(heights_m), 50)
        self.assertGreater(np.mean((heights_m > 2) & (heights_m < 3.3)), 0.9)
        adjusted = read_tum(maps / "adjust/trajectory.tum")
        self.assertEqual(len(adjusted), self.num_pictures)
        position_m, heading_deg = rms_errors(adjusted, self.truth)
        self.assertLess(position_m, 0.10)
        self.assertLess(heading_deg, 0.5)
        self.assertGreater(json.loads((maps / "mosaic/report.json").read_text())["covered_m2"], 20)
        at_landmarks, everywhere = mosaic_gradients(maps)
        self.assertGreater(at_landmarks, 10 * everywhere)  # half as much if the mosaic does not know how the camera is tilted
        self.assertIn("true way is not known", (maps / "report/index.html").read_text())

    def test_2_a_second_run_makes_nothing(self):
        self.assertEqual(self.work.make("-q", "map", "SITE=lab").returncode, 0)

    def test_3_without_odometry_the_remedy_is_named(self):
        site = self.work.folder / "configs/sites/lab.toml"
        (self.work.folder / "configs/sites/alone.toml").write_text(site.read_text().split("[[sensor]]")[0])
        output = self.make("map", "SITE=alone", code=2)
        self.assertIn("no sensor of the site measures odometry", output)

    def test_4_clocks_that_do_not_agree_are_an_error(self):
        site = self.work.folder / "configs/sites/lab.toml"
        (self.work.folder / "configs/sites/late.toml").write_text(site.read_text().replace(f"= -{FIRST_S}", "= 0"))
        output = self.make("map", "SITE=late", code=2)
        self.assertIn("time_offset_s", output)

    def test_5_a_goal_that_the_profile_lacks_says_so(self):
        output = self.make("plan", "SITE=lab", "START=0,0", "GOAL=1,1", code=2)
        self.assertIn("the profile 'ceiling' has no job of `make plan`: it needs an occupancy grid", output)
        self.assertIn('a laser scanner (profile "laser") or a depth camera (the default profile)', output)
        self.assertIn("; it has those of: check, map, evaluate, report", output)
        self.assertIn("has no job of `make evaluate-colmap`: it needs landmarks", self.make("evaluate-colmap", "SITE=lab", code=2))
