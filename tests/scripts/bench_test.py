# SPDX-License-Identifier: Apache-2.0
"""bench.py: what is timed, and that a long recording's yardstick is that of its first frames."""

import argparse
import json
from unittest import mock

import fake_site  # first: it makes the scripts importable
from folder_case import FolderTest

import bench


class FakeMake:
    """Stands for bench.Case.make: leaves what a run of `num_frames` frames leaves; a frame of the
    yardstick takes 30 ms, one of the map 20 ms, the list of frames nothing that counts."""

    def __init__(self, num_recorded):
        self.num_recorded, self.calls = num_recorded, []

    def __call__(self, case, maps, settings, num_frames, *goals):
        self.calls.append((maps, num_frames, len(goals)))
        count = min(num_frames or self.num_recorded, self.num_recorded)
        assert settings == (bench.YARDSTICK if maps == "yardstick" else ""), settings
        site = case.folder / maps / case.site
        for stage in bench.STAGES:
            (site / stage).mkdir(parents=True, exist_ok=True)
            fake_site.write_receipt(site, stage)
            (site / stage / "report.json").write_text(json.dumps({"num_frames": count}))
        (site / "frames" / "shards.txt").write_text("nightmap shards, version 1, 3 names\n0000\n0001\n0002\n")
        if goals[0].endswith("shards.txt"):
            return 1000.0
        return (0.03 if maps == "yardstick" else 0.02) * count


class BenchTest(FolderTest):
    def row(self, num_recorded):
        make = FakeMake(num_recorded)
        with mock.patch.object(bench.Case, "make", lambda case, *rest: make(case, *rest)):
            case = bench.Case("office", argparse.Namespace(build=self.folder))
            return dict(zip(("site", "frames", "total", "rate", "ms", "yardstick", "ratio"), case.row())), make.calls

    def test_every_frame_of_a_short_recording_is_described_for_the_yardstick(self):
        row, calls = self.row(373)
        self.assertEqual(calls, [("yardstick", 1000, 1), ("yardstick", 1000, 3), ("map", 0, 1)])
        self.assertEqual((row["frames"], row["total"], row["yardstick"], row["ratio"]), ("373", "7.5", "11.2", "0.67"))

    def test_a_thousand_frames_stand_for_a_long_one(self):
        row, _ = self.row(8000)
        self.assertEqual((row["frames"], row["ms"], row["yardstick"]), ("8000", "20.0", "240.0"))
