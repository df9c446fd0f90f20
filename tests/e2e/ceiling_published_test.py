# SPDX-License-Identifier: Apache-2.0
"""The published map of a ceiling is one word; see published_test.py."""

import ceiling_test
import published_test
from workspace import Workspace
from nightmap_eval.trajectory import read_tum  # workspace finds the scripts


class CeilingTest(published_test.Published):
    site, profile, heart = "lab", "published_ceiling", {"ceiling_ekf.initial_depth": "published", "features.detector": "harris"}

    @classmethod
    def setUpClass(cls):
        cls.work = Workspace()
        cls.num_pictures, cls.truth = ceiling_test.record(cls.work)
        cls.map_as_published()

    def test_1_each_picture_has_a_pose_and_landmarks_are_at_the_ceiling(self):
        estimate = read_tum(self.maps / "odometry/trajectory.tum")
        self.assertEqual(len(estimate), self.num_pictures)
        position_m, heading_deg = ceiling_test.rms_errors(estimate, self.truth)
        self.assertLess(position_m, 0.15)
        self.assertLess(heading_deg, 1)
        self.assertGreater(self.metrics["sections"]["odometry"]["num_landmarks"], 50)
        self.assertIn("Map of the ceiling", (self.maps / "report/index.html").read_text())

    def test_2_values_are_the_published_ones_and_the_others_those_of_the_ceiling(self):
        self.check_values_and_state()
