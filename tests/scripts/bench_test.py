# SPDX-License-Identifier: Apache-2.0
"""bench.py: what is timed, and that a long recording's yardstick is that of its first frames."""

import argparse
import json
import tempfile
import unittest
from pathlib import Path
from unittest import mock

import fake_site  # first: it makes the scripts importable

import bench


class FakeMake:
    """Stands for bench.Case.make: leaves what a run of `num_frames` frames leaves; a frame of the
    yardstick takes 30 ms, one of the map 20 ms, the list of frames nothing that counts."""

    def __init__(self):
        self.calls = []

    def __call__(self, case, maps, settings, num_frames, *goals):
        self.calls.append((maps, num_frames, len(goals)))
        assert settings == (bench.YARDSTICK if maps == "yardstick" else ""), settings
        site = case.folder / maps / case.site
        for stage in bench.STAGES:
            (site / stage).mkdir(parents=True, exist_ok=True)
            fake_site.write_receipt(site, stage)
            (site / stage / "report.json").write_text(json.dumps({"num_frames": num_frames or 373}))
        (site / "frames" / "shards.txt").write_text("nightmap shards, version 1, 3 names\n0000\n0001\n0002\n")
        if goals[0].endswith("shards.txt"):
            return 1000.0
        return (0.03 if maps == "yardstick" else 0.02) * (num_frames or 373)


class BenchTest(unittest.TestCase):
    def row(self, name):
        make = FakeMake()
        with tempfile.TemporaryDirectory() as folder, mock.patch.object(
            bench.Case, "make", lambda case, *rest: make(case, *rest)
        ):
            case = bench.Case(name, argparse.Namespace(build=Path(folder)))
            return dict(zip(("site", "frames", "total", "rate", "ms", "yardstick", "ratio"), case.row())), make.calls

    def test_every_frame_of_a_short_recording_is_described_for_the_yardstick(self):
        row, calls = self.row("building:800")
        self.assertEqual(calls, [("yardstick", 800, 1), ("yardstick", 800, 3), ("map", 800, 1)])
        self.assertEqual((row["total"], row["yardstick"], row["ratio"]), ("16.0", "24.0", "0.67"))

    def test_a_thousand_frames_stand_for_a_long_one(self):
        row, calls = self.row("building:8000")
        self.assertEqual(calls, [("yardstick", 1000, 1), ("yardstick", 1000, 3), ("map", 8000, 1)])
        self.assertEqual((row["frames"], row["ms"], row["yardstick"]), ("8000", "20.0", "240.0"))

    def test_a_case_that_is_none_is_refused(self):
        for text in ("office:all", "office:0", "office:-5", "office:", ":100"):
            with self.subTest(text), self.assertRaisesRegex(argparse.ArgumentTypeError, "SITE:N"):
                bench.case(text)
        self.assertEqual(bench.case("office:100"), "office:100")

    def test_a_whole_recording(self):
        row, calls = self.row("office")
        self.assertEqual(calls[-1], ("map", 0, 1))
        self.assertEqual((row["frames"], row["yardstick"]), ("373", "11.2"))


if __name__ == "__main__":
    unittest.main()
