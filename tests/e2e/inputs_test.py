# SPDX-License-Identifier: Apache-2.0
"""Broken input: what is skipped and counted, what stops a stage, and with which exit code."""
import json
import os
import resource
import shutil

import numpy as np
from PIL import Image

from workspace import BUILD, CAMERA, GOALS, SITE, CopiedSiteTest, as_its_job_wrote, read_csv, write_black, write_gray16

from nightmap_eval.sealed_hdf5 import sealed

FRAMES = f"maps/{SITE}/frames"
CONFIG = f"maps/{SITE}/config"
LITTLE_MEMORY_BYTES = 150 << 20


class InputsTest(CopiedSiteTest):
    made = GOALS

    def setUp(self):
        super().setUp()
        self.work.as_recorded()

    def run_frames(self, program="frames"):
        return self.work.run(program, "--config", f"{CONFIG}/frames.toml", "--in",
                             f"site={CONFIG}/site/{SITE}.toml", "--in", "data=data", "--out",
                             f"shards={FRAMES}/shards.txt", "--out", f"report={FRAMES}/report.json")

    def run_tiles(self):
        return self.work.run("tiles", *(item for shard in sorted(self.work.path("frames").glob("shard_*.csv"))
                                        for item in ("--in", f"frames={shard}")),
                             "--in", f"cameras={FRAMES}/cameras.json",
                             "--in", f"keyframes=maps/{SITE}/map_frame/keyframes.tum", "--out", "tiles=tiles.txt")

    def run_cloud(self, *outputs):
        return self.work.run("point_cloud", "--in", f"tile=maps/{SITE}/tiles/tile_0_0.json", "--in",
                             f"cameras=maps/{SITE}/tiles/cameras.json", "--in", "data=data", "--out",
                             "tile_cloud=cloud.ply", "--out", "places=places.csv", *outputs)

    def run_vocabulary(self):
        return self.work.run("vocabulary", "--in", f"features=maps/{SITE}/features/shard_0000.h5",
                             "--out", "vocabulary=vocabulary.h5")

    def frames_of(self, name):
        return read_csv(self.work.path(f"frames/{name}"))

    def picture(self, index, column):
        return self.work.folder / "data" / self.frames_of("shard_0000.csv")[index][column]

    def check(self, result, code, *words):
        """The exit code, and one line of the log that names the file and says what to do."""
        self.assertEqual(result.returncode, code, result.stdout)
        lines = [line for line in result.stdout.splitlines() if all(word in line for word in words)]
        self.assertTrue(lines, f"no line with all of {words} in:\n{result.stdout}")

    def check_skipped(self, path, *words):
        """frames leaves the frame out, says so, and counts it."""
        name = str(path.relative_to(self.work.folder / "data"))
        self.check(self.run_frames(), 0, "skipped", name, *words)
        report = json.loads(self.work.path("frames/report.json").read_text())
        self.assertEqual((report["num_skipped"], report["num_frames_unusable"]), (1, 1))
        for shard in self.work.path("frames").glob("shard_*.csv"):
            for row in self.frames_of(shard.name):
                self.assertNotIn(name, (row["color_path"], row["depth_path"]))

    def test_truncated_color_picture_is_skipped_and_counted(self):
        path = self.picture(3, "color_path")
        path.write_bytes(path.read_bytes()[:1000])
        self.check_skipped(path, "truncated", "copy it again")

    def test_truncated_depth_png_is_skipped_and_counted(self):
        path = self.picture(3, "depth_path")
        path.write_bytes(path.read_bytes()[:1000])
        self.check_skipped(path, "truncated", "copy it again")

    def test_depth_of_another_size_is_skipped_and_counted(self):
        path = self.picture(3, "depth_path")
        write_gray16(path, 64, 48, 1000)
        self.check_skipped(path, "64 x 48", "320 x 240")

    def test_missing_picture_is_skipped_and_counted(self):
        path = self.picture(3, "color_path")
        path.unlink()
        self.check_skipped(path, "no such image file")

    def test_a_picture_of_another_format_is_read_by_the_module(self):
        path = self.picture(3, "color_path")
        Image.open(path).save(path, "TIFF")
        self.check(self.run_frames(), 0)
        self.assertEqual(json.loads(self.work.path("frames/report.json").read_text())["num_skipped"], 0)
        soft, hard = resource.getrlimit(resource.RLIMIT_AS)
        resource.setrlimit(resource.RLIMIT_AS, (LITTLE_MEMORY_BYTES, hard))  # too little for the module's libraries
        try:
            self.check(self.run_frames(), 1, "out of memory at", "nightmap_media.so", "raise the limit of memory")
        finally:
            resource.setrlimit(resource.RLIMIT_AS, (soft, hard))
        alone = shutil.copy(BUILD / "bin/frames", self.work.folder)
        self.check(self.run_frames(alone), 2, "nightmap_media.so", "build the programs again")

    def test_most_pictures_broken_stops_frames(self):
        for row in self.frames_of("shard_0000.csv") + self.frames_of("shard_0001.csv"):
            (self.work.folder / "data" / row["color_path"]).write_bytes(b"not a picture")
        self.check(self.run_frames(), 1, "max_failed_ratio", "repair them")

    def test_a_link_out_of_the_recording_is_refused_unless_the_site_allows_it(self):
        outside = self.work.folder / "outside"
        (self.work.data() / "rgb").rename(outside)
        (self.work.data() / "rgb").symlink_to(outside)
        site = self.work.folder / f"configs/sites/{SITE}.toml"
        result = self.work.make("map")
        self.check(result, 2, f"data/{SITE}/rgb: is a link to", 'allow_outside = ["rgb"]', f"{site.name}:")
        self.assertNotIn(f"maps/{SITE}/config/site", result.stdout)
        site.write_text(site.read_text().replace("[[sequence]]", '[[sequence]]\nallow_outside = ["rgb"]'))
        self.work.output("map")

    def test_mistakes_in_the_site_are_named_in_the_file_to_edit(self):
        site = self.work.folder / f"configs/sites/{SITE}.toml"
        lines = site.read_text().splitlines()
        line = next(i for i, text in enumerate(lines) if text.startswith("fx ="))
        site.write_text("\n".join(lines[:line] + ["fx = -1"] + lines[line + 1:]) + "\n")
        result = self.work.make("map")
        self.check(result, 2, f"configs/sites/{SITE}.toml:{line + 1}: fx = -1")
        site.write_text("\n".join(lines) + "\n")
        write_black(self.work.folder / "a.png", 32, 24)
        result = self.work.make("localize", "QUERY=a.png", "CAMERA=none")
        self.check(result, 2, "QUERY of make: no [[camera]] has id")

    def test_a_truth_by_another_clock_is_an_error_of_evaluate(self):
        path = self.work.data() / "groundtruth.txt"
        lines = [line.split() for line in path.read_text().splitlines() if line and not line.startswith("#")]
        path.write_text("".join(" ".join([str(float(line[0]) + 7200), *line[1:]]) + "\n" for line in lines))
        self.check(self.work.make("check"), 0, "look at this: ground truth apart from the frames", "correct its times")
        result = self.work.make("evaluate")
        self.check(result, 2, "groundtruth.txt: gives no frame a pose", " s from a frame's", "correct its times to the clock of the frames")
        self.assertNotIn("no ground truth", result.stdout)

    def test_one_picture_in_two_lines_of_a_list(self):
        rgb = self.work.data() / "rgb.txt"
        lines = rgb.read_text().splitlines()
        first, second = [i for i, line in enumerate(lines) if not line.startswith("#")][:2]
        lines[second] = f"{lines[second].split()[0]} {lines[first].split()[1]}"
        rgb.write_text("\n".join(lines) + "\n")
        self.check(self.run_frames(), 1, f"rgb.txt:{second + 1}:", "is listed at", "remove a line")

    def test_list_with_nul_bytes_after_a_power_cut(self):
        rgb = self.work.data() / "rgb.txt"
        lines = rgb.read_text().count("\n")
        rgb.write_bytes(rgb.read_bytes()[:-5] + bytes(5))
        self.check(self.run_frames(), 1, f"rgb.txt:{lines}: holds 5 NUL bytes", "copy the file again")

    def test_a_small_file_that_unpacks_to_gigabytes_is_unreadable(self):
        folder = self.work.folder / "photos"
        folder.mkdir()
        write_gray16(folder / "bomb.png", 30000, 5000)
        write_black(folder / "black.png", 320, 240)
        (folder / os.fsdecode(b"\xff.png")).write_bytes((folder / "black.png").read_bytes())
        result = self.work.make("localize", "QUERY=photos", "FOV_DEG=60")
        self.check(result, 0, "photos/bomb.png: 30000 x 5000 pixels are more than max_picture_mpx")
        rows = {name: row for name, row in self.located().items() if "photos" in name}
        self.assertEqual({name.rpartition("/")[2]: row["status"] for name, row in rows.items()},
                         {"bomb.png": "unreadable", "black.png": "no_features", "\\xff.png": "unreadable"})

    def test_missing_folder(self):
        shutil.rmtree(self.work.data())
        self.check(self.run_frames(), 1, f"data/{SITE}", "no such folder", "correct `root` or `folder`")
        # As a recording that synthesize does not make, make itself refuses it.
        self.check(self.work.make("map"), 2, f"data/{SITE}", "does not exist", "datasets.md")

    def test_empty_folder(self):
        shutil.rmtree(self.work.data())
        self.work.data().mkdir()
        self.check(self.run_frames(), 1, "rgb.txt", "missing", "correct `folder`")

    def test_depth_of_nothing_but_zeros_stops_the_chain(self):
        for shard in sorted(self.work.path("frames").glob("shard_*.csv")):
            for row in self.frames_of(shard.name):
                write_gray16(self.work.folder / "data" / row["depth_path"],
                             CAMERA["width"], CAMERA["height"])
        result = self.work.make("map")
        self.check(result, 2, f"{SITE}/depth/", "no depth", "depth_units_per_m")
        self.assertIn("Error 1", result.stdout)

    def test_a_picture_replaced_in_place_is_noticed_and_a_touch_reruns_frames_alone(self):
        path = self.picture(3, "color_path")
        self.work.output(*GOALS)
        before = self.work.runs()
        for change in (path.touch, lambda: path.chmod(0o600), lambda: os.link(path, path.with_name("linked"))):
            change()
            self.assertEqual(self.work.make("-q", *GOALS).returncode, 1)
            self.work.make(*GOALS)
            after = self.work.runs()
            self.assertEqual({stage for stage in after if after[stage] != before[stage]}, {"frames"})
            before = after
        write_black(path, CAMERA["width"], CAMERA["height"])
        self.work.make(*GOALS)
        self.assertNotEqual(self.work.runs()["features"], after["features"])

    def test_a_picture_replaced_by_one_of_the_same_size_and_time_is_noticed(self):
        path = self.picture(3, "color_path")
        self.work.make(*GOALS)
        before, status, data = self.work.runs(), path.stat(), bytearray(path.read_bytes())
        data[len(data) // 2] ^= 1
        path.write_bytes(data)
        os.utime(path, ns=(status.st_atime_ns, status.st_mtime_ns))
        self.assertEqual(self.work.make("-q", "map").returncode, 1)
        self.assertIn("frames: ", self.work.make("why").stdout)
        self.work.make("map")
        after = self.work.runs()
        self.assertTrue(after["frames"] != before["frames"] and after["features"] != before["features"])

    def test_nan_in_an_artifact(self):
        path = self.work.path("map_frame/keyframes.tum")
        lines = path.read_text().splitlines()
        words = lines[-1].split()
        path.write_text("\n".join(lines[:-1] + [" ".join([words[0], "nan", *words[2:]])]) + "\n")
        self.check(self.run_tiles(), 1, "keyframes.tum:", "'nan' is not a finite number", "delete the file")

    def test_list_of_a_tile_that_is_cut_off(self):
        path = self.work.path("tiles/tile_0_0.json")
        path.write_text(path.read_text()[:500])
        self.check(self.run_cloud(), 1, "tile_0_0.json", "parse error", "run make")

    def test_octree_of_a_tile_that_is_cut_off(self):
        path = self.work.path("octree/tile_0_0.ot")
        path.write_bytes(path.read_bytes()[:500])
        join = ("--in", f"tile=maps/{SITE}/tiles/tile_0_0.json", "--in",
                f"tile_report=maps/{SITE}/octree/report_0_0.json", "--out", "ot=joined.ot", "--out", "bt=joined.bt")
        result = self.work.run("join_octrees", *join, "--in", f"tile_ot={path}")
        self.check(result, 1, "tile_0_0.ot", "damaged", "make the octree again")
        self.assertFalse(list(self.work.folder.glob("joined.*")))
        self.check(self.work.run("join_octrees", *join), 2, "--in tile_ot=PATH is missing")

    def test_one_unreadable_keyframe_is_skipped_and_many_stop_the_map(self):
        tile = self.work.path("tiles/tile_0_0.json")
        pictures = [keyframe["channels"]["depth"]["path"] for keyframe in json.loads(tile.read_text())["keyframes"]]
        join = ("--in", f"tile={tile}", "--in", "tile_cloud=cloud.ply", "--in", "tile_report=report.json")
        for count, code in ((1, 0), (len(pictures) // 2, 1)):
            for name in pictures[:count]:
                (self.work.folder / "data" / name).write_bytes(b"not a picture")
            self.check(self.run_cloud("--out", "report=report.json"), 0, "skipped", pictures[0])
            result = self.work.run("join_clouds", *join, "--out", "cloud=joined.ply")
            self.assertEqual(result.returncode, code, result.stdout)
        self.check(result, 1, f"{count} of {len(pictures)}", "max_failed_ratio", "repair them")

    def test_report_of_a_tile_that_is_cut_off_or_lacks_a_count(self):
        report = self.work.path("point_cloud/report_0_0.json")
        whole = report.read_text()
        join = ("--in", f"tile=maps/{SITE}/tiles/tile_0_0.json", "--in",
                f"tile_cloud=maps/{SITE}/point_cloud/tile_0_0.ply", "--in", f"tile_report={report}")
        for text, told in ((whole[:200], "parse error"), (whole.replace("num_held_out_rays\"", "rays\""),
                                                          "num_held_out_rays")):
            self.assertNotEqual(text, whole)
            report.write_text(text)
            result = self.work.run("join_clouds", *join, "--out", "cloud=joined.ply")
            self.check(result, 1, "report_0_0.json", told, "run make")
            self.assertFalse((self.work.folder / "joined.ply").exists())

    def test_nan_in_an_array(self):
        path = self.work.path("odometry/shard_0000.h5")
        with sealed(path, "r+") as file:
            name = next(key for key in file if file[key].dtype == np.float64)
            file[name][0, 0] = np.nan
        as_its_job_wrote(path)
        self.work.path("odometry/receipt_0000.json").touch()  # as if the run had ended so
        self.work.path("pose_graph/receipt.json").unlink()
        result = self.work.make("map")
        self.check(result, 2, "odometry/shard_0000.h5", name, "delete the file and run make")
        self.assertIn("Error 1", result.stdout)

    def test_artifact_of_a_newer_version(self):
        path = self.work.path("features/shard_0000.h5")
        with sealed(path, "r+") as file:
            name = next(key for key in file.attrs if "version" in key)
            file.attrs.modify(name, np.int32(1000))
        self.check(self.run_vocabulary(), 1, "shard_0000.h5", "version", "1000", "update nightmap")

    def test_truncated_artifact(self):
        path = self.work.path("features/shard_0000.h5")
        path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
        self.check(self.run_vocabulary(), 1, "shard_0000.h5", "truncated", "delete it and run make")

    def test_no_loop_is_no_failure_and_is_reported(self):
        self.work.output("map", "SET=loops.min_inliers=1000")
        report = json.loads(self.work.path("loops/report.json").read_text())
        self.assertEqual(report["num_accepted"], 0)
        report = json.loads(self.work.path("pose_graph/report.json").read_text())
        self.assertIn("no loop found", report["loops"])

    def located(self):
        return {row["color_path"]: row for row in read_csv(self.work.path("localize/queries.csv"))}

    def test_a_query_without_features_or_unreadable_is_a_row_with_a_reason(self):
        queries = self.frames_of("held_out.csv")
        black, broken = (self.work.folder / "data" / query["color_path"] for query in queries[:2])
        write_black(black, CAMERA["width"], CAMERA["height"])
        broken.write_bytes(broken.read_bytes()[:1000])
        self.work.output("localize")
        rows = self.located()
        self.assertEqual(len(rows), len(queries))
        verdicts = (("no_features", "no_features"), ("unreadable", "unreadable_image"))
        for query, verdict in zip(queries, verdicts):
            row = rows[query["color_path"]]
            self.assertEqual((row["status"], row["reason"]), verdict)
            self.assertEqual(row["tx_m"], "")
