#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Broken input: what is skipped and counted, what stops a stage, and with which exit code."""
import csv
import json
import shutil
import unittest

import h5py
import numpy as np

from workspace import CAMERA, GOALS, SITE, Workspace, write_black, write_gray16

FRAMES = f"maps/{SITE}/frames"
CONFIG = f"maps/{SITE}/config"


class InputsTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.base = Workspace()
        result = cls.base.make(*GOALS)
        if result.returncode != 0:
            raise AssertionError(f"the chain failed:\n{result.stdout}")

    @classmethod
    def tearDownClass(cls):
        cls.base.remove()

    def setUp(self):
        self.work = self.base.copy()
        self.addCleanup(self.work.remove)

    def run_frames(self):
        return self.work.run("frames", "--config", f"{CONFIG}/frames.toml", "--in",
                             f"site={CONFIG}/site/{SITE}.toml", "--in", "data=data", "--out",
                             f"shards_mk={FRAMES}/shards.mk", "--out", f"report={FRAMES}/report.json")

    def run_cloud(self):
        return self.work.run("point_cloud", *(item for shard in sorted(self.work.path("frames").glob("shard_*.csv"))
                                              for item in ("--in", f"frames={shard}")),
                             "--in", f"cameras={FRAMES}/cameras.json", "--in", "data=data", "--in",
                             f"keyframes=maps/{SITE}/pose_graph/keyframes.tum", "--out", "cloud=cloud.ply")

    def run_vocabulary(self):
        return self.work.run("vocabulary", "--in", f"features=maps/{SITE}/features/shard_0000.h5",
                             "--out", "vocabulary=vocabulary.h5")

    def frames_of(self, name):
        with open(self.work.path(f"frames/{name}"), encoding="utf-8", newline="") as file:
            return list(csv.DictReader(file))

    def picture(self, index, column):
        return self.work.folder / "data" / self.frames_of("shard_0000.csv")[index][column]

    def check(self, result, code, message):
        self.assertEqual(result.returncode, code, result.stdout)
        self.assertIn(message, result.stdout)

    def check_skipped(self, path):
        self.check(self.run_frames(), 0, path.name)
        report = json.loads(self.work.path("frames/report.json").read_text())
        self.assertEqual(report["num_skipped"], 1)
        listed = [row["color_path"] for shard in sorted(self.work.path("frames").glob("shard_*.csv"))
                  for row in self.frames_of(shard.name)]
        self.assertFalse(any(path.name in name for name in listed) and "color" in str(path))

    def test_truncated_color_picture_is_skipped_and_counted(self):
        path = self.picture(3, "color_path")
        path.write_bytes(path.read_bytes()[:1000])
        self.check_skipped(path)

    def test_depth_of_another_size_is_skipped_and_counted(self):
        path = self.picture(3, "depth_path")
        write_gray16(path, 64, 48, 1000)
        self.check_skipped(path)

    def test_missing_picture_is_skipped_and_counted(self):
        path = self.picture(3, "color_path")
        path.unlink()
        self.check_skipped(path)

    def test_most_pictures_broken_stops_frames(self):
        for row in self.frames_of("shard_0000.csv") + self.frames_of("shard_0001.csv"):
            (self.work.folder / "data" / row["color_path"]).write_bytes(b"not a picture")
        self.check(self.run_frames(), 1, "max_failed_ratio")

    def test_missing_folder_stops_frames(self):
        shutil.rmtree(self.work.data())
        result = self.run_frames()
        self.assertEqual(result.returncode, 1, result.stdout)
        self.assertIn(SITE, result.stdout)

    def test_empty_folder_stops_frames(self):
        shutil.rmtree(self.work.data())
        self.work.data().mkdir()
        self.check(self.run_frames(), 1, "missing")

    def test_depth_of_nothing_but_zeros_stops_the_chain(self):
        for name in ("shard_*.csv",):
            for shard in sorted(self.work.path("frames").glob(name)):
                for row in self.frames_of(shard.name):
                    write_gray16(self.work.folder / "data" / row["depth_path"],
                                 CAMERA["width"], CAMERA["height"])
        self.work.path("frames/shards.mk").unlink()
        result = self.work.make("map")
        self.assertEqual(result.returncode, 2)
        self.assertIn("Error 1", result.stdout)
        self.assertIn("depth", result.stdout)

    def test_nan_in_an_artifact(self):
        path = self.work.path("pose_graph/keyframes.tum")
        lines = path.read_text().splitlines()
        words = lines[-1].split()
        path.write_text("\n".join(lines[:-1] + [" ".join([words[0], "nan", *words[2:]])]) + "\n")
        self.check(self.run_cloud(), 1, "keyframes.tum")

    def test_artifact_of_a_newer_version(self):
        path = self.work.path("features/shard_0000.h5")
        with h5py.File(path, "r+") as file:
            name = next(key for key in file.attrs if "version" in key)
            file.attrs.modify(name, np.int32(1000))
        self.check(self.run_vocabulary(), 1, "shard_0000.h5")

    def test_truncated_artifact(self):
        path = self.work.path("features/shard_0000.h5")
        path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
        self.check(self.run_vocabulary(), 1, "shard_0000.h5")

    def test_no_loop_is_no_failure_and_is_reported(self):
        result = self.work.make("map", "SET=matches.loop_min_inliers=1000")
        self.assertEqual(result.returncode, 0, result.stdout)
        report = json.loads(self.work.path("matches/report_loops.json").read_text())
        self.assertEqual(report["num_accepted"], 0)

    def test_query_without_features_is_a_row_with_a_reason(self):
        query = self.frames_of("queries.csv")[0]
        write_black(self.work.folder / "data" / query["color_path"], CAMERA["width"], CAMERA["height"])
        self.work.path("frames/shards.mk").unlink()
        result = self.work.make("localize")
        self.assertEqual(result.returncode, 0, result.stdout)
        with open(self.work.path("localize/queries.csv"), encoding="utf-8", newline="") as file:
            rows = {row["color_path"]: row for row in csv.DictReader(file)}
        row = rows[query["color_path"]]
        self.assertEqual((row["status"], row["reason"], row["tx_m"]), ("failed", "no_features", ""))


if __name__ == "__main__":
    unittest.main()
