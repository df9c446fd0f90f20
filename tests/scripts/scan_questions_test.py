# SPDX-License-Identifier: Apache-2.0
"""QUERY, NEAR, NEAR_RADIUS and TURN of make where a site is asked for laser scans."""

import os

from config_folder import CONFIG, PREVIEW, ConfigFolder
from nightmap_site.pipeline import read_pipeline
from nightmap_site.site import CONFIGS
from nightmap_site.toml_file import PipelineError

SITE = 'root = "lab"\n[[sensor]]\nid = "laser"\nkind = "scan"\n[[signal]]\nsensor = "laser"\nfile = "robot.log"\n'
COPIES = ("site/office", "queries/office")
ASKED = "asked/office"


class ScanQuestionsTest(ConfigFolder):
    def setUp(self):
        super().setUp()
        self.write("configs/sites/office.toml", SITE)
        self.write("data/lab/robot.log", "FLASER")
        self.write("wake.log", "FLASER")
        self.write("turn here.log", "FLASER")

    def ask(self, **changes):
        """The [[query]] tables that the stage reads."""
        self.resolve(asks="scans", **changes)
        return self.config(ASKED)["query"]

    def test_each_log_is_a_table(self):
        self.assertEqual(self.ask(query="wake.log 'turn here.log'"), [{"scans": "../../wake.log"}, {"scans": "../../turn here.log"}])
        self.resolve(asks="scans")
        self.assertEqual(self.text(f"{ASKED}.toml"), "")

    def test_what_is_known_of_the_scans_stands_with_each(self):
        self.assertEqual(self.ask(query="wake.log", near="3.5,-2"), [{"scans": "../../wake.log", "near_m": [3.5, -2.0]}])
        near = {"near_m": [1.0, 2.0], "near_radius_m": 0.5}
        self.assertEqual(self.ask(query="wake.log 'turn here.log'", near="1, 2", near_radius="0.5", turn="1"),
                         [{"scans": f"../../{name}", "turn": True} | near for name in ("wake.log", "turn here.log")])  # fmt: skip
        self.assertEqual(self.ask(query="wake.log", turn="0"), [{"scans": "../../wake.log"}])

    def test_mistakes_are_refused(self):
        for changes, message in (
            ({"query": "nowhere.log"}, "QUERY: nowhere.log does not exist: name logs of laser scans"),
            ({"query": "data"}, "QUERY: data is a folder: name logs of laser scans"),
            ({"near": "1,2"}, "NEAR, NEAR_RADIUS and TURN describe the laser scans of QUERY: name a log"),
            ({"turn": "1"}, "describe the laser scans of QUERY"),
            ({"query": "wake.log", "near": "1"}, 'NEAR=1: give x and y in the map in metres, as in NEAR="3.5,-2"'),
            ({"query": "wake.log", "near": "1,two"}, "NEAR=1,two: give x and y"),
            ({"query": "wake.log", "near": "1,nan"}, "NEAR=1,nan: give x and y"),
            ({"query": "wake.log", "near": "1,2,3"}, "NEAR=1,2,3: give x and y"),
            ({"query": "wake.log", "near_radius": "3"}, 'give NEAR="x,y", too'),
            ({"query": "wake.log", "near": "1,2", "near_radius": "0"}, "NEAR_RADIUS=0: give a number of metres above 0"),
            ({"query": "wake.log", "near": "1,2", "near_radius": "-1"}, "NEAR_RADIUS=-1: give a number"),
            ({"query": "wake.log", "near": "1,2", "near_radius": "far"}, "NEAR_RADIUS=far: give a number"),
            ({"query": "wake.log", "turn": "yes"}, "TURN=yes: give 1"),
            ({"query": "wake.log", "camera": "phone"}, "CAMERA and FOV_DEG describe pictures; site office with profile default is asked"),
            ({"query": "wake.log", "fov_deg": "60"}, "CAMERA and FOV_DEG describe pictures"),
        ):  # fmt: skip
            with self.subTest(changes):
                self.assertIn(message, self.refused(asks="scans", **changes))
        self.assertFalse(os.path.exists(CONFIG))

    def test_a_site_that_is_asked_for_pictures_refuses_what_describes_scans(self):
        for changes in ({"near": "1,2"}, {"near_radius": "2"}, {"turn": "1"}):
            with self.subTest(changes):
                self.assertIn("NEAR, NEAR_RADIUS and TURN describe laser scans; site office with profile default is asked for pictures",
                              self.refused(query="wake.log", **changes))  # fmt: skip

    def test_the_stage_reads_the_scanner_and_no_recording(self):
        self.resolve(asks="scans")
        before = [self.time(copy) for copy in COPIES]
        self.write("configs/sites/office.toml", SITE.replace('kind = "scan"\n', 'kind = "scan"\nmax_range_m = 30\n'))
        self.resolve(asks="scans")
        after = [self.time(copy) for copy in COPIES]
        self.assertEqual([new == old for new, old in zip(after, before)], [False, False])
        self.write("configs/sites/office.toml", SITE.replace('kind = "scan"\n', 'kind = "scan"\nmax_range_m = 30\n')
                   + '[robot_truth]\ntrajectory = "robot.log"\n')  # fmt: skip
        self.resolve(asks="scans")
        self.assertEqual([self.time(copy) == old for copy, old in zip(COPIES, after)], [False, True])

    def test_logs_must_be_there_and_a_changed_one_counts(self):
        self.write("configs/sites/office.toml", SITE + '[[query]]\nscans = "own.log"\n')
        self.assertIn("data/lab/own.log does not exist", self.refused(asks="scans"))
        own = self.write("data/lab/own.log", "FLASER")
        stamp = self.resolve(asks="scans")["pictures"]
        first = os.stat(stamp).st_mtime_ns
        self.assertEqual(os.stat(self.resolve(asks="scans")["pictures"]).st_mtime_ns, first)
        own.write_text("FLASER 1")
        self.assertNotEqual(os.stat(self.resolve(asks="scans")["pictures"]).st_mtime_ns, first)
        second = os.stat(stamp).st_mtime_ns
        self.resolve(asks="scans", query="wake.log", work_dir=PREVIEW)
        self.assertEqual(os.stat(stamp).st_mtime_ns, second)

    def test_text_is_text(self):
        self.write("configs/sites/office.toml", SITE + "[[query]]\nscans = 5\n")
        self.assertIn("scans of [[query]] must be text", self.refused(asks="scans"))


class AsksTest(ConfigFolder):
    def test_the_job_that_lists_the_queries_says_what_they_are(self):
        self.assertEqual(read_pipeline(str(CONFIGS)).asks, "pictures")
        self.assertEqual(read_pipeline(str(CONFIGS), "laser").asks, "scans")
        self.assertEqual(read_pipeline(str(CONFIGS), "laser", ["trajectory"]).asks, "scans")

    def test_nobody_asks_for_anything_else(self):
        self.write("configs/pipeline.toml", '[queries]\npurpose = "lists"\nasks = "songs"\nout.list = "queries.txt"\n')
        with self.assertRaisesRegex(PipelineError, r'pipeline.toml:3: \[queries\]: asks = "songs" is none of pictures, scans'):
            read_pipeline("configs")
