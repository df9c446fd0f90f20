# SPDX-License-Identifier: Apache-2.0
"""The table of detectors: the unit tests and the figures try each of its rows."""

import re
import unittest

import fake_site
import figures


class DetectorsTest(unittest.TestCase):
    def test_the_unit_tests_try_every_row(self):
        table, tests = ((fake_site.CHECKOUT / name).read_text(encoding="utf-8") for name in (
            "pipeline/camera/extract_features.cc", "tests/camera/extract_features_test.cc"))  # fmt: skip
        rows = re.findall(r'\{"(\w+)", DescriptorKind::', table)
        self.assertCountEqual(re.findall(r'"(\w+)"', re.search(r"kDetectors = \{(.*?)\}", tests, re.DOTALL)[1]), rows)
        self.assertCountEqual([*figures.DETECTORS, "sift", "harris"], rows)  # harris is for ceilings
