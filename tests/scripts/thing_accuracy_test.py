# SPDX-License-Identifier: Apache-2.0
"""Figures of a map's things against those of a made-up building."""

import tempfile
import unittest
from pathlib import Path

import numpy as np

import labels_site
from labels_site import CHAIR, FAR_CHAIR, TABLE, thing_box, thing_entry
from nightmap_eval.labels import thing_accuracy
from nightmap_eval.things import UprightBox
from nightmap_site.script_errors import DataError


def shifted(box, *by_m):
    return UprightBox(box.centre_m + by_m, box.half_size_m, box.heading_rad)


class ThingAccuracyTest(unittest.TestCase):
    def setUp(self):
        self.root = Path(self.enterContext(tempfile.TemporaryDirectory()))
        self.site_dir = labels_site.write_site(self.root)
        labels_site.write_voxels(self.site_dir, labels_site.perfect_parts())

    def evaluate(self, *things):
        """things: (class, box of the building); the map has them in its own frame."""
        entries = [thing_entry(f"{name}_{i}", name, thing_box(box)) for i, (name, box) in enumerate(things)]
        labels_site.write_things(self.site_dir, *entries)
        return thing_accuracy.evaluate(labels_site.opened(self.root))

    def test_perfect_things(self):
        found = self.evaluate(("chair", CHAIR), ("table", TABLE))
        self.assertEqual((found["num_true"], found["num_never_seen"], found["num_things"]), (2, 1, 2))
        self.assertEqual((found["found_percent"], found["false_percent"], found["nowhere_percent"]), (100, 0, 0))
        self.assertAlmostEqual(found["iou_median"], 1, 6)
        self.assertEqual({name: values["found_percent"] for name, values in found["classes"].items()}, {"chair": 100, "table": 100})

    def test_a_thing_of_another_class_is_false(self):
        found = self.evaluate(("chair", TABLE), ("chair", CHAIR))
        self.assertEqual((found["found_percent"], found["false_percent"], found["nowhere_percent"]), (50, 50, 50))
        self.assertEqual((found["classes"]["table"]["found_percent"], found["classes"]["chair"]["false_percent"]), (0, 50))
        self.assertIsNone(found["classes"]["table"]["false_percent"])

    def test_a_box_that_fits_badly_is_false_but_somewhere(self):
        found = self.evaluate(("table", shifted(TABLE, 0, 0, 0.3)))  # half of it: a third
        self.assertEqual((found["found_percent"], found["false_percent"], found["nowhere_percent"]), (0, 100, 0))
        self.assertAlmostEqual(found["classes"]["table"]["iou_median"], 1 / 3, 6)

    def test_of_two_boxes_on_one_thing_the_better_is_true(self):
        found = self.evaluate(("table", shifted(TABLE, 0, 0, 0.05)), ("table", TABLE))
        self.assertEqual((found["num_found"], found["classes"]["table"]["false_percent"], found["nowhere_percent"]), (1, 50, 0))
        self.assertAlmostEqual(found["classes"]["table"]["iou_median"], 1, 6)

    def test_what_was_never_seen_is_not_missed_but_is_no_mistake_either(self):
        found = self.evaluate(("chair", FAR_CHAIR))
        self.assertEqual((found["num_true"], found["found_percent"], found["false_percent"]), (2, 0, 0))

    def test_what_the_labels_call_something_else_was_seen(self):
        labels_site.write_voxels(self.site_dir, [(points, "poster") for points, _ in labels_site.perfect_parts()])
        self.assertEqual(self.evaluate()["num_true"], 2)

    def test_classes_that_the_truth_has_no_things_of_are_counted(self):
        found = self.evaluate(("poster", TABLE), ("table", TABLE))
        self.assertEqual((found["num_things"], found["num_judged"], found["num_of_other_classes"], found["false_percent"]), (2, 1, 1, 0))

    def test_no_things_are_a_result(self):
        found = self.evaluate()
        self.assertEqual((found["num_things"], found["found_percent"], found["false_percent"], found["iou_median"]), (0, 0, None, 0))

    def test_without_the_job_or_the_truth(self):
        self.assertEqual(thing_accuracy.evaluate(labels_site.opened(self.root)), {})
        (self.root / "made_up" / "truth" / "boxes.json").unlink()
        self.assertEqual(self.evaluate(("chair", CHAIR)), {"num_things": 1, "has_truth": False})

    def test_damaged_things_are_named(self):
        for change in ({"size_m": [1, 1]}, {"size_m": [1, 0, 1]}, {"best_view": {"time_ns": 1, "color_path": "a", "rectangle_px": [1]}}):
            labels_site.write_things(self.site_dir, thing_entry("bed_1", "table", TABLE, **change))
            with self.assertRaisesRegex(DataError, "things.json: thing 'bed_1': not a valid size"):
                thing_accuracy.evaluate(labels_site.opened(self.root))


class MatchTest(unittest.TestCase):
    def test_the_largest_overlap_first(self):
        best, is_true = thing_accuracy.match(np.array([[0.6, 0.7], [0.0, 0.9]]))
        self.assertEqual((best.tolist(), is_true.tolist()), ([0.6, 0.9], [True, True]))

    def test_empty(self):
        for shape in ((0, 3), (3, 0), (0, 0)):
            best, is_true = thing_accuracy.match(np.zeros(shape))
            self.assertEqual((len(best), len(is_true)), shape)


if __name__ == "__main__":
    unittest.main()
