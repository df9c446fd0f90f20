# SPDX-License-Identifier: Apache-2.0
"""Sections of the report on labelled voxels and on things."""

import base64
import io
import re
import tempfile
import unittest
from pathlib import Path
from unittest import mock

import numpy as np
from PIL import Image

import fake_site
import labels_site
from labels_site import CHAIR, TABLE, thing_box, thing_entry
from nightmap_eval.artifacts import to_json
from nightmap_eval.labels import label_accuracy, report_labels, report_things, thing_accuracy
from nightmap_eval.labels.report_things import name_places_m
from nightmap_eval.labels.voxel_labels import VoxelLabels
from nightmap_eval.metrics_json import read_metrics
from nightmap_site.script_errors import DataError


class SectionsTest(unittest.TestCase):
    def setUp(self):
        self.root = Path(self.enterContext(tempfile.TemporaryDirectory()))
        self.site_dir = labels_site.write_site(self.root)

    def site(self):
        return labels_site.opened(self.root)

    def whole_page(self):
        """evaluate.py, then report.py."""
        with mock.patch("nightmap_site.site.CONFIGS", self.root / "configs"):
            for script, out in (("evaluate.py", "evaluate/metrics.json"), ("report.py", "report/index.html")):
                result = fake_site.run(script, "--site-dir", self.site_dir, "--data", self.root, "--out", self.site_dir / out)
                self.assertEqual(result.returncode, 0, result.stderr)
        return (self.site_dir / "report" / "index.html").read_text()


class ReportLabelsTest(SectionsTest):
    def section(self, metrics=None):
        return "".join(report_labels.sections(self.site(), metrics or {}))

    def test_without_voxels_it_says_so(self):
        self.assertIn("The join_labels stage did not run.", self.section())
        labels_site.write_votes(self.site_dir, np.zeros((0, 3)), [0], [], [])
        self.assertIn("No voxel has a class", self.section())

    def test_classes_of_the_map_are_listed_with_color_and_size(self):
        labels_site.write_voxels(self.site_dir, labels_site.perfect_parts())
        section = self.section()
        rows = re.findall(r'background:(#\w+)"></span></td><td>(\w+)</td><td class="number">(\d+)</td>', section)
        self.assertEqual([(color, name) for color, name, _ in rows],
                         [("#808080", "wall"), ("#c0a080", "floor"), ("#0000ff", "table"), ("#00ff00", "chair")])  # fmt: skip
        self.assertEqual(section.count("data:image/png"), 2)
        self.assertNotIn("Furniture", section)
        self.assertEqual(section, self.section())

    def test_accuracy_stands_below(self):
        labels_site.write_voxels(self.site_dir, labels_site.perfect_parts())
        figures = label_accuracy.evaluate(self.site())
        self.assertRegex(self.section({"sections": {"join_labels": figures}}), r"sofa\) with the right class \(%\)</td><td class=.number.>100<")

    def test_names_are_text(self):
        names = ["none", "wall", "floor", "<b>$x</b>", "chair", "poster"]
        labels_site.write_voxels(self.site_dir, [(labels_site.face_points(TABLE), names[3])], names=names)
        section = self.section()
        self.assertIn("&lt;b&gt;$x", section)
        self.assertNotIn("<b>", section)


class FromAboveTest(unittest.TestCase):
    def from_above(self, keys, labels, *heights_m):
        voxels = VoxelLabels(0.5, np.array(keys), np.array(labels), ["a", "b"], ["#000000", "#ffffff"])
        return report_labels.from_above(voxels, *heights_m)

    def test_the_highest_below_the_limit_is_seen(self):
        image, extent_m = self.from_above([[0, 0, 0], [0, 0, 3], [0, 0, 9], [2, 1, 0]], [0, 1, 0, 0], -1, 2.2)
        self.assertEqual(image.tolist(), [[1, -1, -1], [-1, -1, 0]])
        self.assertEqual([float(value) for value in extent_m], [0, 1.5, 0, 1])

    def test_the_order_of_voxels_does_not_matter(self):
        self.assertEqual(self.from_above([[0, 0, 3], [0, 0, 0]], [1, 0], -1, 3)[0].tolist(), [[1]])

    def test_a_huge_map_gets_coarser_pixels(self):
        image, extent_m = self.from_above([[-32000, 0, 0], [32000, 5, 0]], [0, 1], -1, 3)
        self.assertLessEqual(max(image.shape), report_labels.MAX_SIDE_PX)
        self.assertGreaterEqual(extent_m[1], 16000.5)

    def test_nothing(self):
        self.assertEqual(self.from_above([[0, 0, 9]], [0], -1, 2)[0].tolist(), [[-1]])


class ReportThingsTest(SectionsTest):
    def section(self, metrics=None):
        return "".join(report_things.sections(self.site(), metrics or {}))

    def write_picture(self):
        color = np.zeros((60, 80, 3), np.uint8)
        color[20:40, 30:60] = (0, 0, 255)
        (self.root / "rgb").mkdir()
        Image.fromarray(color).save(self.root / "rgb" / "1.png")
        return {"time_ns": 1, "color_path": "rgb/1.png", "rectangle_px": [30, 20, 60, 40]}

    def test_without_the_job_or_things_it_says_so(self):
        self.assertIn("The things stage did not run.", self.section())
        labels_site.write_things(self.site_dir)
        self.assertIn("No thing was found.", self.section())

    def test_things_are_named_with_size_and_picture(self):
        view = self.write_picture()
        labels_site.write_voxels(self.site_dir, labels_site.perfect_parts())
        labels_site.write_things(self.site_dir, thing_entry("table_1", "table", thing_box(TABLE), best_view=view),
                                 thing_entry("chair_<b>$1", "chair", thing_box(CHAIR)))  # fmt: skip
        section = self.section()
        self.assertIn("<td>table_1</td><td>table</td><td>1.20 x 0.80 x 0.60</td>", section)
        self.assertIn("chair_&lt;b&gt;$1", section)
        self.assertIn("no picture", section)
        [jpeg] = re.findall(r"data:image/jpeg;base64,([^\"]+)", section)
        cut = np.asarray(Image.open(io.BytesIO(base64.b64decode(jpeg))))
        self.assertEqual(cut.shape[:2], (20 + 2 * 8, 30 + 2 * 8))
        self.assertGreater(cut[18, 23, 2], 150)
        self.assertEqual(section, self.section())

    def test_a_picture_may_be_damaged_and_a_rectangle_outside(self):
        view = self.write_picture()
        (self.root / "rgb" / "2.png").write_bytes(b"no picture")
        views = [view | {"rectangle_px": [300, 20, 310, 40]}, view | {"color_path": "rgb/2.png"}, view | {"color_path": "rgb/3.png"}]
        labels_site.write_things(self.site_dir, *(thing_entry(f"table_{i}", "table", TABLE, best_view=one) for i, one in enumerate(views)))
        self.assertEqual(self.section().count("no picture"), 3)

    def test_a_rectangle_at_the_edge_is_cut_there(self):
        cut = report_things.cut_out(Image.new("RGB", (80, 60)), (0, 0, 40, 20))
        self.assertEqual(cut.size, (50, 30))

    def test_hundreds_have_few_pictures(self):
        view = self.write_picture()
        labels_site.write_things(self.site_dir, *(thing_entry(f"table_{i}", "table", TABLE, best_view=view) for i in range(200)))
        section = self.section()
        self.assertIn("24 of the 200 things, spread over the list, have a picture.", section)
        self.assertEqual(section.count("data:image/jpeg"), 24)
        self.assertIn("<td>table_199</td>", section)

    def test_accuracy_stands_below(self):
        labels_site.write_voxels(self.site_dir, labels_site.perfect_parts())
        labels_site.write_things(self.site_dir, thing_entry("table_1", "table", thing_box(TABLE)))
        figures = thing_accuracy.evaluate(self.site())
        self.assertRegex(self.section({"sections": {"things": figures}}), r"0\.5 or more \(%\)</td><td class=.number.>50<")

    def test_names_of_things_at_one_place_stand_below_each_other(self):
        def thing(x_m):
            return mock.Mock(box=labels_site.UprightBox(np.array([x_m, 1.0, 0]), np.ones(3), 0))
        things = [thing(0), thing(0), thing(0.01), thing(9)]
        for one in things:
            one.name = "table_1"
        places = name_places_m(things, 0.01)
        np.testing.assert_allclose(places, [[0, 1], [0, 0.93], [0.01, 0.86], [9, 1]])

    def test_a_thing_is_on_the_highest_floor_below_it(self):
        floors = [{"number": 0, "height_m": 0.0}, {"number": 1, "height_m": 3.0}]
        for bottom_m, number in ((-9, 0), (0, 0), (2.2, 0), (2.8, 1), (9, 1)):
            thing = mock.Mock(box=labels_site.UprightBox(np.array([0, 0, bottom_m + 0.5]), np.array([1, 1, 0.5]), 0))
            self.assertEqual(report_things.floor_of(thing, floors)["number"], number)


class WholePageTest(SectionsTest):
    def test_a_page_with_both(self):
        labels_site.write_voxels(self.site_dir, labels_site.perfect_parts())
        labels_site.write_things(self.site_dir, thing_entry("table_1", "table", thing_box(TABLE)))
        page = self.whole_page()
        for said in ("<h2>What stands where</h2>", "Voxels against the made-up building", "<h2>Things</h2>", "Things against the made-up building"):
            self.assertEqual(page.count(said), 1, said)

    def test_a_page_without(self):
        page = self.whole_page()
        self.assertIn("The join_labels stage did not run.", page)
        self.assertIn("The things stage did not run.", page)

    def test_damaged_figures_are_named(self):
        path = self.root / "metrics.json"
        for figures in (5, {"has_truth": "yes"}, {"nowhere_percent": "much"}, {"classes": {"table": {"num_voxels": 0.5}}}, {"classes": {"table": 5}}):
            path.write_text(to_json({"sections": {"things": figures}}))
            with self.subTest(figures=figures), self.assertRaisesRegex(DataError, f"{path}: sections: things"):
                read_metrics(path)

    def test_figures_are_json(self):
        labels_site.write_voxels(self.site_dir, labels_site.perfect_parts())
        labels_site.write_things(self.site_dir, thing_entry("table_1", "table", thing_box(TABLE)))
        for module in (label_accuracy, thing_accuracy):
            to_json(module.evaluate(self.site()))


if __name__ == "__main__":
    unittest.main()
