# SPDX-License-Identifier: Apache-2.0
"""bench_shards.py: what it measures is a site that was made, and its table goes between the markers."""

import argparse
import tempfile
import unittest
from pathlib import Path
from unittest import mock

import fake_site  # noqa: F401  first: it makes the benchmarks importable

import bench_shards
from nightmap_site.script_errors import DataError


class BenchShardsTest(unittest.TestCase):
    def test_times_of_a_few_shards(self):
        times = bench_shards.measure(4, num_runs=1)
        self.assertEqual(len(times), len(bench_shards.TITLES) - 1)
        for wall_s, cpu_s in times:
            self.assertLess(0, wall_s)
            self.assertLess(0, cpu_s)
        self.assertGreater(times[0][1], max(cpu_s for _, cpu_s in times[1:]))  # only the first ran programs

    def test_a_run_that_fails_is_told(self):
        site = bench_shards.StubSite()
        self.addCleanup(site.remove)
        with self.assertRaisesRegex(DataError, "make -q map of 4 shards"):  # nothing is made yet
            bench_shards.timed(site, ["-q", "map"], 4)

    def test_the_table_goes_between_the_markers(self):
        page = tempfile.NamedTemporaryFile("w+", suffix=".md")
        self.addCleanup(page.close)
        page.write("before\n<!-- bench_shards:begin -->\nold\n<!-- bench_shards:end -->\nafter\n")
        page.flush()
        arguments = argparse.Namespace(shards=[1000], runs=3, page=Path(page.name))
        with mock.patch.object(bench_shards, "parse_arguments", lambda: arguments), \
             mock.patch.object(bench_shards, "measure", lambda *_: [(1.0, 0.5)] * 4), mock.patch("builtins.print"):
            bench_shards.main()
        text = Path(page.name).read_text(encoding="utf-8")
        self.assertIn("| 1,000 | 1.00 (CPU 0.50) |", text)
        self.assertTrue(text.startswith("before") and text.endswith("after\n") and "old" not in text, text)
