# SPDX-License-Identifier: Apache-2.0
"""Lines before ctest's summary."""
import pathlib
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

from summary import SHOWN, with_summary  # noqa: E402

SUMMARY = ["92% tests passed, 1 tests failed out of 12\n", "\n", "Total Test time (real) =  70.00 sec\n"]
LOG = """12/12 Testing: base
[==========] Running 3 tests from 2 test suites.
tests/base/files_test.cc:12: Skipped
data/tum is missing: set NIGHTMAP_DATA

[==========] 3 tests from 2 test suites ran. (12 ms total)
test_b (bar_test.BarTest.test_b) ... skipped 'no recording: set NIGHTMAP_DATA'
Ran 39 tests in 0.5s
passed before, and nothing changed
"""


class SummaryTest(unittest.TestCase):
    def test_counts_skipped_and_the_slowest_stand_before_the_summary(self):
        lines = [f" {i}/12 Test  #{i}: stages/plan{i} ....   Passed    {i}.50 sec\n" for i in range(1, 12)]
        lines.append("12/12 Test #12: e2e/chain_test ...***Failed  100.25 sec\n")
        out = list(with_summary([*lines, "  said by a test: 3 sec\n", *SUMMARY], lambda: LOG))
        self.assertEqual([line for line in out if line in lines], lines)
        self.assertEqual(out[-3:], SUMMARY)
        self.assertIn("42 tests in 2 programs\n", out)
        self.assertIn("1 programs passed before, and nothing changed\n", out)
        self.assertIn("skipped: data/tum is missing: set NIGHTMAP_DATA\n", out)
        self.assertIn("skipped: no recording: set NIGHTMAP_DATA\n", out)
        shown = [line.split() for line in out if " s  " in line]
        self.assertEqual(len(shown), SHOWN)
        self.assertEqual(shown[0], ["100.2", "s", "e2e/chain_test"])
        self.assertEqual(shown[-1], ["3.5", "s", "stages/plan3"])

    def test_no_tests(self):
        self.assertEqual(list(with_summary(SUMMARY, lambda: self.fail("there is no log"))), SUMMARY)
