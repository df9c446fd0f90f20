# SPDX-License-Identifier: Apache-2.0
"""Costs of a make that finds nothing to do, on the small building. (shards_test.py asks for many shards.)"""
import unittest

from cpu_time import in_yardsticks
from workspace import GOALS, Workspace


class CostsTest(unittest.TestCase):
    def test_a_second_make_does_nothing_quickly(self):
        work = Workspace.made(*GOALS).removed_after(self)
        self.assertEqual(work.make(*GOALS).returncode, 0)
        # One small Python program resolves the configs; the rest is Make's own.
        # (localize starts one program more, which prints the table of places.)
        goals = [goal for goal in GOALS if goal != "localize"]
        self.assertLess(in_yardsticks(lambda: work.make(*goals)), 2)
        self.assertEqual(work.make("-q", *GOALS).returncode, 0)
