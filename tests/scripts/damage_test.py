# SPDX-License-Identifier: Apache-2.0
"""damage.py on a tiny recording: each fault changes what it says, the same seed gives the same copy, the original stays."""

import hashlib
import json
import math
import unittest

import numpy as np
from PIL import Image

from folder_case import FolderTest

import measure_faults
from damage import FAULTS, damage
from recording import read_recording

NUM_FRAMES = 60
CONFIG = """root = "tiny"

[[camera]]
id = "kinect"
width = 64
height = 48
fx = 50.0
fy = 50.0
cx = 31.5
cy = 23.5
depth_units_per_m = 5000

[[sequence]]
layout = "tum"
folder = "."
camera = "kinect"
"""


def write_tiny(data):
    folder, random = data / "tiny", np.random.default_rng(1)
    lists = {"rgb": [], "depth": []}
    for channel, lines in lists.items():
        (folder / channel).mkdir(parents=True)
        for i in range(NUM_FRAMES):
            path = folder / channel / f"{i:03d}.png"
            pixels = random.integers(0, 256, (48, 64, 3), dtype=np.uint8) if channel == "rgb" else random.integers(
                5000, 15000, (48, 64), dtype=np.uint16)  # fmt: skip
            Image.fromarray(pixels).save(path)
            lines.append(f"{i / 10:.6f} {channel}/{path.name}\n")
        (folder / f"{channel}.txt").write_text("".join(lines))
    (folder / "groundtruth.txt").write_text("0 0 0 1 -0.70710678 0 0 0.70710678\n")  # level, z up
    (data / "tiny.toml").write_text(CONFIG)


def hashes(folder):
    return {str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest() for path in sorted(folder.rglob("*")) if path.is_file()}


class DamageTest(FolderTest):
    def setUp(self):
        self.data, self.out = self.folder / "data", self.folder / "out"
        write_tiny(self.data)
        self.before = hashes(self.data)

    def tearDown(self):
        self.assertEqual(hashes(self.data), self.before)  # whatever the fault, the original stays

    def copy(self, fault, name="copy", seed=0):
        damage(fault, seed, self.data / "tiny.toml", self.data, self.out, name)
        return read_recording(self.out / "sites" / f"{name}.toml", self.out / "data")

    def pixels(self, path):
        return np.array(Image.open(path)).astype(float)

    def test_a_clean_copy_has_the_same_pictures_of_its_own(self):
        copy = self.copy("clean")
        self.assertEqual(len(copy.frames), NUM_FRAMES)
        for i, frame in enumerate(copy.frames):
            self.assertEqual(frame.color.read_bytes(), (self.data / f"tiny/rgb/{i:03d}.png").read_bytes())
            self.assertEqual(frame.color.stat().st_nlink, 1)

    def test_every_fault_changes_something(self):
        clean = hashes(self.out / "data" / "clean") if self.copy("clean", "clean") else {}
        for fault in FAULTS:
            with self.subTest(fault):
                copy = self.copy(fault, fault)
                changed = hashes(self.out / "data" / fault) != clean
                self.assertTrue(changed or copy.config != CONFIG.replace("tiny", fault))

    def test_the_same_seed_gives_the_same_copy_and_another_another(self):
        for fault in ("people", "random"):
            for name, seed in (("a", 5), ("b", 5), ("c", 6)):
                self.copy(fault, f"{fault}_{name}", seed)
            a, b, c = (hashes(self.out / "data" / f"{fault}_{name}") for name in "abc")
            self.assertEqual(a, b)
            self.assertNotEqual(a, c)

    def test_depth_scale_is_of_the_config(self):
        self.assertAlmostEqual(self.copy("depth_x5").value("depth_units_per_m"), 1000)
        self.assertAlmostEqual(self.copy("depth_by_5", "other").value("depth_units_per_m"), 25000)

    def test_depth_of_a_later_frame(self):
        copy = self.copy("depth_shifted")
        self.assertEqual(copy.frames[0].depth.read_bytes(), (self.data / "tiny/depth/003.png").read_bytes())
        self.assertEqual(copy.frames[0].color.read_bytes(), (self.data / "tiny/rgb/000.png").read_bytes())

    def test_scrambled_names_are_in_order_of_text(self):
        names = [frame.color.stem for frame in self.copy("scrambled_order").frames]
        self.assertEqual(names, sorted(map(str, range(1, NUM_FRAMES + 1))))

    def test_shares_of_faults_in_runs(self):
        frames = self.copy("frozen").frames
        same = sum(a.color.read_bytes() == b.color.read_bytes() for a, b in zip(frames, frames[1:]))
        self.assertGreaterEqual(same, 8)
        gone = NUM_FRAMES - len(self.copy("gaps", "gaps").frames)
        self.assertTrue(5 <= gone <= 20, gone)

    def test_what_is_low_is_hidden_in_most_frames(self):
        frames = self.copy("counter_as_floor").frames
        hidden = [np.flatnonzero((self.pixels(frame.depth) == 0).any(axis=1)) for frame in frames]
        self.assertGreater(sum(len(rows) > 0 for rows in hidden), 0.7 * NUM_FRAMES)
        self.assertTrue(all(rows.min() > 24 for rows in hidden if len(rows)))  # below the horizon

    def test_people_stand_in_front(self):
        frame = self.copy("people").frames[10]
        new, old = self.pixels(frame.depth), self.pixels(self.data / "tiny/depth/010.png")
        share = np.mean(new != old)
        self.assertTrue(0.2 < share < 0.9, share)
        self.assertLessEqual(new[new != old].max(), 1.5 * 5000)


class TableTest(unittest.TestCase):
    def row(self, fault, verdict, ate_m, checks=(), **more):
        return {"site": "tiny", "fault": fault, "seed": 0, "said": fault, "check_exit": 0, "exit": 0, "message": "", "check": None,
                "check_checks": [], "verdict": verdict, "verdict_checks": [[name, 1.0, "look at this", ""] for name in checks],
                "ate_m": ate_m, "mapped": 1.0} | more  # fmt: skip

    def test_a_fault_is_named_by_its_checks_only(self):
        self.assertTrue(measure_faults.is_named(self.row("blurred_30", "look at this", 0.1, ["blurred frames"])))
        self.assertFalse(measure_faults.is_named(self.row("blurred_30", "look at this", 0.1, ["speed"])))
        failed = self.row("duplicate_times", None, None, exit=2, message="error frames: rgb.txt:4: times must increase")
        self.assertTrue(measure_faults.is_named(failed))

    def test_a_map_without_half_of_its_frames_is_ruined(self):
        clean = {"tiny": self.row("clean", "good", 0.1)}
        self.assertEqual(measure_faults.ratio(self.row("gaps", "good", 0.3), clean), 0.3 / 0.1)
        self.assertEqual(measure_faults.ratio(self.row("gaps", "good", 0.1, mapped=0.4), clean), math.inf)
        self.assertEqual(measure_faults.ratio(self.row("gaps", None, None), clean), math.inf)

    def test_the_counts_tell_what_was_missed(self):
        rows = [self.row("clean", "good", 0.1), self.row("random", "good", 0.9), self.row("random", "do not use", 0.11),
                self.row("random", "do not use", 0.9)]  # fmt: skip
        text = "\n".join(measure_faults.table(json.loads(json.dumps(rows))))
        self.assertIn("3 random: 2 with ATE over 5 times, 1 of them good (must be 0), 1 not to be used; 1 below 1.5 times, 1 of them", text)

    def test_tables_for_a_page(self):
        rows = [self.row("clean", "good", 0.1), self.row("gaps", "look at this", 0.3, ["gaps in time"]), self.row("people", "good", 0.2),
                self.row("duplicate_times", None, None, exit=2, message="times must increase"),
                self.row("random", "good", 0.12), self.row("random", "look at this", 0.3), self.row("random", "do not use", 0.9),
                self.row("random", "do not use", 0.11, mapped=0.2), self.row("random", None, None, exit=2)]  # fmt: skip
        lines = measure_faults.faults_markdown(rows, ["tiny"]).splitlines()
        self.assertEqual(lines[0], "| fault | `tiny`: verdict; ATE; advice |")
        self.assertIn("| gaps | look at this; 3.0; named |", lines)
        self.assertIn("| people | good; 2.0; **not named** |", lines)
        self.assertIn("| duplicate_times | error; none; named |", lines)
        self.assertEqual(lines[-2:], ["| named | 2 of 3 |", "| clean | good |"])
        lines = measure_faults.random_markdown(rows).splitlines()
        self.assertEqual(lines[2:4], ["| below 1.5 | 1 | 0 | 0 | 0 |", "| 1.5 to 5 | 0 | 1 | 0 | 0 |"])
        self.assertTrue(lines[4].endswith(" | 0 | 0 | 2 | 1 |"), lines[4])
