# SPDX-License-Identifier: Apache-2.0
"""Every detector but SIFT, which all other tests use: from the pictures of a made-up building to located queries."""
import json
import unittest

from nightly import some_of
from workspace import RECORDING, Workspace

DETECTORS = ("orb", "brisk", "fast_brisk", "fast_orb")
MAX_ATE_M = 0.03
MAX_ERROR_CM = 10


class DetectorsTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.work = Workspace.made(RECORDING).removed_after(cls)

    def test_the_map_is_as_true_and_queries_are_located(self):
        for detector in some_of(DETECTORS, one_in=2):
            with self.subTest(detector):
                self.work.output("evaluate", f'SET=features.detector="{detector}"')
                metrics = json.loads(self.work.path("evaluate/metrics.json").read_text())
                coverage, queries = metrics["coverage"], metrics["queries"]
                self.assertEqual(coverage["num_frames_with_pose"], coverage["num_frames"])
                self.assertLessEqual(metrics["trajectory"]["se3"]["ate_rmse_m"], MAX_ATE_M)
                self.assertGreaterEqual(queries["num_located"], queries["num_with_truth"] / 2)
                self.assertLessEqual(queries["located_max_translation_error_cm"], MAX_ERROR_CM)

    def test_surf_is_refused_and_the_help_says_why(self):
        self.assertIn("fast_brisk", self.work.output("map", 'SET=features.detector="surf"', code=2))
        text = " ".join(self.work.run("features", "--help").stdout.split())
        self.assertIn("SURF is missing because it is patented and Debian's OpenCV is built without it", text)
