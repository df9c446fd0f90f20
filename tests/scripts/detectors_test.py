# SPDX-License-Identifier: Apache-2.0
"""detectors.py: what is run, the table, and a detector that cannot map a site."""

import json
import re
from unittest import mock

import fake_site
import detectors
from folder_case import FolderTest
from nightmap_site.script_errors import DataError


class DetectorsTest(FolderTest):
    def test_every_detector_is_a_row_and_a_failed_run_a_missing_value(self):
        maps, settings = self.folder, []

        def run_make(site, seed, seed_maps, _, given):
            settings.append(given)
            if "brisk" in given[0] and seed > 0:
                raise DataError("features failed")
            path = seed_maps / site / "evaluate" / "metrics.json"
            path.parent.mkdir(parents=True)
            path.write_text(json.dumps({"trajectory": {"se3": {"ate_rmse_m": 0.01 * (seed + 1)}}}))

        page = maps / "figures.md"
        page.write_text("<!-- detectors:begin --><!-- detectors:end -->")
        with mock.patch("detectors.run_make", run_make):
            result = fake_site.run("detectors.py", "office", "--seeds", 3, "--maps", maps, "--page", page)
        self.assertEqual(result.returncode, 0, result.stderr)
        rows = [line.split(" | ") for line in page.read_text().splitlines() if line.startswith("| office")]
        self.assertEqual([row[1] for row in rows], list(detectors.DETECTORS))
        self.assertEqual([row[4] for row in rows], ["2.00", "2.00", "n/a", "2.00", "n/a"])
        self.assertEqual(settings[3], ['features.detector="orb"'])

    def test_the_unit_tests_try_every_row(self):
        table, tests = ((fake_site.CHECKOUT / name).read_text(encoding="utf-8") for name in (
            "pipeline/camera/extract_features.cc", "tests/camera/extract_features_test.cc"))  # fmt: skip
        rows = re.findall(r'\{"(\w+)", DescriptorKind::', table)
        self.assertIn("sift", rows)
        self.assertCountEqual(re.findall(r'"(\w+)"', re.search(r"kDetectors = \{(.*?)\}", tests, re.DOTALL)[1]), rows)
