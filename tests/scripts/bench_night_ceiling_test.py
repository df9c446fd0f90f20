# SPDX-License-Identifier: Apache-2.0
"""night/ceiling.py: the closed way of a composed night, its turns, and tracks that go on in the next shard."""

import unittest

from folder_case import FolderTest  # noqa: F401  first: it makes scripts and benchmarks importable

import numpy as np

from night import ceiling, ceiling_source


class WayTest(unittest.TestCase):
    def test_a_closed_way_passes_each_vertex_once_and_has_about_the_size_asked_for(self):
        for num in (1, 4, 7, 30, 113):
            way = ceiling.closed_way(num)
            steps = np.abs(np.diff(way, axis=0, append=way[:1])).sum(axis=1)
            self.assertEqual((set(steps.tolist()), len(set(map(tuple, way.tolist())))), ({1}, len(way)))
            self.assertLessEqual(abs(len(way) - num), max(3, 0.1 * num))

    def test_a_turn_on_the_spot_is_made_of_small_steps_and_no_turn_of_none(self):
        before, after = np.array([1.0, 2.0, 3.0]), np.array([1.0, 2.06, 3.0 + np.pi / 2])
        poses = np.vstack([before, ceiling.on_the_spot(before, after), after])
        turns = ceiling_source.wrapped(np.diff(poses[:, 2]))
        self.assertLess(turns.max(), ceiling.TURN_RAD)
        self.assertAlmostEqual(turns.sum(), np.pi / 2)
        self.assertEqual(len(ceiling.on_the_spot(before, before + [0.06, 0, 0])), 0)

    def test_tracks_at_one_pixel_are_one_and_others_are_not(self):
        pixels = np.array([[10.0, 10.0], [20.0, 10.0], [40.0, 40.0]])
        before = [None, np.array([1, 2, 3]), pixels, pixels]
        after = [None, np.array([7, 8]), None, pixels[[1, 2]] + [[0.2, 0], [5, 0]]]
        self.assertEqual(ceiling_source.same_tracks(before, after), {7: 2})


if __name__ == "__main__":
    unittest.main()
