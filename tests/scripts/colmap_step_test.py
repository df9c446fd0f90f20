# SPDX-License-Identifier: Apache-2.0
"""colmap_step.py with a stand-in for COLMAP: what it is asked, and what becomes of its failures."""

import json
import os
import subprocess
import sys
import time
from pathlib import Path
from unittest import mock

import fake_colmap
import fake_site
from folder_case import SiteFolderTest
from nightmap_eval.colmap.colmap_files import read_cameras
from nightmap_eval.colmap.colmap_run import Step

RETRIEVED = """
if [ "$1" = vocab_tree_retriever ]; then
  echo "Querying for image queries/0.png [1/2] in 0.1s"
  echo "  image_id=4, image_name=rgb/1.png, score=0.4"
  echo "  image_id=1, image_name=rgb/0.png, score=0.3"
  echo "Querying for image queries/1.png [2/2] in 0.1s"
fi
"""
STAND_IN = """#!/bin/sh
[ "$1" = help ] && { echo "COLMAP 3.8 -- of tests (Commit)"; exit 0; }
echo "$@" >> CALLS
echo "Processed file [1/2]"
COMMANDS
"""


class ColmapStepTest(SiteFolderTest):
    def setUp(self):
        self.colmap = self.site_dir / "evaluate_colmap"
        fake_site.write_site(self.site_dir)
        camera = {"fx": 500, "fy": 501, "cx": 319.5, "cy": 239.5} | dict.fromkeys(("k1", "k2", "p1", "p2", "k3"), 0)
        (self.site_dir / "queries").mkdir()
        for name in ("frames/cameras.json", "queries/query_cameras.json"):
            (self.site_dir / name).write_text(json.dumps({"cameras": [{"color": camera}]}))
        calibrated = {"cameras": [{"color": camera | {"fx": 490, "fy": 491}}]}
        (self.site_dir / "adjust" / "cameras.json").write_text(json.dumps(calibrated))
        header = "frame_idx,time_ns,camera_idx,sequence_idx,color_path,color_hash,depth_path,depth_hash\n"
        rows = "0,5,0,0,queries/0.png,00,,\n1,6,0,0,queries/1.png,00,,\n"
        (self.site_dir / "queries" / "queries.csv").write_text(header + rows)

    def stand_in(self, commands):
        """The PATH with a COLMAP that runs these commands."""
        bin_dir = self.folder / "bin"
        bin_dir.mkdir(exist_ok=True)
        text = STAND_IN.replace("CALLS", str(self.folder / "calls")).replace("COMMANDS", commands)
        (bin_dir / "colmap").write_text(text)
        (bin_dir / "colmap").chmod(0o755)
        return f"{bin_dir}:{os.environ['PATH']}"

    def arguments(self, step):
        return (step, "--site-dir", self.site_dir, "--data", self.folder / "data", "--threads", "2")

    def run_step(self, step, commands="exit 0", path=None):
        with mock.patch.dict(os.environ, {"PATH": path or self.stand_in(commands)}):
            return fake_site.run("colmap_step.py", *self.arguments(step))

    def receipt(self, step):
        return json.loads((self.colmap / step / "receipt.json").read_text())

    def calls(self):
        return (self.folder / "calls").read_text()

    def test_features_are_asked_with_known_intrinsics_on_the_cpu(self):
        self.assertEqual(self.run_step("features").returncode, 0)
        self.assertIn("--ImageReader.camera_model PINHOLE", self.calls())
        self.assertIn("--ImageReader.camera_params 500.0,501.0,320.0,240.0", self.calls())
        self.assertIn("--SiftExtraction.use_gpu 0", self.calls())
        names = (self.colmap / "features" / "images_0.txt").read_text().split()
        self.assertEqual(len(names), fake_site.NUM_FRAMES)
        receipt = self.receipt("features")
        self.assertEqual((receipt["failed"], receipt["colmap"]), (None, "COLMAP 3.8"))
        self.assertEqual([part["name"] for part in receipt["parts"]], ["feature_extractor"])
        self.assertIn("Processed file", (self.colmap / "features" / "colmap.log").read_text())

    def prepare(self, *steps):
        for step in steps:
            fake_colmap.write_receipt(self.colmap / step)
            names = ["rgb/0.png", "queries/0.png", "queries/1.png", "rgb/1.png"]
            fake_colmap.write_database(self.colmap / step / "database.db", names)

    def test_few_frames_are_matched_exhaustively(self):
        self.prepare("features")
        self.run_step("matches")
        self.assertIn("exhaustive_matcher", self.calls())
        self.assertEqual(self.receipt("matches")["matching"], "exhaustive")

    def test_many_frames_are_matched_by_sequence_and_vocabulary(self):
        self.prepare("features")
        with mock.patch("colmap_step.MAX_EXHAUSTIVE", fake_site.NUM_FRAMES - 1):
            self.run_step("matches")
        commands = [line.split()[0] for line in self.calls().splitlines()]
        self.assertEqual(commands, ["sequential_matcher", "vocab_tree_builder", "vocab_tree_matcher"])

    def test_queries_are_matched_with_the_map_alone(self):
        self.prepare("matches")
        self.run_step("queries")
        pairs = (self.colmap / "queries" / "pairs.txt").read_text().splitlines()
        self.assertEqual(len(pairs), 2 * fake_site.NUM_FRAMES)
        self.assertTrue(all(len(set(name.split("/")[0] for name in pair.split())) == 2 for pair in pairs))

    def test_queries_of_a_large_map_are_matched_with_the_mapping_frames_retrieved(self):
        self.prepare("matches")
        (self.colmap / "matches" / "vocabulary.bin").write_bytes(b"tree")
        self.run_step("queries", RETRIEVED)
        queries = self.colmap / "queries"
        self.assertEqual((queries / "queries.txt").read_text().split(), ["queries/0.png", "queries/1.png"])
        searched = (queries / "map.txt").read_text().split()
        self.assertEqual(searched, [f"rgb/{i}.png" for i in range(fake_site.NUM_FRAMES)])
        pairs = (queries / "pairs.txt").read_text().splitlines()
        self.assertEqual(pairs, ["queries/0.png rgb/1.png", "queries/0.png rgb/0.png"])
        self.assertIn("--num_images 30", self.calls())
        self.assertIn("30 mapping frames", self.receipt("queries")["matching"])

    def test_more_are_retrieved_by_colmaps_default(self):
        self.prepare("matches")
        (self.colmap / "matches" / "vocabulary.bin").write_bytes(b"tree")
        self.run_step("queries_default", RETRIEVED)
        self.assertIn("--num_images 100", self.calls())
        self.assertIn("100 mapping frames", self.receipt("queries_default")["matching"])

    def test_where_all_frames_are_matched_the_default_is_skipped_with_all_that_builds_on_it(self):
        self.prepare("matches")
        for name in ("mapper_1", "triangulate"):
            fake_colmap.write_receipt(self.colmap / name)
        for step in ("queries_default", "register_mapper_1_default", "register_held_default"):
            self.assertEqual(self.run_step(step).returncode, 0)
            receipt = self.receipt(step)
            self.assertEqual((receipt["failed"], receipt["skipped"]), (None, "queries are matched with all mapping frames"))
        self.assertFalse((self.folder / "calls").exists())

    def test_each_run_of_the_mapper_has_a_seed_of_its_own(self):
        self.prepare("matches")
        for run in (1, 2, 3):
            self.run_step(f"mapper_{run}")
        self.assertEqual([call.split("--random_seed ")[1][0] for call in self.calls().splitlines()], ["1", "2", "3"])

    def test_a_retrieval_that_does_not_tell_of_every_query_is_a_failure(self):
        self.prepare("matches")
        (self.colmap / "matches" / "vocabulary.bin").write_bytes(b"tree")
        self.run_step("queries")
        self.assertIn("printed results of 0 of 2 queries", self.receipt("queries")["failed"])

    def test_intrinsics_stay_fixed(self):
        self.prepare("matches")
        self.run_step("mapper_1", f"cd {self.colmap}/.writing.*/mapper_1/models && mkdir 0")
        self.assertIsNone(self.receipt("mapper_1")["failed"])
        self.assertIn("--Mapper.ba_refine_focal_length 0", self.calls())

    def test_a_failure_is_kept_with_its_reason_and_is_older_than_anything(self):
        self.prepare("matches")
        result = self.run_step("mapper_1", "echo no good initial pair; exit 3")
        self.assertEqual(result.returncode, 0)
        self.assertEqual(self.receipt("mapper_1")["failed"], "colmap mapper: exit code 3: no good initial pair")
        first_ns = (self.colmap / "mapper_1" / "receipt.json").stat().st_mtime_ns
        self.assertLess(first_ns, Path(__file__).stat().st_mtime_ns)
        self.run_step("mapper_1", "exit 4")
        self.assertNotEqual((self.colmap / "mapper_1" / "receipt.json").stat().st_mtime_ns, first_ns)

    def test_a_killed_colmap_is_a_failure(self):
        self.prepare("matches")
        self.run_step("mapper_1", "kill -9 $$")
        self.assertIn("signal 9", self.receipt("mapper_1")["failed"])

    def test_no_model_is_a_failure(self):
        self.prepare("matches")
        self.run_step("mapper_1")
        self.assertEqual(self.receipt("mapper_1")["failed"], "colmap mapper: no model")

    def test_what_builds_on_a_failure_fails_with_its_reason(self):
        fake_colmap.write_receipt(self.colmap / "mapper_1", failed="colmap mapper: no model")
        self.assertEqual(self.run_step("register_mapper_1").returncode, 0)
        self.assertEqual(self.receipt("register_mapper_1")["failed"], "colmap mapper: no model")

    def test_every_model_gets_the_queries_and_an_adjustment(self):
        self.prepare("queries")
        fake_colmap.write_receipt(self.colmap / "mapper_1")
        for name in ("0", "1"):
            (self.colmap / "mapper_1" / "models" / name).mkdir(parents=True)
        self.run_step("register_mapper_1")
        commands = [line.split()[0] for line in self.calls().splitlines()]
        self.assertEqual(commands, ["image_registrator", "bundle_adjuster"] * 2)
        self.assertIn("--BundleAdjustment.refine_focal_length 0", self.calls())

    def test_the_map_is_held_where_the_mapper_goes_on_with_the_queries(self):
        self.prepare("queries")
        fake_colmap.write_receipt(self.colmap / "triangulate")
        self.run_step("register_held")
        self.assertIsNone(self.receipt("register_held")["failed"])
        (call,) = self.calls().splitlines()
        self.assertTrue(call.startswith("mapper "), call)
        for option in ("--Mapper.fix_existing_images 1", "--Mapper.ba_refine_focal_length 0",
                       f"--input_path {self.colmap}/triangulate/models/0"):  # fmt: skip
            self.assertIn(option, call)

    def test_nightmaps_poses_come_with_the_focal_lengths_it_found(self):
        self.prepare("matches", "queries")
        fake_colmap.write_model(self.folder / "made", ["rgb/0.png"], fake_site.walk(1))
        self.run_step("triangulate", f"cp {self.folder}/made/* {self.colmap}/.writing.*/triangulate/models/0/")
        self.assertIsNone(self.receipt("triangulate")["failed"])
        cameras = (self.colmap / "triangulate" / "posed" / "cameras.txt").read_text()
        self.assertEqual(cameras, "1 PINHOLE 640 480 490.0 491.0 320.0 240.0\n")
        fake_colmap.write_receipt(self.colmap / "mapper_1")
        (self.colmap / "mapper_1" / "models" / "0").mkdir(parents=True)
        for variant, focal_px in (("triangulate", 490), ("held", 490), ("mapper_1", 500)):
            self.run_step(f"register_{variant}")
            (camera,) = read_cameras(self.colmap / f"register_{variant}" / "database.db")
            self.assertEqual(camera[4][0], focal_px)

    def test_colmap_ends_with_the_step(self):
        self.prepare("matches")
        environment = os.environ | {"PATH": self.stand_in(f"echo $$ > {self.folder}/pid; echo up; exec sleep 600")}
        command = [sys.executable, fake_site.SCRIPTS / "colmap_step.py", *self.arguments("mapper_1")]
        step = subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, text=True)
        while not (self.folder / "pid").exists() or not (self.folder / "pid").read_text():
            self.assertIsNone(step.poll())
            time.sleep(0.05)
        step.terminate()
        step.communicate()
        self.assertNotEqual(step.returncode, 0)
        with self.assertRaises(ProcessLookupError):
            os.kill(int((self.folder / "pid").read_text()), 0)
        self.assertFalse((self.colmap / "mapper_1").exists())

    def test_killed_between_the_renames_the_next_run_has_the_old_step(self):
        self.prepare("features")
        self.run_step("matches")
        after_both = [None, KeyboardInterrupt, None]
        with mock.patch("nightmap_eval.colmap.colmap_run.shutil.rmtree", side_effect=after_both):
            with self.assertRaises(KeyboardInterrupt):
                self.run_step("matches")
        self.assertTrue((self.colmap / "matches" / "receipt.json").exists())
        killed = self.colmap / f".writing.{os.uname().nodename}.killed"
        killed.mkdir()
        (self.colmap / "matches").rename(killed / "matches")  # as it is before the second
        self.assertTrue((self.colmap / "matches.old" / "receipt.json").exists())
        self.run_step("matches", path="/nonexistent")
        self.assertFalse((self.colmap / "matches").exists())
        with mock.patch("colmap_step.Work.copy_database", side_effect=KeyboardInterrupt):
            with self.assertRaises(KeyboardInterrupt):
                self.run_step("matches")
        self.assertEqual(self.receipt("matches")["matching"], "exhaustive")
        self.run_step("matches")
        self.assertEqual({path.name for path in self.colmap.iterdir()}, {"features", "matches"})

    def test_two_runs_of_a_step_each_fill_their_own_folder(self):
        with mock.patch("nightmap_eval.colmap.colmap_run.require_colmap", return_value="COLMAP 3.8"):
            first, second = (Step(self.colmap / "matches", 1) for _ in range(2))
        for step, text in ((first, "first"), (second, "second")):
            (step.folder / "database.db").write_text(text)
        for step, text in ((first, "first"), (second, "second")):
            step.finish()
            self.assertEqual((self.colmap / "matches" / "database.db").read_text(), text)
        self.assertEqual([path.name for path in self.colmap.iterdir()], ["matches"])

    def test_without_colmap_it_says_what_to_do(self):
        self.check_failed(self.run_step("features", path="/nonexistent"), "make deps")

    def test_a_query_that_is_mapped_is_refused_before_the_map_is_made(self):
        self.replace("queries/queries.csv", "queries/1.png", "rgb/3.png")
        self.prepare("matches")
        for step in ("features", "queries"):
            self.check_failed(self.run_step(step), "rgb/3.png: this query is also a mapping frame")
        self.assertFalse((self.folder / "calls").exists())

    def test_frames_of_a_video_are_refused(self):
        self.replace("frames/shard_0000.csv", "rgb/0.png", "clip.avi#0")
        self.check_failed(self.run_step("features"), "clip.avi#0")
