# SPDX-License-Identifier: Apache-2.0
"""The list of slow tests in the output of ctest."""
import pathlib
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

from slowest_tests import SHOWN, with_slowest  # noqa: E402

SUMMARY = ["\n", "92% tests passed, 1 tests failed out of 12\n", "\n", "Total Test time (real) =  70.00 sec\n"]


class SlowestTestsTest(unittest.TestCase):
    def test_the_slowest_stand_before_the_summary(self):
        lines = [f" {i}/12 Test  #{i}: base/Files.Test{i} ....   Passed    {i}.50 sec\n" for i in range(1, 12)]
        lines.append("12/12 Test #12: e2e/chain_test ...***Failed  100.25 sec\n")
        out = list(with_slowest([*lines, "  said by a test: 3 sec\n", *SUMMARY]))
        self.assertEqual([line for line in out if line in lines], lines)
        self.assertEqual(out[-3:], SUMMARY[1:])
        shown = [line.split() for line in out if " s  " in line]
        self.assertEqual(len(shown), SHOWN)
        self.assertEqual(shown[0], ["100.2", "s", "e2e/chain_test"])
        self.assertEqual(shown[-1], ["3.5", "s", "base/Files.Test3"])

    def test_no_tests(self):
        self.assertEqual(list(with_slowest(SUMMARY)), SUMMARY)


if __name__ == "__main__":
    unittest.main()
