# SPDX-License-Identifier: Apache-2.0
"""bench_night.py: tables and picture of what the programs cost at each size, and the row of a program that fails."""

from types import SimpleNamespace
from unittest import mock

from folder_case import FolderTest  # first: it makes scripts and benchmarks importable

import bench_night
from nightmap_site.script_errors import DataError

SITES = [(1000, {"vocabulary": (2.0, 4.0, 100, 10), "loops": (1.0, 1.0, 50, 1)}, {}),
         (4000, {"vocabulary": (3.0, 16.0, 200, 10)}, {"loops": "loops: too little memory"})]  # fmt: skip


class TablesTest(FolderTest):
    def test_growth_is_per_frame_against_the_first_size_and_a_failure_is_a_row(self):
        rows = bench_night.cost_rows(SITES)
        self.assertEqual([row[:2] for row in rows],
                         [["vocabulary", "1,000"], ["vocabulary", "4,000"], ["loops", "1,000"], ["loops", "4,000"]])  # fmt: skip
        self.assertEqual(rows[0][-2:], ["1.00", "1.00"])
        self.assertEqual(rows[1][-2:], ["1.00", "0.50"])
        self.assertEqual(rows[3][2], "failed: loops: too little memory")
        self.assertEqual({len(row) for row in rows}, {len(bench_night.TITLES)})

    def test_picture_of_the_growth(self):
        bench_night.plot(self.folder / "growth.svg", SITES)
        text = (self.folder / "growth.svg").read_text()
        self.assertIn("<svg", text)

    def test_programs_after_one_that_fails_do_not_run_and_their_errors_are_unknown(self):
        site = bench_night.Site.__new__(bench_night.Site)
        site.arguments = SimpleNamespace(memory=4, build=self.folder, threads=1, site_dir=None, data=None)
        site.folder, site.costs, site.failure = self.folder, {}, {}
        site.composer = SimpleNamespace(num_frames=1000, num_copies=2)
        asked = []

        def fails(job, programs, *_):
            asked.append((job.name, programs.launcher))
            raise DataError("build/run/vocabulary --in a\n09:00:00 error vocabulary: out of memory with features=/a/b, /a/c\nthe run failed, see above")

        with mock.patch.object(bench_night.run, "run", fails):
            site.map()
        self.assertEqual(asked, [("vocabulary", (*bench_night.SHELL, "prlimit", f"--as={4 << 30}"))])
        self.assertEqual(site.failure, {"vocabulary": "vocabulary: out of memory with"})
        self.assertEqual(site.errors(), ["1,000", "2", *["n/a"] * (len(bench_night.ERRORS) - 2)])
