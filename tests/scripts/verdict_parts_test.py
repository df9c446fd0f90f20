# SPDX-License-Identifier: Apache-2.0
"""verdict_parts: parts of a laser's way between which nothing is known are joined by loops, or the map is not used."""

from types import SimpleNamespace

import numpy as np
from folder_case import FolderTest
from nightmap_eval.laser.verdict_laser import part_checks, parts_apart
from nightmap_eval.sealed_hdf5 import sealed
from nightmap_eval.verdict.verdict import GOOD, REFUSE
from nightmap_site.script_errors import DataError


class PartsTest(FolderTest):
    def checks(self, sigmas_rad, loops, covariances=None):
        """sigmas_rad: of the heading, of each edge."""
        made = {"odometry": self.folder / "edges.h5", "pose_graph": self.folder / "loops.csv"}
        with sealed(made["odometry"]) as file:
            rows = np.zeros((len(sigmas_rad), 36))
            rows[:, 14] = np.square(sigmas_rad)
            file["covariance"] = rows if covariances is None else covariances
        made["pose_graph"].write_text("frame_a,frame_b,status,reason\n" + "".join(f"{a},{b},{status},\n" for a, b, status in loops))
        return list(part_checks(SimpleNamespace(made=lambda job, output: made[job])))

    def test_a_way_of_one_part(self):
        [found] = self.checks([0.01] * 10, [])
        self.assertEqual((found.verdict, found.value), (GOOD, 0))

    def test_a_part_is_joined_by_an_accepted_loop_alone(self):
        sigmas = [0.01] * 4 + [3.0] + [0.01] * 5
        for loops, verdict in (([(1, 7, "accepted")], GOOD), ([(1, 7, "rejected")], REFUSE), ([(6, 9, "accepted")], REFUSE), ([], REFUSE)):
            with self.subTest(loops):
                [found] = self.checks(sigmas, loops)
                self.assertEqual(found.verdict, verdict)
                if verdict == REFUSE:
                    self.assertIn("1 parts of the way lie where they were guessed to", found.advice)

    def test_parts_are_joined_by_chains(self):
        begins = np.array([5, 8, 20])
        self.assertEqual(parts_apart(begins, []), 3)
        self.assertEqual(parts_apart(begins, [(6, 21), (4, 9)]), 2)
        self.assertEqual(parts_apart(begins, [(6, 21), (4, 9), (10, 22)]), 0)
        self.assertEqual(parts_apart(begins, [(7, 8), (5, 20)]), 3)

    def test_a_way_of_another_system(self):
        self.assertEqual(list(part_checks(SimpleNamespace(made=lambda job, output: None))), [])

    def test_a_damaged_file_is_named(self):
        with self.assertRaisesRegex(DataError, r"edges\.h5"):
            self.checks([], [], np.zeros(3))
