# SPDX-License-Identifier: Apache-2.0
"""verdict_laser: of a robot without wheels in bare corridors nobody can know how far it went, and the verdict says so."""

import json
from types import SimpleNamespace

from folder_case import FolderTest
from nightmap_eval.laser.verdict_laser import unclear_checks
from nightmap_eval.verdict.verdict import GOOD, LOOK, REFUSE
from nightmap_site.script_errors import DataError


class UnclearTest(FolderTest):
    def checks(self, **report):
        path = self.write("report.json", json.dumps(report))
        return list(unclear_checks(SimpleNamespace(made=lambda job, output: path)))

    def test_a_share_of_the_scans_without_wheels(self):
        for num_unclear, verdict in ((0, GOOD), (40, GOOD), (60, LOOK), (240, LOOK), (250, REFUSE), (800, REFUSE)):
            with self.subTest(num_unclear=num_unclear):
                [found] = self.checks(num_scans=800, num_scans_unclear=num_unclear, odometry_sensor="")
                self.assertEqual(found.verdict, verdict)
                self.assertAlmostEqual(found.value, num_unclear / 8)
                if verdict != GOOD:
                    self.assertRegex(found.advice, "nobody can know how far the robot went there; record the odometry of wheels")

    def test_wheels_tell_the_way(self):
        self.assertEqual(self.checks(num_scans=800, num_scans_unclear=800, odometry_sensor="wheels"), [])

    def test_a_way_that_another_system_made_was_not_matched(self):
        self.assertEqual(list(unclear_checks(SimpleNamespace(made=lambda job, output: None))), [])

    def test_a_damaged_report_is_named(self):
        with self.assertRaisesRegex(DataError, r"report\.json"):
            self.checks(num_scans="many", num_scans_unclear=1, odometry_sensor="")
