# SPDX-License-Identifier: Apache-2.0
"""Checks of the times and the order of frames."""

import unittest
from types import SimpleNamespace

import numpy as np

import fake_site  # noqa: F401 (makes nightmap_eval importable)
from nightmap_eval.verdict import verdict_recording
from nightmap_eval.verdict.verdict import LOOK


def frames_named(names, times_s, sequences=None):
    return SimpleNamespace(rows=[{"color_path": name} for name in names], frame_idxs=np.arange(len(names)), times_ns=np.array([round(t * 1e9) for t in times_s]),
                           sequence_idxs=np.array(sequences or [0] * len(names)))  # fmt: skip


class OrderTest(unittest.TestCase):
    def test_names_sorted_as_text(self):
        names = [f"rgb/{name}.png" for name in sorted(map(str, range(1, 121)))]
        self.assertGreater(verdict_recording.names_against_times(frames_named(names, range(120))), 0.05)

    def test_the_pictures_say_whether_names_or_times_are_right(self):
        frames = frames_named([f"rgb/{name}.png" for name in sorted(map(str, range(1, 121)))], range(120))
        for tracked, advice in ((0.9, "the times are right: leave them"), (0.05, "the times are wrong"), (np.nan, "look at these pictures")):
            numbers = [int(row["color_path"][4:-4]) for row in frames.rows]
            tracked_share = np.where(np.diff(numbers, prepend=0) < 0, tracked, 0.5)
            survey = SimpleNamespace(frame_idxs=np.arange(120), column={"tracked_share": tracked_share}.get, share=lambda *_: 0.0)
            found = {item.name: item for item in verdict_recording.order_checks(survey, frames)}["names against times"]
            self.assertEqual(found.verdict, LOOK)
            self.assertIn(advice, found.advice)

    def test_names_that_count_with_time(self):
        for names in ([f"rgb/{i}.png" for i in range(120)], [f"rgb/1305031.{i:06d}.jpg" for i in range(120)]):
            self.assertEqual(verdict_recording.names_against_times(frames_named(names, range(120))), 0)

    def test_names_that_do_not_count(self):
        for names in (["rgb/left.png"] * 10, [f"rgb/{'ab'[i % 2]}.png" for i in range(10)], [f"rgb/{i % 3}.png" for i in range(10)]):
            self.assertEqual(verdict_recording.names_against_times(frames_named(names, range(10))), 0)

    def test_another_recording_may_count_from_zero_again(self):
        names = [f"{folder}/{i}.png" for folder in "ab" for i in range(10)]
        self.assertEqual(verdict_recording.names_against_times(frames_named(names, range(20), [0] * 10 + [1] * 10)), 0)

    def test_gaps_are_long_in_seconds_and_in_intervals(self):
        times_s = np.concatenate([np.arange(0, 5, 0.1), np.arange(7, 9, 0.1)])
        self.assertEqual([round(gap, 2) for gap in verdict_recording.gaps_s(frames_named(["a"] * len(times_s), times_s))], [2.1])
        sparse = np.concatenate([np.arange(0, 40, 2), np.arange(44, 60, 2)])  # two intervals are no gap
        self.assertEqual(verdict_recording.gaps_s(frames_named(["a"] * len(sparse), sparse)), [])
        twice = np.sort(np.concatenate([np.arange(0, 20, 0.5), np.arange(0, 20, 0.5) + 0.001]))  # no gap of 0.499 s
        self.assertEqual(verdict_recording.gaps_s(frames_named(["a"] * len(twice), twice)), [])
        between = frames_named(["a"] * 4, [0, 0.1, 60, 60.1], [0, 0, 1, 1])
        self.assertEqual(verdict_recording.gaps_s(between), [])

    def test_a_copy_comes_right_after_its_frame(self):
        times_s, sequences = [0, 0.001, 0.1, 0.101, 0.2, 0.3, 0.301], [0, 0, 0, 0, 0, 0, 1]
        found = verdict_recording.is_right_after(frames_named(["a"] * 7, times_s, sequences))
        self.assertEqual(found.tolist(), [False, True, False, True, False, False, False])
        self.assertEqual(verdict_recording.is_right_after(frames_named(["a"], [0])).tolist(), [False])
