# SPDX-License-Identifier: Apache-2.0
"""A short sweep of attacks on programs and scripts (tests/fuzz/sweep.py; `make test-nightly` runs 2,000)."""
import os
import pathlib
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "fuzz"))

from sweep import run_sweep  # noqa: E402

NUM_RUNS = int(os.environ.get("NIGHTMAP_NUM_ATTACKS", 100))


class SweepTest(unittest.TestCase):
    def test_no_attack_ends_in_a_signal_a_hang_a_traceback_or_a_touched_file(self):
        codes, violations = run_sweep(0, NUM_RUNS, os.cpu_count())
        self.assertEqual(violations, [])
        self.assertEqual(sum(codes.values()), NUM_RUNS)
        # Attacks that nothing notices would show nothing: most must be refused or told of.
        self.assertGreater(codes[1] + codes[2], NUM_RUNS / 3, codes)
