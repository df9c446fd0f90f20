# SPDX-License-Identifier: Apache-2.0
"""seeds.py: medians, missing values, and the insertion into a page."""

import json
import unittest
from pathlib import Path
from unittest import mock

import fake_site
from folder_case import FolderTest
import seeds


def metrics(ate_m, recall=None):
    queries = {"median_translation_error_cm": recall}
    return {"trajectory": {"se3": {"ate_rmse_m": ate_m}}, "queries": queries}


class TableTest(unittest.TestCase):
    ATE = ("trajectory.se3.ate_rmse_m", 100, "{:.2f}")
    MEDIAN = ("queries.median_translation_error_cm", 1, "{:.1f}")

    def test_median_over_seeds(self):
        values = [metrics(0.03), metrics(0.01), metrics(0.08)]
        self.assertEqual(seeds.cell(values, *self.ATE), "3.00")

    def test_one_bad_seed_shows_where_it_matters(self):
        loops = [{"loops": {"num_false_accepted": n, "revisits_closed_percent": 100 - n}} for n in (0, 0, 7)]
        table = seeds.make_table({"a": loops})
        self.assertIn("| false loops accepted, worst seed | 7 |", table)
        self.assertIn("| revisits closed, worst seed (%) | 93 |", table)

    def test_both_ways_to_measure_queries_are_shown(self):
        errors = {way: {"median_translation_error_cm": cm, "recall_2cm_2deg_percent": 9 * cm}
                  for way, cm in (("global", 4), ("local", 2))}  # fmt: skip
        table = seeds.make_table({"a": [{"queries": errors}]})
        for row in ("| global median (cm) | 4.0 |", "| local median (cm) | 2.0 |", "| local 2 cm, 2 deg (%) | 18 |"):
            self.assertIn(row, table)

    def test_missing_values_are_told(self):
        self.assertEqual(seeds.cell([metrics(0, 2.0), metrics(0)], *self.MEDIAN), "n/a")
        values = [metrics(0, 2.0), metrics(0, 4.0), metrics(0)]
        self.assertEqual(seeds.cell(values, *self.MEDIAN), "4.0 (2 of 3 seeds)")

    def test_one_column_a_site(self):
        table = seeds.make_table({"a": [metrics(0.01)], "b": [metrics(0.02)]})
        self.assertIn("| ATE RMSE, SE(3) (cm) | 1.00 | 2.00 |", table)
        self.assertNotIn("occupied", table)


class RunTest(FolderTest):
    def command(self, text, data="/data", **more):
        """Runs seed 3 of a column; returns the command of make."""
        with mock.patch("seeds.subprocess.run") as run:
            run.return_value.returncode = 0
            seeds.run_make(seeds.Column.of(text), 3, Path("/maps"), data, **more)
        return run.call_args.args[0]

    def test_a_folder_for_each_seed_means_a_building_for_each_seed(self):
        another, same = self.command("demo", "/data/{seed}"), self.command("office")
        self.assertIn("DATA=/data/3", another)
        self.assertIn("SET=synthesize.seed=3", another)
        self.assertIn("SET=w.noise=4", self.command("demo", "/data/{seed}", vary="w.noise"))
        self.assertIn("DATA=/data", same)
        self.assertFalse([word for word in same if word.startswith(("SET=", "PROFILE="))])

    def test_a_column_names_site_profile_and_values(self):
        words = self.command("tests/bench/laser/no_wheels:as_published+grid.a=1+grid.b=2", "/data/{seed}")
        for word in ("SITE=no_wheels", f"SITES={seeds.CHECKOUT}/tests/bench/laser", "PROFILE=as_published",
                     "SET=grid.a=1 grid.b=2 synthesize.seed=3"):  # fmt: skip
            self.assertIn(word, words)
        self.assertEqual(seeds.Column.of("tests/bench/laser/no_wheels:other").text, "no_wheels:other")

    def test_a_profile_and_values_have_maps_of_their_own(self):
        columns = ("demo", "demo:other", "demo+grid.a=1", "demo:other+grid.a=1", "demo+grid.a=2")
        folders = [seeds.Column.of(text).maps("/maps", 3) for text in columns]
        self.assertEqual(folders[:2], [Path("/maps/seed_3"), Path("/maps/other/seed_3")])
        self.assertEqual(len(set(folders)), len(columns))
        self.assertRegex(str(folders[3]), r"^[\w./-]+$")  # make refuses other names


class CollectTest(FolderTest):
    def test_collects_and_writes(self):
        for seed in range(2):
            out = self.folder / f"seed_{seed}" / "office" / "evaluate"
            out.mkdir(parents=True)
            (out / "metrics.json").write_text(json.dumps(metrics(0.02)))
        page = self.write("page.md", "<!-- accuracy:begin --><!-- accuracy:end -->")
        arguments = ("office", "--seeds", "2", "--maps", self.folder, "--no-run", "--page", page)
        result = fake_site.run("seeds.py", *arguments)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("| 2.00 |", page.read_text())
        self.assertEqual(fake_site.run("seeds.py", "office", "--seeds", "0").returncode, 2)
        more = ("office", "--seeds", "3", "--maps", self.folder, "--no-run")
        missing = fake_site.run("seeds.py", *more)
        self.assertEqual(missing.returncode, 1)
        for content in ("", "[", '{"trajectory": {"se3": {"ate_rmse_m": "0.1"}}}', '{"queries": {"num_wrong": 1e999}}'):
            (out / "metrics.json").write_text(content)
            damaged = fake_site.run("seeds.py", *arguments)
            self.assertEqual(damaged.returncode, 1)
            self.assertRegex(damaged.stderr, "^error: .*seed_1/office/evaluate/metrics.json[^\n]*delete the file[^\n]*\n$")
