# SPDX-License-Identifier: Apache-2.0
"""Recordings as people have them, made of the shared ones: each map is good, or its verdict says what is wrong and what to do."""
import re
import shutil
import unittest

import numpy as np

from accuracy import DATA, metrics_of, real
from made_cases import MadeCases
from nightly import IS_NIGHT

GOOD = ""
# Each case has its control, by whose error its own is judged, and the check that its verdict names with a word of the advice.
CASES = {
    "portrait": ("base_holo", GOOD, ""),
    "portrait_rfc": ("base_holo", GOOD, ""),
    "dropouts": ("base_holo", GOOD, ""),
    "video": ("base", GOOD, ""),
    "video_rot180": ("base", GOOD, ""),
    "dup": ("all_holo", "copied frames", "leave the copies out"),
    "sun": ("all_holo", "frames without depth", "sunlight"),
    "half_holo": ("all_holo", "size of the pictures of camera c", "scale them too"),
    "half_fr1": ("base", "size of the pictures of camera c", "scale them too"),
    "ray_holo": ("all_holo", "flatness of depth", "depth_along_ray = true"),
    "ray_fr1": ("base", "flatness of depth", "depth_along_ray = true"),
    "body": ("all_holo", "parts of the robot in the picture", "mask = "),
    "body_color": ("all_holo", "parts of the robot in the picture", "mask = "),
    "off_holo": ("all_holo", "offset of depth of camera 0", "depth_offset_m = 0."),
    "late_truth": ("base", "ground truth apart from the frames", "clock"),
}
BY_DAY = ("half_fr1", "ray_fr1")  # before the map; tests of the stages have the others' kinds


class CameraCasesTest(MadeCases):
    tool, before = "camera_cases.py", (DATA,)

    @classmethod
    def setUpClass(cls):
        real("hololens_office")
        super().setUpClass()
        cls.errors_m = {}

    def error_m(self, case):
        if case not in self.errors_m:
            self.assertEqual(self.made(case, "map", "evaluate")["verdict"], "good", case)
            self.errors_m[case] = metrics_of(self.folder / "maps" / case)["trajectory"]["se3"]["ate_rmse_m"]
        return self.errors_m[case]

    def check_is_upright(self, case):
        """The z axis of the map is the y axis of the truth."""
        poses = np.loadtxt(self.folder / "maps" / case / "map_frame" / "trajectory.tum")
        heights_m = np.loadtxt(self.folder / "data" / case / "groundtruth.txt")[:, 2]
        times_s = np.loadtxt(self.folder / "data" / case / "groundtruth.txt")[:, 0]
        true_m = heights_m[np.argmin(abs(times_s[:, None] - poses[:, 0]), axis=0)]
        self.assertLess(np.std(poses[:, 3] - true_m), 0.03)

    def test_before_the_map(self):
        for case in BY_DAY:
            with self.subTest(case):
                _, name, word = CASES[case]
                self.check_names_the_cause(self.made(case, "check"), name, word)

    def test_an_upright_phone_gets_an_upright_map(self):
        self.assertEqual(self.made("portrait", "map")["verdict"], "good")
        self.check_is_upright("portrait")

    @unittest.skipUnless(IS_NIGHT, "takes minutes: set NIGHTMAP_NIGHTLY=1")
    def test_the_proposed_mask_makes_the_map_good(self):
        for case in ("body", "body_color"):
            with self.subTest(case):
                self.made(case, "check")
                shutil.copy(self.folder / "maps" / case / "survey" / "mask_0.png", self.folder / "data" / case / "mask.png")
                site = self.site(case)
                site.write_text(site.read_text().replace("[[camera]]", '[[camera]]\nmask = "mask.png"'))
                self.assertLess(self.error_m(case), 1.15 * self.error_m("all_holo"))

    @unittest.skipUnless(IS_NIGHT, "takes minutes: set NIGHTMAP_NIGHTLY=1")
    def test_the_proposed_offset_of_depth_makes_the_map_good(self):
        advice = next(item["advice"] for item in self.made("off_holo", "map")["checks"] if item["name"].startswith("offset of depth"))
        site = self.site("off_holo")
        key = re.search(r"depth_offset_m = [0-9.]+", advice).group()
        site.write_text(site.read_text().replace("[[camera]]", f"[[camera]]\n{key}"))
        self.assertLess(self.error_m("off_holo"), 1.15 * self.error_m("all_holo"))

    @unittest.skipUnless(IS_NIGHT, "takes ten minutes: set NIGHTMAP_NIGHTLY=1")
    def test_all(self):
        for case, (control, name, word) in CASES.items():
            if case.startswith("video") and not shutil.which("ffmpeg"):
                continue
            with self.subTest(case):
                if name:
                    self.check_names_the_cause(self.made(case, "check", "map"), name, word)
                elif case.startswith("video"):
                    self.assertEqual(self.made(case, "check", "map")["verdict"], "good")
                else:
                    self.assertLess(self.error_m(case), 1.15 * self.error_m(control))
        for case in ("portrait", "portrait_rfc"):
            self.check_is_upright(case)
