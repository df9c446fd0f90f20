# SPDX-License-Identifier: Apache-2.0
"""ablation.py: options replaced in a config, and the table of several seeds."""

import unittest
from pathlib import Path
from unittest import mock

import fake_site  # noqa: F401  first: it makes the scripts importable
import ablation
from nightmap_site.script_errors import DataError

CONFIG = Path(__file__).resolve().parents[2] / "configs/camera/default/localize.toml"


def figures(median_cm, num_located, num_wrong=0):
    local = {"median_translation_error_cm": median_cm, "median_rotation_error_deg": 0.1,
             "recall_2cm_2deg_percent": 50, "recall_5cm_5deg_percent": 90}  # fmt: skip
    return {"local": local, "num_wrong": num_wrong, "num_queries": 10,
            "num_by_verdict": {"located": num_located, "ambiguous": 1}}  # fmt: skip


class AblationTest(unittest.TestCase):
    def test_every_variant_names_options_that_localize_has(self):
        config = CONFIG.read_text(encoding="utf-8")
        for name, options in ablation.variants():
            with self.subTest(name):
                changed = ablation.with_options(config, options)
                for option, value in options.items():
                    self.assertIn(f"\n{option} = {value}\n", f"\n{changed}")
                self.assertEqual(len(changed.splitlines()), len(config.splitlines()))

    def test_an_unknown_option_is_refused(self):
        with self.assertRaisesRegex(DataError, "no option speed"):
            ablation.with_options("seed = 0\n", {"speed": "9"})

    def test_row_has_the_medians_and_the_worst_seed(self):
        results = [(figures(1.0, 8), 0.01), (figures(3.0, 9, 2), 0.02), (figures(2.0, 10), 0.03)]
        site = mock.Mock()
        site.run.side_effect = results
        row = ablation.row(site, "a", {"solver": '"dlt6"'}, 3)
        self.assertEqual(row, ["a", "9", "1", "2", "2.00", "0.10", "50", "90", "20.0"])
        seeds = [call.args[0]["seed"] for call in site.run.call_args_list]
        self.assertEqual(seeds, ["0", "1", "2"])

    def test_a_median_that_is_a_failure_is_told(self):
        site = mock.Mock()
        site.run.side_effect = [(figures(None, 4), 0.01)]
        self.assertEqual(ablation.row(site, "a", {}, 1)[4], "n/a")
