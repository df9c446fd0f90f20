# SPDX-License-Identifier: Apache-2.0
"""bench_relocalization.py and stage_run.py: rows are medians, failures are infinite, and no pose is right in another building."""

import unittest
from pathlib import Path
from types import SimpleNamespace

import fake_site
import numpy as np

import bench_relocalization as bench
from folder_case import FolderTest
from nightmap_site.script_errors import DataError
from stage_run import Programs, changed_config

HEADER = "query_idx,time_ns,color_path,status,reason,position_sigma_m,rotation_sigma_deg,tx_m,ty_m,tz_m,qx,qy,qz,qw\n"
RESULT = SimpleNamespace(wall_time_s=lambda: 2.0, cpu_time_s=lambda: 3.0)


def write_queries(path, statuses, offset_m=0.0):
    """Queries along x, a metre apart; the located ones are off by this."""
    rows = []
    for i, status in enumerate(statuses):
        reason = "" if status == "located" else "rival_place"
        rows.append(f"{i},{(i + 1) * 10**9},{i},{status},{reason},0.02,0.1,{i + offset_m},0,0,0,0,0,1\n")
    path.write_text(HEADER + "".join(rows))


def write_truth(path, num):
    path.write_text("".join(f"{i + 1}.000000000 {i} 0 0 0 0 0 1\n" for i in range(num)))


class FiguresTest(FolderTest):
    def setUp(self):
        self.queries, self.truth = self.folder / "queries.csv", self.folder / "truth.tum"

    def run_figures(self, statuses, offset_m=0.0, truth=True):
        write_queries(self.queries, statuses, offset_m)
        write_truth(self.truth, len(statuses))
        return bench.run_figures(self.queries, self.truth if truth else None, RESULT)

    def test_shares_are_of_all_queries(self):
        found = self.run_figures(["located", "located", "ambiguous", "not_in_map"], 0.07)
        self.assertEqual((found["ambiguous_percent"], found["not_in_map_percent"], found["wrong_percent"]), (25, 25, 0))
        self.assertEqual((found["within_10cm_1deg_percent"], found["within_5cm_0.5deg_percent"]), (50, 0))
        self.assertEqual((found["wall_s"], found["cpu_s"]), (0.5, 0.75))
        self.assertAlmostEqual(found["p90_translation_error_per_sigma"], 3.5)

    def test_a_pose_far_off_is_a_wrong_place(self):
        self.assertEqual(self.run_figures(["located", "ambiguous"], 0.7)["wrong_percent"], 50)

    def test_every_pose_in_another_building_is_wrong(self):
        found = self.run_figures(["located", "not_in_map", "not_in_map", "ambiguous"], truth=False)
        self.assertEqual((found["wrong_percent"], found["not_in_map_percent"], found["ambiguous_percent"]), (25, 50, 25))
        self.assertNotIn("median_translation_error_cm", found)

    def test_no_queries_are_an_error(self):
        for truth in (True, False):
            with self.assertRaisesRegex(DataError, "queries.csv: no scan was asked for"):
                self.run_figures([], truth=truth)


class FilterTest(FolderTest):
    def test_the_share_is_of_the_queries_near_objects(self):
        counts = {"num_queries_near_objects": 8, "num_queries_filtered_by_objects": 2}
        self.assertEqual(bench.filter_figures(counts), {"filtered_percent": 25})
        self.assertEqual(bench.filter_figures(dict.fromkeys(counts, 0)), {})

    def test_a_true_place_may_be_any_candidate(self):
        path = self.write("candidates.csv", "query_idx,rank,x_m,y_m\n0,0,5,0\n0,1,0.3,0\n0,2,0.2,0\n2,0,7,0\n")
        found = bench.candidate_figures(path, np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0], [3, 0, 0]]))
        self.assertEqual(found, {"has_true_place_percent": 25})


class TableTest(unittest.TestCase):
    def test_an_infinite_error_is_larger_than_all_others(self):
        self.assertEqual(bench.median([None, 2, 1]), 2)
        self.assertEqual(bench.median([None, 2, None]), float("inf"))
        self.assertEqual(bench.median([3]), 3)

    def test_a_cell_is_the_median_of_the_runs(self):
        runs = [{"a": 1.0, "b": None}, {"a": 5.0, "b": 2.0}, {"a": 3.0, "b": None}]
        self.assertEqual(bench.cell(runs, ("a",), 1), "3.0")
        self.assertEqual(bench.cell(runs, ("a", "b"), 0), "3 / inf")
        self.assertEqual(bench.cell([*runs, {"a": 1.0}], ("a", "b"), 0), "n/a")

    def test_a_line_has_every_column_of_the_head(self):
        text = bench.line("site", "case", [{"num_queries": 7}])
        self.assertEqual(text.count("|"), 3 + len(bench.COLUMNS))
        self.assertTrue(text.startswith("| site | case | 7 | n/a |"), text)

    def test_each_site_is_asked_for_scans_of_another(self):
        located = []

        class FakeSite:
            def __init__(self, name):
                self.dir, self.held_out = Path(name), bench.Questions(Path(name) / "queries.h5", Path("truth.tum"))

            def near(self, radius_m, seed):
                return bench.Questions(self.dir / f"near_{seed}", Path("truth.tum"))

            def objects(self):
                return self.dir / "objects.yaml"

            def moved_grid(self, share, seed, objects):
                return self.dir / f"moved_{seed}"

            def locate(self, questions, method, grid=None, objects=None):
                located.append((self.dir.name, questions, grid, objects, method))
                return {}

        arguments = SimpleNamespace(seeds=3, radius=5, share=0.3)
        rows = list(bench.cases([FakeSite("a"), FakeSite("b")], arguments))
        self.assertEqual([(site, len(runs)) for site, _, runs in rows],
                         [(site, count) for site in "ab" for count in (*2 * (1, 3, 3, 3, 3), 1, 1)])  # fmt: skip
        self.assertEqual([(name, str(asked.queries), method) for name, asked, _, _, method in located if asked.truth is None],
                         [(name, f"{other}/queries.h5", method) for name, other in ("ab", "ba") for method in bench.METHODS])  # fmt: skip
        for first in (1, 7, 14, 20):  # rows of the map as it was, then of moved furniture, of each method
            without, with_objects = located[first:first + 3], located[first + 3:first + 6]
            self.assertEqual([call[:3] for call in without], [call[:3] for call in with_objects])
            self.assertEqual([bool(call[3]) for call in (*without, *with_objects)], 3 * [False] + 3 * [True])


class ProgramsTest(FolderTest):
    def test_options_replace_values_of_the_config(self):
        self.assertEqual(changed_config("a = 1\nab = 2\n", {"a": 3, "c": 4.0}), "ab = 2\na = 3\nc = 4.0\n")
        self.assertEqual(changed_config("", {}), "")

    def test_a_program_that_fails_is_named(self):
        program = self.write("run/stage", '#!/bin/sh\necho "$@" > "$(dirname "$0")/words"\nexit 1\n')
        program.chmod(0o755)
        with self.assertRaisesRegex(DataError, "run/stage .*/out/y(.|\n)*the run failed"):
            Programs(self.folder, 2).run("stage", {"in": "x"}, {"csv": "y"}, self.folder / "out", seed=3)
        words = (program.parent / "words").read_text()
        self.assertIn("--threads 2", words)
        self.assertIn("--in in=x", words)
        self.assertIn(f"--out csv={self.folder}/out/y --out report={self.folder}/out/report.json", words)
        self.assertEqual((self.folder / "out/config.toml").read_text(), "seed = 3\n")

    def test_numbers_of_seeds_must_be_positive(self):
        for option in ("--seeds", "--radius"):
            self.assertEqual(fake_site.run("bench_relocalization.py", "x", "--build", "y", option, "0").returncode, 2)
