# SPDX-License-Identifier: Apache-2.0
"""Intersection over union of upright boxes, where it is known."""

import unittest

import numpy as np

import fake_site  # noqa: F401  (it makes scripts/ importable)
from nightmap_eval.things import UprightBox, iou


def box(centre=(0, 0, 0), size=(2, 2, 2), heading_rad=0.0):
    return UprightBox(np.array(centre, float), np.array(size, float) / 2, heading_rad)


class IouTest(unittest.TestCase):
    def check(self, a, b, expected):
        self.assertAlmostEqual(iou(a, b), expected, 12)
        self.assertAlmostEqual(iou(b, a), expected, 12)

    def test_known_overlaps(self):
        octagon = 2 * 4 * (np.sqrt(2) - 1)  # that two squares of side 2 share when one is turned by an eighth
        lying, turned = box(size=(1, 3, 2)), box(size=(1, 3, 2), heading_rad=np.pi)
        for name, a, b, expected in (
            ("itself", box((1, 2, 3), (1, 4, 2), 0.7), box((1, 2, 3), (1, 4, 2), 0.7), 1),
            ("turned by a quarter", lying, box(size=(3, 1, 2), heading_rad=np.pi / 2), 1), ("turned by two quarters", lying, turned, 1),
            ("apart in the plane", box(), box((2.01, 0, 0)), 0), ("apart in height", box(), box((0, 0, 2.01)), 0),
            ("touching", box(), box((2, 0, 0)), 0), ("apart and turned", box(), box((2.5, 2.5, 0), heading_rad=np.pi / 4), 0),
            ("half in each other", box(), box((1, 0, 0)), 1 / 3), ("half above", box(), box((0, 0, 1)), 1 / 3),
            ("one in the other", box(size=(4, 4, 4)), box(size=(2, 2, 2), heading_rad=0.4), 1 / 8),
            ("turned by an eighth", box(), box(heading_rad=np.pi / 4), octagon / (8 - octagon)),
            ("a cross", box(size=(4, 1, 1)), box(size=(4, 1, 1), heading_rad=np.pi / 2), 1 / 7)):  # fmt: skip
            with self.subTest(name):
                self.check(a, b, expected)

    def test_turning_and_moving_both_changes_nothing(self):
        random = np.random.default_rng(0)
        for _ in range(20):
            a, b = (box(random.uniform(-0.5, 0.5, 3), random.uniform(1, 3, 3), random.uniform(0, 6)) for _ in range(2))
            turn = random.uniform(0, 6)
            rotation = fake_site.rotation_about([0, 0, 1], turn)
            others = [UprightBox(rotation @ one.centre_m + [5, 6, 7], one.half_size_m, one.heading_rad + turn) for one in (a, b)]
            self.check(a, b, iou(*others))

    def test_agrees_with_counted_points(self):
        a, b = box((0.2, 0, 0.1), (2, 1, 1), 0.3), box((0, 0.3, 0), (1.5, 2, 1.2), 1.2)
        points = np.random.default_rng(1).uniform(-2, 2, (200000, 3))
        in_a, in_b = (np.all(np.abs(one.to_own_axes(points)) <= one.half_size_m, axis=1) for one in (a, b))
        self.assertAlmostEqual(iou(a, b), np.sum(in_a & in_b) / np.sum(in_a | in_b), 2)
