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
        errors = {way: {"median_translation_error_cm": cm, "recall_1cm_1deg_percent": 9 * cm}
                  for way, cm in (("global", 4), ("local", 2))}  # fmt: skip
        table = seeds.make_table({"a": [{"queries": errors}]})
        for row in ("| global median (cm) | 4.0 |", "| local median (cm) | 2.0 |", "| local 1 cm, 1 deg (%) | 18 |"):
            self.assertIn(row, table)

    def test_missing_values_are_told(self):
        self.assertEqual(seeds.cell([metrics(0, 2.0), metrics(0)], *self.MEDIAN), "n/a")
        values = [metrics(0, 2.0), metrics(0, 4.0), metrics(0)]
        self.assertEqual(seeds.cell(values, *self.MEDIAN), "4.0 (2 of 3 seeds)")

    def test_one_column_a_site(self):
        table = seeds.make_table({"a": [metrics(0.01)], "b": [metrics(0.02)]})
        self.assertIn("| ATE RMSE, SE(3) (cm) | 1.00 | 2.00 |", table)
        self.assertNotIn("occupied", table)


class RunTest(unittest.TestCase):
    def test_a_folder_for_each_seed_means_a_building_for_each_seed(self):
        with mock.patch("seeds.subprocess.run") as run:
            run.return_value.returncode = 0
            seeds.run_make("demo", 3, Path("/maps/seed_3"), "/data/{seed}")
            seeds.run_make("office", 3, Path("/maps/seed_3"), "/data")
        another, same = (call.args[0] for call in run.call_args_list)
        self.assertIn("DATA=/data/3", another)
        self.assertIn("SET=synthesize.seed=3", another)
        self.assertIn("DATA=/data", same)
        self.assertFalse([word for word in same if word.startswith("SET=")])

    def test_a_profile_has_maps_of_its_own(self):
        with mock.patch("seeds.subprocess.run") as run, mock.patch("seeds.read_json", return_value={}) as read:
            run.return_value.returncode = 0
            with mock.patch("sys.argv", ["seeds.py", "demo", "demo:as_published", "--seeds", "1", "--maps", "/maps"]):
                arguments = seeds.parse_arguments()
            for site in arguments.sites:
                seeds.collect(arguments, site)
        own, other = (call.args[0] for call in run.call_args_list)
        self.assertEqual(set(other) - set(own), {"PROFILE=as_published", "MAPS=/maps/as_published/seed_0"})
        self.assertFalse([word for word in own if word.startswith("PROFILE=")])
        self.assertEqual(str(read.call_args.args[0]), "/maps/as_published/seed_0/demo/evaluate/metrics.json")

    def test_values_over_the_profile_reach_make(self):
        with mock.patch("seeds.subprocess.run") as run:
            run.return_value.returncode = 0
            seeds.run_make("demo", 3, Path("/maps/seed_3"), "/data/{seed}", ["grid.a=1"])
        self.assertIn("SET=grid.a=1 synthesize.seed=3", run.call_args.args[0])


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
