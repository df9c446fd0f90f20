#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""A site of many shards, made by stub programs: how long make takes that finds nothing to do. NIGHTMAP_NIGHTLY=1 tries
1,000 and 5,000 shards too, which takes minutes to make; tests/bench/bench_shards.py measures the same."""
import time
import unittest

from nightly import nightly
from stub_site import StubSite

LOOKS = (["map"], ["-q", "map"], ["why"])


class ManyShardsTest(unittest.TestCase):
    def check(self, num_shards, limit_s):
        site = StubSite()
        self.addCleanup(site.remove)
        result = site.make("-j2", "map", num_shards=num_shards)
        self.assertEqual(result.returncode, 0, result.stdout[-4000:])
        self.assertEqual(len(list(site.path("features").glob("shard_*.h5"))), num_shards)
        for goals in LOOKS:
            with self.subTest(goals):
                self.assertLessEqual(min(self.time_s(site, goals) for _ in range(3)), limit_s)

    def time_s(self, site, goals):
        start_s = time.monotonic()
        result = site.make(*goals)
        self.assertEqual(result.returncode, 0, result.stdout[-4000:])
        return time.monotonic() - start_s

    def test_two_hundred_shards(self):
        self.check(200, limit_s=1)

    @nightly
    def test_a_thousand_shards(self):
        self.check(1000, limit_s=1)

    @nightly
    def test_five_thousand_shards(self):
        self.check(5000, limit_s=3)


if __name__ == "__main__":
    unittest.main()
