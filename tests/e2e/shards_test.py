# SPDX-License-Identifier: Apache-2.0
"""A site of many shards, made by stub programs: the CPU time of a make that finds nothing to do. NIGHTMAP_NIGHTLY=1 tries
1,000 and 5,000 shards too, which takes minutes to make; tests/bench/bench_shards.py measures the same in seconds."""
import unittest

from cpu_time import in_yardsticks
from nightly import nightly
from stub_site import StubSite

LOOKS = (["map"], ["-q", "map"], ["why"])


class ManyShardsTest(unittest.TestCase):
    def check(self, num_shards, max_yardsticks):
        site = StubSite().removed_after(self)
        site.output("-j2", "map", num_shards=num_shards)
        self.assertEqual(len(list(site.path("features").glob("shard_*.h5"))), num_shards)
        for goals in LOOKS:
            with self.subTest(goals):
                self.assertLessEqual(in_yardsticks(lambda: self.look(site, goals), num_runs=3), max_yardsticks)

    def look(self, site, goals):
        site.output(*goals)

    def test_two_hundred_shards(self):
        self.check(200, max_yardsticks=4)

    @nightly
    def test_a_thousand_shards(self):
        self.check(1000, max_yardsticks=12)

    @nightly
    def test_five_thousand_shards(self):
        self.check(5000, max_yardsticks=45)
