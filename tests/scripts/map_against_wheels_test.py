# SPDX-License-Identifier: Apache-2.0
"""map_against_wheels: which motion of a map agrees with that of wheels, and in which way another one does not."""

import math
import unittest

import numpy as np

import fake_site  # noqa: F401  first: it makes the packages of scripts/ importable
from nightmap_eval.laser.verdict_wheels import agreement_of, windows
from nightmap_eval.planar_poses import compose, inverse, to_rows, to_trajectory

RATE_HZ = 5


def driven(ways, turns):
    """Poses, at RATE_HZ, of a robot whose steps are these complex ways (ahead + 1j * left) and turns."""
    rows = [np.zeros(3)]
    for way, turn in zip(ways, turns, strict=True):
        chord = way * np.exp(0.5j * turn)
        rows.append(compose(rows[-1], [chord.real, chord.imag, turn])[0])
    return to_trajectory(np.arange(len(rows)) * 10**9 // RATE_HZ, np.array(rows))


def steps():
    """A minute of driving at 0.5 m/s: straight, left, straight, right."""
    turns = np.repeat([0.0, 0.1, 0.0, -0.06, 0.0, 0.08], 50)
    return np.full(len(turns), 0.1 + 0j), turns


class AgreementTest(unittest.TestCase):
    def test_the_same_motion_agrees_in_any_frame(self):
        ways, turns = steps()
        way = driven(ways, turns)
        moved = to_trajectory(way.times_ns, compose([3, -2, 1.2], to_rows(way)))
        for estimate in (way, moved):
            found = agreement_of(estimate, way)
            for value in (found.turn, found.way):
                self.assertAlmostEqual(value, 1, places=6)
            self.assertAlmostEqual(found.direction_rad, 0, places=6)
            self.assertAlmostEqual(found.way_spread, 0, places=6)

    def test_angles_of_half_the_size_halve_the_turns(self):
        ways, turns = steps()
        self.assertAlmostEqual(agreement_of(driven(ways, 0.5 * turns), driven(ways, turns)).turn, 0.5, places=6)

    def test_mirrored_beams_turn_the_other_way(self):
        ways, turns = steps()
        found = agreement_of(driven(ways, -turns), driven(ways, turns))
        self.assertAlmostEqual(found.turn, -1, places=6)
        self.assertAlmostEqual(found.direction_rad, 0, places=6)

    def test_a_turned_scanner_shows_its_yaw(self):
        ways, turns = steps()
        for yaw_rad in (math.pi / 2, -2.5, 0.4):
            found = agreement_of(driven(ways * np.exp(-1j * yaw_rad), turns), driven(ways, turns))
            self.assertAlmostEqual(found.direction_rad, -yaw_rad, places=6)
            self.assertAlmostEqual(found.way, 1, places=6)

    def test_a_scale_is_steady_and_a_place_left_behind_is_not(self):
        ways, turns = steps()
        scaled = agreement_of(driven(0.7 * ways, turns), driven(ways, turns))
        self.assertAlmostEqual(scaled.way, 0.7, places=6)
        self.assertAlmostEqual(scaled.way_spread, 0, places=6)
        slow = ways.copy()
        slow[100:200] *= 0.1
        behind = agreement_of(driven(slow, turns), driven(ways, turns))
        self.assertAlmostEqual(behind.way, 0.7, delta=0.02)
        self.assertGreater(behind.way_spread, 0.4)

    def test_a_jump_of_the_odometry_counts_for_nothing(self):
        ways, turns = steps()
        for way_m, turn_rad in ((40, 0), (4, 0), (0.1, 2.5)):  # within the step of a scan
            jumped, turned = ways.copy(), turns.copy()
            jumped[120], turned[120] = way_m, turn_rad
            found = agreement_of(driven(ways, turns), driven(jumped, turned))
            self.assertAlmostEqual(found.way, 1, places=6)
            self.assertAlmostEqual(found.turn, 1, places=6)

    def test_a_driver_that_starts_again_counts_for_nothing(self):
        ways, turns = steps()
        wheels = driven(ways, turns)
        rows = to_rows(wheels)
        rows[150:] = compose(inverse(rows[150]), rows[150:])
        found = agreement_of(wheels, to_trajectory(wheels.times_ns, rows))
        self.assertAlmostEqual(found.way, 1, places=6)
        self.assertAlmostEqual(found.turn, 1, places=6)

    def test_who_does_not_move_tells_nothing(self):
        found = agreement_of(driven(np.zeros(200), np.zeros(200)), driven(np.zeros(200), np.zeros(200)))
        self.assertEqual((found.turn, found.way, found.direction_rad), (None, None, None))

    def test_a_window_does_not_span_missing_scans(self):
        times_ns = np.concatenate([np.arange(20), np.arange(60, 80)]) * 10**9 // RATE_HZ
        first, last = windows(times_ns)
        self.assertTrue(len(first))
        self.assertTrue(((times_ns[last] - times_ns[first]) <= 3 * 10**9).all())
