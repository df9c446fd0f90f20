# SPDX-License-Identifier: Apache-2.0
"""paste_people.py: who pauses stands still in the world, color, depth, labels and motion agree, and equal seeds give equal bytes."""

import contextlib
import io
import sys
import tempfile
import unittest
from pathlib import Path
from unittest import mock

import fake_site
import numpy as np
from nightmap_eval.trajectory import read_tum
from nightmap_site.script_errors import DataError
from PIL import Image

import boards
import paste_people

WIDTH, HEIGHT, F_PX, CX, CY = 160, 120, 130.0, 80.0, 59.0
NUM_FRAMES, FPS = 48, 5
WALL_M, UNITS = 4.0, 1000
TURN_RAD = 0.02  # per frame, back and forth
LENS = ["--fx", str(F_PX), "--fy", str(F_PX), "--cx", str(CX), "--cy", str(CY), "--depth-units", str(UNITS)]


def write_recording(folder):
    """A gray room, seen by a camera that moves sideways and turns; its truth starts late and ends early."""
    for name in ("rgb", "depth"):
        (folder / name).mkdir(parents=True)
    lists, poses = {"rgb": [], "depth": []}, []
    for k in range(NUM_FRAMES):
        gray, wall = np.full((HEIGHT, WIDTH, 3), 128, np.uint8), np.full((HEIGHT, WIDTH), WALL_M * UNITS, np.uint16)
        for name, picture in (("rgb", gray), ("depth", wall)):
            Image.fromarray(picture).save(folder / name / f"{k}.png")
            lists[name].append(f"{k / FPS:.3f} {name}/{k}.png\n")
        half = TURN_RAD * abs(k % 16 - 8) / 2
        poses.append(f"{k / FPS:.3f} {0.02 * abs(k % 24 - 12)} 0 0 0 {np.sin(half)} 0 {np.cos(half)}\n")
    for name, lines in lists.items():
        (folder / f"{name}.txt").write_text("".join(lines))
    (folder / "groundtruth.txt").write_text("".join(poses[2:-2]))


def write_people(folder):
    """A green person with a red spot in the middle."""
    folder.mkdir()
    color, label = np.zeros((220, 120, 3), np.uint8), np.zeros((220, 120, 3), np.uint8)
    color[:] = (0, 200, 0)
    color[90:130, 40:80] = (250, 0, 0)
    label[10:210, 10:110] = boards.PERSON_COLOR
    Image.fromarray(color).save(folder / "a.jpg", quality=98)
    Image.fromarray(label).save(folder / "a_label.png")


class PastePeopleTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = Path(cls.enterClassContext(tempfile.TemporaryDirectory()))
        write_recording(cls.folder / "room")
        write_people(cls.folder / "people")
        cls.said = cls.run_script("one", "--people", "1", "--seed", "3")
        truth = read_tum(cls.folder / "room" / "groundtruth.txt")
        at = np.clip(np.arange(NUM_FRAMES) - 2, 0, len(truth) - 1)
        cls.poses = list(zip(truth.positions_m[at], truth.rotations()[at]))

    @classmethod
    def run_script(cls, out, *options, recording="room", people="people"):
        said = io.StringIO()
        paths = [str(cls.folder / name) for name in (recording, people, out)]
        with mock.patch.object(sys, "argv", ["paste_people.py", *paths, *LENS, *options]), contextlib.redirect_stdout(said):
            paste_people.main()
        return said.getvalue()

    def read(self, out, kind, k):
        return np.asarray(Image.open(self.folder / out / kind / f"{k}.{'jpg' if kind == 'rgb' else 'png'}"))

    def spot(self, k):
        """The middle of the red spot in the world, where all of it is seen; and whether it moves."""
        color, depth_m = self.read("one", "rgb", k).astype(int), self.read("one", "depth", k) / UNITS
        rows, columns = np.nonzero(color[..., 0] - color[..., 1] > 120)
        if len(rows) < 20 or rows.min() < 2 or columns.min() < 2 or rows.max() > HEIGHT - 3 or columns.max() > WIDTH - 3:
            return None
        z, position_m, rotation = np.median(depth_m[rows, columns]), *self.poses[k]
        ray = np.array([(columns.mean() - CX) / F_PX, (rows.mean() - CY) / F_PX, 1])
        return position_m + rotation @ ray * z, bool(self.read("one", "moving", k)[rows, columns].max())

    def test_who_pauses_stays_at_one_point_of_the_world_and_who_moves_does_not(self):
        spots = [self.spot(k) for k in range(NUM_FRAMES)]
        num_pausing = num_moving = 0
        for k, (first, second) in enumerate(zip(spots, spots[1:])):
            if first is None or second is None:
                continue
            in_camera = (first[0] - self.poses[k + 1][0]) @ self.poses[k + 1][1], (second[0] - self.poses[k + 1][0]) @ self.poses[k + 1][1]
            apart_px = F_PX * np.linalg.norm(np.subtract(*(point[:2] / point[2] for point in in_camera)))
            if not first[1] and not second[1]:
                num_pausing += 1
                self.assertLess(apart_px, 1)
                self.assertLess(np.linalg.norm(first[0] - second[0]), 0.02)
            elif first[1] and second[1]:
                num_moving += 1
                self.assertGreater(np.linalg.norm(first[0] - second[0]), 0.02 / FPS)
        self.assertGreater(min(num_pausing, num_moving), 5)

    def test_label_motion_color_and_depth_agree(self):
        for k in range(NUM_FRAMES):
            person = self.read("one", "label", k) == 15
            self.assertEqual(set(np.unique(self.read("one", "label", k))) - {0, 15}, set())
            moving = self.read("one", "moving", k)[person]
            self.assertIn(set(np.unique(moving)), ({0}, {255}, set()))  # one person does one thing
            self.assertFalse(self.read("one", "moving", k)[~person].any())
            np.testing.assert_array_equal(self.read("one", "depth", k) < WALL_M * UNITS, person)
            colored = np.ptp(self.read("one", "rgb", k).astype(int), axis=2) > 100
            self.assertGreater(np.mean(colored == person), 0.95)

    def test_who_is_behind_the_wall_is_hidden(self):
        near = self.folder / "near"
        write_recording(near)
        for k in range(NUM_FRAMES):
            depth = np.full((HEIGHT, WIDTH), WALL_M * UNITS, np.uint16)
            depth[:, : WIDTH // 2] = 0.5 * UNITS
            Image.fromarray(depth).save(near / "depth" / f"{k}.png")
        self.run_script("hidden", "--people", "3", recording="near")
        labels = np.array([self.read("hidden", "label", k) for k in range(NUM_FRAMES)])
        self.assertFalse(labels[..., : WIDTH // 2].any())
        self.assertTrue(labels[..., WIDTH // 2 :].any())

    def test_same_seed_same_bytes_and_another_seed_others(self):
        self.run_script("again", "--people", "1", "--seed", "3")
        self.run_script("other", "--people", "1", "--seed", "4")
        names = [path.relative_to(self.folder / "one") for path in (self.folder / "one").rglob("*") if path.is_file()]
        self.assertEqual(len(names), 4 * NUM_FRAMES + 3)
        bytes_of = {out: [(self.folder / out / name).read_bytes() for name in names] for out in ("one", "again", "other")}
        self.assertEqual(bytes_of["one"], bytes_of["again"])
        self.assertNotEqual(bytes_of["one"], bytes_of["other"])

    def test_who_leaves_is_gone_and_who_sits_never_moves(self):
        self.run_script("leaver", "--people", "1", "--leaver")
        self.run_script("sitter", "--people", "1", "--sitter")
        shares = [[(self.read(out, kind, k) > 0).mean() for k in range(NUM_FRAMES)] for out, kind in
                  (("leaver", "label"), ("leaver", "moving"), ("sitter", "label"), ("sitter", "moving"))]  # fmt: skip
        still, third = NUM_FRAMES // 4, NUM_FRAMES // 3
        self.assertGreater(min(shares[0][:still]), 0.01)
        self.assertEqual(max(shares[1][:still]), 0)
        self.assertGreater(max(shares[1]), 0)
        self.assertEqual(max(shares[0][2 * third :]), 0)
        self.assertGreater(min(shares[2]), 0.01)
        self.assertEqual(max(shares[3]), 0)

    def test_it_says_how_much_people_cover_and_pause(self):
        labels, moving = (np.array([self.read("one", kind, k) > 0 for k in range(NUM_FRAMES)]) for kind in ("label", "moving"))
        pausing = 100 * (1 - moving.sum() / labels.sum())
        self.assertIn(f"cover {100 * labels.mean():.1f} % on average", self.said)
        self.assertIn(f"{pausing:.1f} % of their pixels pause", self.said)

    def test_what_it_cannot_use_is_named(self):
        for options, said in (({"out": "one"}, "one: exists"), ({"people": "room"}, "no large person"), ({"recording": "people"}, "rgb.txt")):
            with self.subTest(said), self.assertRaisesRegex((DataError, OSError), said):
                self.run_script(**{"out": "new", **options})
            self.assertFalse((self.folder / "new").exists())


class RaysTest(unittest.TestCase):
    def test_rays_are_those_that_distortion_brings_to_the_pixels(self):
        k1, k2, p1, p2, k3 = 0.26, -0.95, -0.005, 0.003, 1.16
        rays = boards.rays_of(640, 480, 517, 516, 318, 255, (k1, k2, p1, p2, k3))
        x, y = np.moveaxis(rays, 2, 0)
        r2 = x * x + y * y
        factor = 1 + k1 * r2 + k2 * r2**2 + k3 * r2**3
        u = 517 * (x * factor + 2 * p1 * x * y + p2 * (r2 + 2 * x * x)) + 318
        v = 516 * (y * factor + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y) + 255
        np.testing.assert_allclose(np.stack([u, v]), np.meshgrid(np.arange(640), np.arange(480)), atol=0.05)
