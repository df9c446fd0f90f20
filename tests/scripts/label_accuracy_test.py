# SPDX-License-Identifier: Apache-2.0
"""Figures of labelled voxels against a made-up building."""

import dataclasses
import unittest

import numpy as np

import labels_site
from folder_case import FolderTest
from labels_site import face_points
from nightmap_eval.labels import label_accuracy
from nightmap_eval.labels.label_accuracy import Rectangle, TrueBuilding, box_distances_m, class_distances_m, rectangle_distances_m
from nightmap_eval.things import UprightBox
from nightmap_eval.labels.voxel_labels import VoxelLabels, read_voxel_labels
from nightmap_site.script_errors import DataError


class LabelsTest(FolderTest):
    def setUp(self):
        self.site_dir = labels_site.write_site(self.folder)

    def evaluate(self, parts=None, **options):
        if parts is not None:
            labels_site.write_voxels(self.site_dir, parts, **options)
        return label_accuracy.evaluate(labels_site.opened(self.folder))


class LabelAccuracyTest(LabelsTest):
    def test_a_perfect_map(self):
        found = self.evaluate(labels_site.perfect_parts())
        self.assertTrue(found["has_truth"])
        self.assertEqual((found["right_percent"], found["furniture_right_percent"], found["nowhere_percent"]), (100, 100, 0))
        self.assertEqual(found["num_furniture_voxels"], found["num_furniture_voxels_off_borders"])
        self.assertEqual(set(found["classes"]), {"wall", "floor", "table", "chair"})
        self.assertEqual(sum(of_class["num_voxels"] for of_class in found["classes"].values()), found["num_voxels"])
        self.assertTrue(all(list(row) == [name] for name, row in found["confusion"].items()))

    def test_a_swapped_class_is_found(self):
        parts = [(points, "table" if name == "chair" else name) for points, name in labels_site.perfect_parts()]
        found = self.evaluate(parts)
        self.assertEqual((found["classes"]["chair"]["right_percent"], found["classes"]["table"]["right_percent"]), (0, 100))
        num = {name: found["classes"][name]["num_voxels"] for name in ("chair", "table")}
        self.assertEqual(found["confusion"]["chair"], {"table": num["chair"]})
        self.assertAlmostEqual(found["furniture_right_percent"], 100 * num["table"] / (num["table"] + num["chair"]))

    def test_what_is_wrong_elsewhere_is_no_matter_of_furniture(self):
        parts = [(points, "poster" if name == "wall" else name) for points, name in labels_site.perfect_parts()]
        found = self.evaluate(parts)
        self.assertEqual(found["furniture_right_percent"], 100)
        self.assertLess(found["right_percent"], 100)

    def test_voxels_where_nothing_is(self):
        ghost = np.array([[0.0, 0, 1.5], [0, 0.5, 1.5], [0, 0.2, 1.5]])
        found = self.evaluate([*labels_site.perfect_parts(), (ghost, "chair")])
        self.assertEqual((found["num_nowhere"], found["right_percent"]), (3, 100))

    def test_voxels_on_borders_are_told_apart(self):
        """A thin poster on the table: whoever calls all of it a table is wrong there, but not away from it."""
        plate = UprightBox(labels_site.TABLE.centre_m + [0, 0, 0.31], np.array([0.2, 0.2, 0.01]), 0.3)
        labels_site.write_truth(self.folder / "made_up" / "truth", [*labels_site.BOXES, ("poster", plate)], [])
        found = self.evaluate([(points, "poster" if name == "table" else name) for points, name in labels_site.perfect_parts()])
        self.assertLess(found["num_furniture_voxels_off_borders"], found["num_furniture_voxels"])
        self.assertIn("poster", found["confusion"]["poster"])
        found = self.evaluate([*labels_site.perfect_parts(), (face_points(plate), "poster")])
        self.assertEqual(found["furniture_right_percent_off_borders"], 100)

    def test_a_class_whose_surface_is_in_the_voxel_is_right_with_borders(self):
        table, wall = labels_site.NAMES.index("table"), labels_site.NAMES.index("wall")
        voxels = VoxelLabels(0.05, np.zeros((4, 3), int), np.array([wall, wall, table, wall]), labels_site.NAMES, [])
        true = label_accuracy.TrueClasses(np.array([table, table, table, wall]), np.ones(4, bool), np.array([True, False, False, True]))
        found = label_accuracy.figures(voxels, true)
        self.assertAlmostEqual(found["furniture_right_percent"], 100 / 3)
        self.assertAlmostEqual(found["furniture_right_percent_with_borders"], 200 / 3)

    def test_a_surface_is_in_a_voxel_within_half_an_edge(self):
        labels_site.write_voxels(self.site_dir, labels_site.perfect_parts())
        site = labels_site.opened(self.folder)
        voxels = read_voxel_labels(site)
        true = label_accuracy.true_classes(site, voxels)
        self.assertTrue(0.5 < np.count_nonzero(true.is_inside) / len(true.is_inside) < 1)
        other = label_accuracy.true_classes(site, dataclasses.replace(voxels, labels=np.full_like(voxels.labels, voxels.names.index("chair"))))
        self.assertTrue(np.all(other.is_inside <= ((true.nearest == voxels.names.index("chair")) | true.is_border)))

    def test_the_order_of_the_model_is_its_own(self):
        found = self.evaluate(labels_site.perfect_parts(), names=labels_site.NAMES[::-1])
        self.assertEqual(found["right_percent"], 100)

    def test_other_classes_or_no_truth_give_counts_alone(self):
        names = [name.replace("chair", "stool") for name in labels_site.NAMES]
        labels_site.write_voxels(self.site_dir, labels_site.perfect_parts()[:1])
        num = len(read_voxel_labels(labels_site.opened(self.folder)).keys)
        self.assertEqual(self.evaluate(labels_site.perfect_parts()[:1], names=names), {"num_voxels": num, "has_truth": False})
        labels_site.write_voxels(self.site_dir, labels_site.perfect_parts()[:1])
        (self.folder / "made_up" / "truth" / "boxes.json").unlink()
        self.assertEqual(self.evaluate(), {"num_voxels": num, "has_truth": False})

    def test_without_voxels_there_is_no_figure(self):
        self.assertEqual(self.evaluate(), {})
        labels_site.write_votes(self.site_dir, np.zeros((0, 3)), [0], [], [])
        found = self.evaluate()
        self.assertEqual((found["num_voxels"], found["right_percent"], found["furniture_right_percent"]), (0, None, None))

    def test_damaged_truth_is_named(self):
        labels_site.write_voxels(self.site_dir, labels_site.perfect_parts()[:1])
        path = self.folder / "made_up" / "truth" / "boxes.json"
        whole = path.read_text()
        for before, after in (('"label": 3', '"label": 77'), ('"half_size_m": [', '"half_size_m": [1, '), ('"edge_u_m": [', '"edge_u_m": [1, ')):
            path.write_text(whole.replace(before, after, 1))
            with self.assertRaisesRegex(DataError, "boxes.json: not a valid box or rectangle"):
                self.evaluate()


class VoxelLabelsTest(LabelsTest):
    def labels_of(self, *votes):
        labels_site.write_votes(self.site_dir, *votes)
        return read_voxel_labels(labels_site.opened(self.folder)).labels.tolist()

    def test_the_most_weight_counts_and_the_first_of_equal_ones(self):
        keys = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
        self.assertEqual(self.labels_of(keys, [0, 2, 3, 6], [1, 3, 2, 1, 4, 5], [0.5, 2, 1, 1, 3, 3]), [3, 2, 4])

    def test_damaged_votes_are_named(self):
        for offsets, votes in (([0, 1, 1], [1]), ([0, 1, 3], [1, 2]), ([0, 1, 2], [1, 77]), ([1, 2, 2], [1, 1]), ([0, 2], [1, 1])):
            with self.subTest(offsets), self.assertRaisesRegex(DataError, "voxels.h5: damaged"):
                self.labels_of([[0, 0, 0], [1, 0, 0]], offsets, votes, [1] * len(votes))

    def test_damaged_colors_are_named(self):
        self.labels_of([[0, 0, 0]], [0, 1], [1], [1])
        legend = self.site_dir / "voxel_labels" / "legend.json"
        legend.write_text(legend.read_text().replace("#0000ff", "red;}"))
        with self.assertRaisesRegex(DataError, "legend.json: a color"):
            read_voxel_labels(labels_site.opened(self.folder))


class ClassDistancesTest(unittest.TestCase):
    def test_faces_of_a_box_from_outside_and_inside(self):
        box = UprightBox(np.array([1.0, 0, 0]), np.array([2.0, 1, 0.5]), np.pi / 2)
        points = np.array([[1.0, 0, 0], [1, 0, 0.4], [1, 0, 0.7], [2.5, 0, 0], [1, 1.9, 0], [2 + 3, 2 + 4, 0]])
        np.testing.assert_allclose(box_distances_m(points, box), [0.5, 0.1, 0.2, 0.5, 0.1, 5], atol=1e-12)

    def test_rectangles(self):
        rectangle = Rectangle(np.array([0.0, 0, 1]), np.array([[2.0, 0, 0], [0, 1, 0]]))
        points = np.array([[1.0, 0.5, 0], [2, 1, 1], [2, 1 + 3, 1 + 4], [-1, 0.5, 1]])
        np.testing.assert_allclose(rectangle_distances_m(points, rectangle), [1, 0, 5, 1])

    def test_equals_trying_all(self):
        random = np.random.default_rng(3)
        boxes = [(int(random.integers(3)), UprightBox(random.uniform(-2, 2, 3), random.uniform(0.05, 1, 3), random.uniform(0, 6))) for _ in range(30)]
        points, reach_m = random.uniform(-3, 3, (3000, 3)), 0.2
        expected = np.full((3, len(points)), np.inf)
        for label, box in boxes:
            expected[label] = np.minimum(expected[label], box_distances_m(points, box))
        expected[expected > reach_m] = np.inf
        found = class_distances_m(points, TrueBuilding(["a", "b", "c"], boxes, [], []), reach_m)
        np.testing.assert_allclose(found, expected, atol=1e-6)
