# SPDX-License-Identifier: Apache-2.0
"""cloud_consistency.py: a row says what the report and the receipts of a cloud hold."""

import json
from unittest import mock

import fake_site
from folder_case import FolderTest
import cloud_consistency

REPORT = {"num_points": 50_800, "held_out_rays_agreeing_percent": 91.42, "held_out_rays_blocked_percent": 8.21}


def write_cloud(folder):
    folder.mkdir(parents=True)
    (folder / "report.json").write_text(json.dumps(REPORT))
    (folder / "receipt.json").write_text(json.dumps({"cpu_time_s": 1.74}))


class CloudConsistencyTest(FolderTest):
    def test_maps_each_value_and_prints_its_figures(self):
        for value in cloud_consistency.VALUES:
            write_cloud(self.folder / f"consistent_{value}" / "office" / "point_cloud")
        calls = []
        with mock.patch.object(cloud_consistency, "run_make", lambda *words: calls.append(words)):
            result = fake_site.run("cloud_consistency.py", "office", "--maps", self.folder)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual([call[4] for call in calls],
                         [[f"point_cloud.min_consistent_frames={value}"] for value in cloud_consistency.VALUES])  # fmt: skip
        self.assertIn("| office | 2 | 50.8 | 91.4 | 8.2 | n/a | 1.7 |", result.stdout)
