# SPDX-License-Identifier: Apache-2.0
"""verdict_held_out: one look-alike is no fault, several scans found elsewhere are, and so is a map whose drawings of a place lie apart."""

import numpy as np

from fake_site import write_tum
from folder_case import FolderTest
from nightmap_eval.laser.scan_relocalization import held_out_checks, read_scans
from nightmap_eval.trajectory import Trajectory
from nightmap_eval.verdict.verdict import GOOD, LOOK, NOT_KNOWN, REFUSE

COLUMNS = "query_idx,time_ns,color_path,status,reason,tx_m,ty_m,tz_m,qx,qy,qz,qw,position_sigma_m,rotation_sigma_deg"
ELSEWHERE, SPREAD = "scans kept out and found elsewhere", "spread of scans kept out"


def located(folder, errors_m, num_ambiguous=0):
    """Results that scan_localize wrote of scans along a line, each located this far from its true place."""
    rows = [COLUMNS]
    for i, error_m in enumerate([*errors_m, *[None] * num_ambiguous]):
        pose = "," * 8 if error_m is None else f"{i},{error_m},0,0,0,0,1,0.01,0.1"
        rows.append(f"{i},{10**9 * (i + 1)},,{'ambiguous,rival' if error_m is None else 'located,'},{pose}")
    (folder / "queries.csv").write_text("\n".join(rows) + "\n")
    count = len(rows) - 1
    positions_m = np.column_stack([np.arange(count), np.zeros((count, 2))])
    write_tum(folder / "truth.tum", Trajectory(10**9 * (1 + np.arange(count)), positions_m, np.tile([0.0, 0, 0, 1], (count, 1))))
    return read_scans(folder / "queries.csv", folder / "truth.tum")


class HeldOutTest(FolderTest):
    def checks(self, errors_m, **ambiguous):
        return {item.name: item for item in held_out_checks(located(self.folder, errors_m, **ambiguous))}

    def test_a_map_that_agrees_with_itself_is_good(self):
        found = self.checks(np.linspace(0.0, 0.04, 60))
        self.assertEqual({item.verdict for item in found.values()}, {GOOD})
        self.assertAlmostEqual(found[SPREAD].value, 2, places=6)

    def test_the_first_that_is_elsewhere_may_be_a_look_alike(self):
        for count, num_wrong, verdict in ((12, 1, GOOD), (12, 2, LOOK), (69, 2, GOOD), (69, 10, LOOK), (69, 15, REFUSE), (200, 7, LOOK)):
            with self.subTest(count=count, num_wrong=num_wrong):
                found = self.checks([2.0] * num_wrong + [0.01] * (count - num_wrong))
                self.assertEqual(found[ELSEWHERE].verdict, verdict)
                self.assertAlmostEqual(found[ELSEWHERE].value, 100 * num_wrong / count)
                self.assertEqual("the map contradicts itself" in found[ELSEWHERE].advice, verdict != GOOD)
                self.assertEqual(found[SPREAD].verdict, GOOD)

    def test_drawings_that_lie_apart_spread_the_scans(self):
        found = self.checks([0.15] * 30)
        self.assertEqual((found[ELSEWHERE].verdict, found[SPREAD].verdict), (GOOD, LOOK))
        for word in ("15 cm", "loops", "wheels", "scanner"):
            self.assertIn(word, found[SPREAD].advice)

    def test_scans_that_are_not_located_count_for_nothing(self):
        found = self.checks([2.0, 2.0] + [0.01] * 18, num_ambiguous=80)
        self.assertAlmostEqual(found[ELSEWHERE].value, 10)

    def test_few_scans_tell_nothing(self):
        found = self.checks([2.0] * 9, num_ambiguous=30)
        self.assertEqual([item.verdict for item in found.values()], [NOT_KNOWN])
        self.assertIn("9 of 39 scans", found[ELSEWHERE].advice)
        self.assertEqual([item.verdict for item in self.checks([]).values()], [NOT_KNOWN])
