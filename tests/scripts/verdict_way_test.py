# SPDX-License-Identifier: Apache-2.0
"""Checks of the camera's way: what was measured counts, whatever was guessed or came a millisecond later."""

import json
import tempfile
import unittest
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from unittest import mock

import numpy as np

import fake_site
from fake_site import rotation_about, walk
from folder_case import FolderTest
from nightmap_eval.artifacts import BRIDGED, STARTED
from nightmap_eval.sealed_hdf5 import sealed
from nightmap_eval.trajectory import Trajectory, quaternion
from nightmap_eval.verdict import verdict_way
from nightmap_eval.verdict.verdict import GOOD, LOOK, NOT_KNOWN, REFUSE, worst
from nightmap_site.script_errors import DataError
from nightmap_site.site import Site

TRACKED = np.zeros(fake_site.NUM_FRAMES, int)


def turned(way, angles_deg):
    """The way, each pose of it turned by its angle."""
    return replace(way, quaternions=np.array([quaternion(rotation_about([0, 0, 1], angle_rad) @ rotation)
                                              for angle_rad, rotation in zip(np.radians(angles_deg), way.rotations())]))  # fmt: skip


def straight(times_s, positions_m):
    positions_m = np.column_stack([positions_m, np.zeros((len(times_s), 2))])
    return Trajectory(np.round(np.array(times_s) * 1e9).astype(np.int64), positions_m, np.tile([0.0, 0, 0, 1], (len(times_s), 1)))


def frames_of(way, sequence_idxs=None):
    idxs = np.zeros(len(way), int) if sequence_idxs is None else np.array(sequence_idxs)
    return SimpleNamespace(times_ns=way.times_ns, sequence_idxs=idxs)


class DisagreementTest(unittest.TestCase):
    def test_of_turns_over_a_second(self):
        found = verdict_way.disagreement_deg(turned(walk(), 0.8 * np.arange(fake_site.NUM_FRAMES)), TRACKED, walk())
        self.assertEqual(len(found), fake_site.NUM_FRAMES - 10)
        np.testing.assert_allclose(found, 8, atol=1e-3)

    def test_over_a_guessed_join_nothing_was_measured(self):
        after = np.arange(fake_site.NUM_FRAMES) >= 20
        states = np.where(np.arange(fake_site.NUM_FRAMES) == 20, STARTED, 0)
        odometry = turned(walk(), 60 * after)
        self.assertAlmostEqual(max(verdict_way.disagreement_deg(odometry, TRACKED, walk())), 60, 3)
        found = verdict_way.disagreement_deg(odometry, states, walk())
        self.assertEqual(len(found), 2 * 10)  # ten within each part
        np.testing.assert_allclose(found, 0, atol=1e-3)

    def test_guessed_poses_do_not_count_and_motion_past_them_does(self):
        guessed = np.isin(np.arange(fake_site.NUM_FRAMES), (12, 13))
        found = verdict_way.disagreement_deg(turned(walk(), 60 * guessed), np.where(guessed, BRIDGED, 0), walk())
        np.testing.assert_allclose(found, 0, atol=1e-3)
        self.assertGreater(len(found), fake_site.NUM_FRAMES - 15)


class SpeedTest(unittest.TestCase):
    def test_over_a_second(self):
        way = straight(np.arange(30) / 10, 0.12 * np.arange(30))
        np.testing.assert_allclose(verdict_way.speeds(way, frames_of(way)), np.full(20, 1.2))

    def test_a_copy_a_millisecond_later_shows_no_speed(self):
        times_s = np.sort(np.concatenate([np.arange(30) / 10, np.arange(30) / 10 + 0.001]))
        noise_m = np.tile([0, 0.0075], 30)
        way = straight(times_s, times_s + noise_m)
        self.assertLess(max(verdict_way.speeds(way, frames_of(way))), 1.2)

    def test_a_jump_shows(self):
        for jump_m in (6 * (np.arange(40) >= 20), 6 * (np.arange(40) == 20)):  # to stay, and there and back
            way = straight(np.arange(40) / 10, jump_m)
            self.assertGreaterEqual(np.quantile(verdict_way.speeds(way, frames_of(way)), 0.98), 6)

    def test_within_a_recording(self):
        way = straight(np.arange(40) / 10, 5 * (np.arange(40) % 2))  # two cameras 5 m apart, one frame of each in turn
        np.testing.assert_allclose(verdict_way.speeds(way, frames_of(way, np.arange(40) % 2)), 0)
        self.assertEqual(len(verdict_way.speeds(way, frames_of(way, np.arange(40)))), 0)


class SiteTest(FolderTest):
    def setUp(self):
        site_dir = self.folder / "maps" / "office"
        self.estimate = fake_site.write_site(site_dir)
        self.site = Site(site_dir)
        self.write_json("map_frame")

    def write_json(self, job, **report):
        self.site.path(job, "report").write_text(json.dumps(report))

    def write_odometry(self, way, states):
        fake_site.write_tum(self.site.path("odometry", "trajectory", "0000"), way)
        with sealed(self.site.path("odometry", "odometry", "0000")) as file:
            file["frame_idx"] = np.arange(len(states), dtype=np.int32).reshape(-1, 1)
            file["state"] = np.array(states, dtype=np.uint8).reshape(-1, 1)

    def verdicts(self):
        return {item.name: item.verdict for item in verdict_way.checks(self.site)}

    def test_a_map_that_odometry_contradicts(self):
        for turn_deg, verdict in ((0, GOOD), (0.3, GOOD), (0.8, LOOK), (4, REFUSE)):  # per frame, ten of them a second
            self.write_odometry(turned(walk(), turn_deg * np.arange(fake_site.NUM_FRAMES)), TRACKED)
            self.assertEqual(self.verdicts()["odometry against the map"], verdict, turn_deg)

    def test_a_guess_of_the_odometry_refuses_no_map(self):
        odometry = turned(walk(), 90 * (np.arange(fake_site.NUM_FRAMES) >= 20))
        self.write_odometry(odometry, TRACKED)
        self.assertEqual(self.verdicts()["odometry against the map"], REFUSE)
        self.write_odometry(odometry, np.where(np.arange(fake_site.NUM_FRAMES) == 20, STARTED, 0))
        self.assertEqual(self.verdicts()["odometry against the map"], GOOD)

    def test_states_of_other_frames_are_damage(self):
        self.write_odometry(walk(), TRACKED[:5])
        with self.assertRaisesRegex(DataError, "shard_0000.tum: damaged"):
            self.verdicts()

    def test_the_guessed_pose_of_a_frame_has_no_speed(self):
        self.estimate.positions_m[20] += [0, 0, 9]
        fake_site.write_tum(self.site.path("map_frame", "trajectory"), self.estimate)
        self.write_odometry(walk(), TRACKED)
        self.assertEqual(self.verdicts()["speed"], REFUSE)
        self.write_odometry(walk(), np.where(np.arange(fake_site.NUM_FRAMES) == 20, BRIDGED, 0))
        self.assertEqual(self.verdicts()["speed"], GOOD)
        self.write_odometry(walk(), TRACKED)
        self.write_json("pose_graph", parts=[{"runs": [[0, 19], [21, 39]]}, {"runs": [[20, 20]]}])
        self.assertEqual(self.verdicts()["speed"], GOOD)


class FloorTest(unittest.TestCase):
    def judged(self, **report):
        path = Path(self.enterContext(tempfile.TemporaryDirectory())) / "report.json"
        path.write_text(json.dumps(report))
        with mock.patch.object(verdict_way, "read_tum"), mock.patch.multiple(verdict_way, _speed_checks=lambda *_: [], _odometry_checks=lambda *_: []):
            return {item.name: item for item in verdict_way.checks(SimpleNamespace(path=lambda *_: path))}

    def test_up_is_doubted_where_another_direction_fits_as_well(self):
        seen = {"floor_source": "floor plane", "camera_height_m": 1.0, "below_floor_percent": 0}
        self.assertEqual(worst(self.judged(**seen, up_odds=10.0, up_warning="").values()), GOOD)
        doubtful = self.judged(**seen, up_odds=2.0, up_warning="the top or {the left}")["direction of up"]
        self.assertEqual((doubtful.verdict, doubtful.advice), (LOOK, "the top or {the left}"))
        self.assertNotIn("direction of up", self.judged(**seen, gravity_source="accelerometer"))

    def test_without_a_surface_up_is_not_known(self):
        up = self.judged(floor_source="lowest camera", gravity_source="camera attitude")["direction of up"]
        self.assertEqual((up.verdict, up.value), (LOOK, None))

    def test_checks_of_a_floor_that_was_not_seen_do_not_pass(self):
        unseen = self.judged(floor_source="lowest points", up_odds=99.0, camera_height_m=1.0, floor_warnings=["no floor was seen"])
        self.assertEqual([unseen[name].verdict for name in ("camera height", "below the floor", "warnings of the floor")],
                         [NOT_KNOWN, NOT_KNOWN, LOOK])  # fmt: skip
        self.assertEqual(worst(unseen.values()), LOOK)

    def test_a_given_frame_is_asked_for_its_warnings_alone(self):
        self.assertEqual(set(self.judged(floor_source="given trajectory", floor_warnings=[])), {"warnings of the floor"})

    def test_the_way_of_a_laser_has_no_camera_over_a_floor(self):
        self.assertEqual(self.judged(num_scans=845), {})
