# SPDX-License-Identifier: Apache-2.0
"""truth_noise.py: noise is found where it was put."""

import unittest

import fake_site  # noqa: F401  first: it makes the benchmarks importable
import numpy as np

import truth_noise


class NoiseTest(unittest.TestCase):
    def setUp(self):
        random = np.random.default_rng(1)
        turns = np.radians(random.uniform(-3, 3, 4000))
        turns[::10] = 0
        lengths = np.where(turns == 0, 0, 0.1)
        heading = np.cumsum(turns)
        way = np.column_stack([np.cumsum(lengths * np.cos(heading)), np.cumsum(lengths * np.sin(heading)), heading])
        self.exact = way
        self.noisy = way + random.normal(0, [0.02, 0.02, np.radians(0.4)], way.shape)
        # Wheels err from step to step: their errors add up.
        self.wheels = way + np.column_stack([np.zeros((4000, 2)), np.cumsum(np.where(turns == 0, 0, random.normal(0, 0.02, 4000)))])

    def test_a_noisy_truth_jumps_at_rest_and_differs_from_the_wheels(self):
        figures = truth_noise.noise(self.exact, self.noisy, self.exact)
        self.assertEqual(figures["num_still"], 399)
        self.assertAlmostEqual(figures["still_truth_cm"], 100 * 0.02 * 2, delta=0.3)
        self.assertAlmostEqual(figures["still_truth_deg"], 0.4 * np.sqrt(2), delta=0.05)
        self.assertEqual((figures["still_map_cm"], figures["still_map_deg"]), (0, 0))

    def test_the_wheels_tell_whose_noise_it_is(self):
        figures = truth_noise.noise(self.wheels, self.noisy, self.exact)
        excess = figures["wheels_truth_deg"] ** 2 - figures["wheels_map_deg"] ** 2
        self.assertAlmostEqual(excess, figures["map_truth_deg"] ** 2, delta=0.1)
        swapped = truth_noise.noise(self.wheels, self.exact, self.noisy)
        self.assertGreater(swapped["wheels_map_deg"], swapped["wheels_truth_deg"])
