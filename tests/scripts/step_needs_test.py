# SPDX-License-Identifier: Apache-2.0
"""step_needs.py: what a cluster is asked for, by declaration and by receipts."""

import json
from types import SimpleNamespace

from fake_site import CHECKOUT
from folder_case import FolderTest
from nightmap_make import step_needs
from nightmap_site.pipeline import read_pipeline

class StepNeedsTest(FolderTest):
    """features runs per shard with all threads, tiles once with one."""

    def setUp(self):
        jobs = read_pipeline(str(CHECKOUT / "configs")).jobs
        self.graph = SimpleNamespace(jobs={name: jobs[name] for name in ("features", "tiles", "report")},
                                     folder_of=lambda job: str(self.folder / job.folder))

    def receipt(self, name, peak_mb, wall_s):
        folder, _, base = name.partition("/")
        report = self.write(f"{folder}/{base.replace('receipt', 'report')}", "{}")
        self.write(name, json.dumps({"start_time": "2026-01-01T00:00:00Z", "outputs": [{"path": str(report)}],
                                     "peak_memory_bytes": peak_mb * 1e6, "wall_time_s": wall_s}))  # fmt: skip

    def needs(self):
        return {line.split()[0]: line.split()[1:] for line in step_needs.text(self.graph, "4").splitlines()}

    def test_before_any_run_the_declaration_counts(self):
        self.assertEqual(self.needs(), {"features": ["4", "2000", "0"], "tiles": ["1", "4000", "0"]})

    def test_then_the_largest_of_the_receipts_with_a_margin(self):
        for unit, peak_mb, wall_s in (("0000", 2000, 30), ("0001", 3000, 600), ("0002", 100, 1)):
            self.receipt(f"features/receipt_{unit}.json", peak_mb, wall_s)
        self.receipt("tiles/receipt.json", 10, 1)
        self.assertEqual(self.needs(), {"features": ["4", "4500", "40"], "tiles": ["1", "500", "10"]})

    def test_a_damaged_receipt_says_nothing(self):
        self.receipt("features/receipt_0000.json", 2000, 30)
        self.write("features/receipt_0001.json", '{"peak_memory_bytes": ')
        self.assertEqual(self.needs()["features"], ["4", "3000", "10"])
