# SPDX-License-Identifier: Apache-2.0
"""Sites of other sensors than a camera with depth, and recordings of which a query must not ask."""
import json
import re
import time

import h5py
import matplotlib.image
import numpy as np
from PIL import Image
from workspace import CAMERA, SITE, CopiedSiteTest, SiteTest, Workspace, write_black

LASER_SITE = """\
root = "lab"
[[sensor]]
id = "laser"
kind = "scan"
max_range_m = 30
[[sensor]]
id = "wheels"
kind = "odometry"
[[signal]]
sensor = "laser"
format = "carmen"
file = "log.txt"
message = "FLASER"
[[signal]]
sensor = "wheels"
format = "carmen"
file = "log.txt"
message = "ODOM"
"""
IMU = '\n[[sensor]]\nid = "imu"\nkind = "acceleration"\n[[signal]]\nsensor = "imu"\nformat = "text"\nfile = "imu.txt"\n'


class SignalsTest(SiteTest):
    """Signals without frames."""

    given = ("SITE=lab",)

    def setUp(self):
        self.work = Workspace().removed_after(self)
        (self.work.folder / "configs/sites/lab.toml").write_text(LASER_SITE)
        self.log = self.work.folder / "data/lab/log.txt"
        self.log.parent.mkdir(parents=True)
        lines = [f"ODOM {0.1 * i} 0 0 0 0 0 {i} h {i}\nFLASER 4 1 2 3 31 0 0 0 0 0 0 {i}.5 h {i}\n" for i in range(20)]
        self.log.write_text("".join(lines))

    def test_inspect_tells_what_there_is_and_makes_nothing(self):
        text = self.make("inspect")
        self.assertRegex(text, r"laser +scan +20 +1\.00 .* 4 to 4 beams, 45 to 45 deg apart, 1 to 3 m, 25\.0 % hit nothing")
        self.assertRegex(text, r"wheels +odometry +20 +1\.00 .* x 0 to 1\.9 m")
        self.assertFalse((self.work.folder / "maps/lab").exists())
        self.log.write_text(self.log.read_text() + "ODOM 1 nan 0 0 0 0 30 h 30\n")
        self.assertIn("log.txt:41: 'nan' is not a finite number", self.make("inspect"))

    def test_frames_lists_the_signals_and_a_map_is_refused(self):
        self.make("maps/lab/frames/shards.txt")
        frames = self.work.folder / "maps/lab/frames"
        with h5py.File(frames / "scans.h5") as file:
            self.assertEqual(np.ravel(file["time_ns"])[0], 500_000_000)
            self.assertEqual(np.ravel(file["range_m"])[:4].tolist(), [1, 2, 3, 31])
        report = json.loads((frames / "report.json").read_text())
        self.assertEqual((report["num_frames"], report["num_samples"]), (0, {"laser": 20, "wheels": 20}))
        self.assertEqual(len((frames / "held_out.csv").read_text().splitlines()), 1)
        self.assertIn("a site without frames has none", self.make("map", code=2))

    def test_the_truth_of_the_robot_is_beside_the_frames_while_the_site_has_one(self):
        site, frames = self.work.folder / "configs/sites/lab.toml", self.work.folder / "maps/lab/frames"
        relations = self.work.folder / "data/lab/a.relations"
        relations.write_text("1 2 0.1 0 0 0 0 0\n")
        corrected = '[[sensor]]\nid = "corrected"\nkind = "odometry"\n[[signal]]\nsensor = "corrected"\nformat = "carmen"\n' \
                    'file = "log.txt"\nmessage = "FLASER"\n'
        site.write_text(LASER_SITE + corrected + '[robot_truth]\nodometry = "corrected"\nrelations = "a.relations"\n')
        self.make("maps/lab/frames/shards.txt")
        self.assertEqual((frames / "relations.txt").read_text(), "1 2 0.1 0 0 0 0 0\n")
        self.assertEqual(len((frames / "robot_truth.tum").read_text().splitlines()), 22)
        with h5py.File(frames / "odometry.h5") as file:
            self.assertEqual(file["robot_from_sensor"].shape[0], 1)  # the wheels alone
        relations.write_text("1 3 0.2 0 0 0 0 0\n")
        self.make("maps/lab/frames/shards.txt")
        self.assertEqual((frames / "relations.txt").read_text(), "1 3 0.2 0 0 0 0 0\n")
        relations.unlink()
        self.assertIn("a.relations does not exist", self.make("maps/lab/frames/shards.txt", code=2))
        site.write_text(LASER_SITE)
        self.make("maps/lab/frames/shards.txt")
        self.assertEqual([path.name for path in frames.iterdir() if path.suffix == ".tum"], ["held_out.tum"])
        self.assertFalse((frames / "relations.txt").exists())

    def test_a_log_that_is_damaged_stops_frames(self):
        self.log.write_text(self.log.read_text().replace("FLASER 4", "FLASER 5"))
        text = self.make("maps/lab/frames/shards.txt", code=2)
        self.assertRegex(text, r"log\.txt: holds no sample of scan \(lab/log\.txt:2: 15 words for 5 beams, expected 16")


class AppliedSignalsTest(CopiedSiteTest):
    """Signals and label pictures beside the frames of the small building."""

    made = ("map", "localize")

    def setUp(self):
        super().setUp()
        self.work.as_recorded()
        self.site = self.work.folder / f"configs/sites/{SITE}.toml"

    def reran(self, *arguments):
        before = self.work.runs()
        self.make(*arguments)
        after = self.work.runs()
        return {stage for stage in after if after[stage] != before.get(stage)}

    def rows(self):
        return [line.split(",") for line in self.work.path("frames/shard_0000.csv").read_text().splitlines()]

    def test_an_acceleration_says_where_up_is(self):
        times_s = [int(row[1]) / 1e9 for row in self.rows()[1:]]
        # An accelerometer whose x axis is the camera's -y: up.
        samples = [f"{t:.3f} 9.8 0 0" for t in np.arange(min(times_s) - 1, max(times_s) + 20, 0.05)]
        (self.work.data() / "imu.txt").write_text("\n".join(samples) + "\n")
        turn = "robot_from_sensor = [0, 0, 0, 0, 0, -0.70710678, 0.70710678]\n"
        self.site.write_text(self.site.read_text() + IMU.replace('kind = "acceleration"\n', 'kind = "acceleration"\n' + turn))
        before = json.loads(self.work.path("map_frame/report.json").read_text())
        self.assertNotEqual(before["gravity_source"], "accelerometer")
        reran = self.reran("map")
        self.assertTrue({"frames", "map_frame"} <= reran and not reran & {"features", "odometry", "pose_graph"}, reran)
        report = json.loads(self.work.path("map_frame/report.json").read_text())
        self.assertEqual(report["gravity_source"], "accelerometer")
        self.assertLess(abs(report["camera_height_m"] - before["camera_height_m"]), 0.02)

    def test_an_acceleration_without_gravity_is_named_with_the_remedy(self):
        times_s = [int(row[1]) / 1e9 for row in self.rows()[1:]]
        imu = self.work.data() / "imu.txt"
        text = self.site.read_text()
        self.site.write_text(text + IMU)
        for offset_s, value, reason in ((0, 0.1, "not gravity's 9.8"), (60, 9.8, "no sample within 0.1 s of a keyframe")):
            with self.subTest(reason):
                samples = [f"{t + offset_s:.3f} {value} 0 0" for t in np.arange(min(times_s), max(times_s) + 20, 0.05)]
                imu.write_text("\n".join(samples) + "\n")
                said = self.work.output("map", code=2)
                error = next(line for line in said.splitlines() if " error " in line)
                self.assertIn(f"maps/{SITE}/frames/acceleration.h5: ", error)
                self.assertIn(reason, error)
                self.assertIn("[[signal]]", error)
                self.assertNotIn("delete", error)
        self.site.write_text(text)
        self.make("map")

    def test_labels_reach_the_lists_of_the_frames_and_tiles_that_have_them(self):
        name = self.rows()[5][4]
        labels = self.work.data() / "made_elsewhere"
        labels.mkdir()
        matplotlib.image.imsave(labels / "x.png", np.zeros((1, 1)))  # of no frame
        stem = name.split("/")[-1].rsplit(".", 1)[0]
        Image.fromarray(np.full((CAMERA["height"], CAMERA["width"]), 15, np.uint8)).save(labels / f"{stem}.png")
        other = self.work.path("frames/shard_0001.csv").read_bytes()
        self.site.write_text(self.site.read_text().replace("[[sequence]]\n", '[[sequence]]\nlabel_folder = "made_elsewhere"\n'))
        self.make("map")
        rows = self.rows()
        self.assertEqual(rows[0][8:], ["label_path", "label_hash"])
        self.assertEqual([i for i, row in enumerate(rows) if row[8]], [0, 5])
        self.assertEqual(self.work.path("frames/shard_0001.csv").read_bytes(), other)
        tiles = "".join(path.read_text() for path in self.work.path("tiles").glob("tile_*.json"))
        self.assertEqual('"label"' in tiles, re.search(rf'"frame_idx":{rows[5][0]},', tiles) is not None)

    def test_asking_for_a_picture_looks_at_no_recording(self):
        write_black(self.work.folder / "photo.png", CAMERA["width"], CAMERA["height"])
        mapped = self.work.folder / "data" / self.rows()[3][4]
        mapped.write_bytes(mapped.read_bytes() + b"more")
        state = self.work.path("config/recordings").read_bytes()
        asked = ("localize", "QUERY=photo.png", "FOV_DEG=60")
        self.assertEqual(self.reran(*asked), {"queries", "localize"})
        self.assertEqual(self.work.path("config/recordings").read_bytes(), state)
        self.assertIn("frames", self.reran("map"))

    def test_only_new_and_changed_files_are_hashed(self):
        log = self.work.path("logs/frames.log")
        mapped = self.work.folder / "data" / self.rows()[3][4]
        time.sleep(2.1)  # the workspace's copies are new files, and settled after two seconds
        for ratio in (0.19, 0.18):
            self.make("map", f"SET=frames.max_failed_ratio={ratio}")
        num_files = int(re.search(r"(\d+) files, 0 of them new or changed", log.read_text())[1])
        self.assertGreater(num_files, 100)
        mapped.write_bytes(mapped.read_bytes() + b"more")
        self.make("map")
        self.assertIn(f"{num_files} files, 1 of them new or changed", log.read_text())
        hashes = self.work.hashes()
        self.work.path("frames/hashes.csv").write_bytes(b"\xff damaged\n")
        self.make("map", "SET=frames.max_failed_ratio=0.19")
        self.assertIn(f"{num_files} files, {num_files} of them", log.read_text())
        self.make("map")
        self.assertEqual(self.work.hashes(), hashes)
