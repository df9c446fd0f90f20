# SPDX-License-Identifier: Apache-2.0
"""Pictures that are easily taken for others: of rooms furnished alike, of corridors that look the same
the other way round, and of a building that was never mapped."""
import json
import os
import unittest

from rendered_sites import FOLDER, make_site, recording, synthesize, write_site
from workspace import read_csv, said_by

BUILDING = "num_identical_rooms = 3\nmirrored_corridors = true\n"
NUM_QUERIES = int(os.environ.get("NIGHTMAP_NUM_QUERIES", "80"))  # of each kind; more take longer


class LookAlikesTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        synthesize("look_alikes", BUILDING + f"seed = 5\nnum_frames = 700\nnum_queries = {NUM_QUERIES}\n")
        synthesize("look_alikes/stranger", "seed = 6\nnum_frames = 120\nmax_step_m = 1\nmax_turn_rad = 1\n"
                   f"min_covisible_ratio = 0.2\nnum_queries = {NUM_QUERIES}\n")
        sites = write_site("look_alikes", [
            recording(".", 0), recording("queries", 0, "query"),
            recording("stranger/queries", 1, "query", has_truth=False)])
        site_dir = make_site("look_alikes", f"SITES={sites}", "localize")
        said_by(["/usr/bin/python3", "scripts/evaluate.py", "--site-dir", site_dir, "--data", FOLDER / "data",
                 "--out", site_dir / "evaluate/metrics.json"])
        cls.metrics = json.loads((site_dir / "evaluate/metrics.json").read_text())["queries"]
        cls.rows = read_csv(site_dir / "localize/queries.csv")

    def test_a_located_picture_is_in_its_own_room(self):
        self.assertEqual(self.metrics["num_with_truth"], NUM_QUERIES)
        self.assertLessEqual(self.metrics["located_max_translation_error_cm"], 50)
        self.assertGreaterEqual(self.metrics["local"]["recall_5cm_5deg_percent"], 90)

    def test_look_alikes_are_noticed(self):
        """Rooms furnished alike show as rivals; most of them are told apart, the others are ambiguous."""
        own = [row for row in self.rows if "stranger" not in row["color_path"]]
        rivals = [row for row in own if int(row["num_rival_inliers"]) > 0.5 * int(row["num_inliers"])]
        self.assertGreater(len(rivals), 3)
        located = [row for row in rivals if row["status"] == "located"]
        self.assertGreater(len(located), 0)
        self.assertEqual(len([row for row in rivals if row["status"] == "ambiguous"]), len(rivals) - len(located))
        for row in rivals:
            self.assertLess(float(row["confidence"]), 0.95)

    def test_pictures_of_another_building_are_refused(self):
        strangers = [row for row in self.rows if "stranger" in row["color_path"]]
        self.assertEqual(len(strangers), NUM_QUERIES)
        refused = [row for row in strangers if row["status"] == "not_in_map"]
        self.assertGreaterEqual(len(refused), 0.98 * NUM_QUERIES)
        for row in refused:
            self.assertIn(row["reason"], ("too_few_matches", "too_few_inliers", "uncertain_pose"))
