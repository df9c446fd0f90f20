# SPDX-License-Identifier: Apache-2.0
"""Each publication is one word: on small made-up sites, PROFILE=published_... gives a map, and located queries where the publication
locates any, with the published values; nothing of it is left when the site goes back to its own profile."""
import json
import tomllib
import unittest

import labels_test
from workspace import LASER_SITE, RECORDING, REPOSITORY, SITE, Workspace, read_csv, write_laser_site

CONFIGS = REPOSITORY / "configs"


class Published(unittest.TestCase):
    """A workspace whose site `site` is mapped with `profile`. Others inherit from it. heart: the values without which it would not be
    the published method."""

    site, profile, goals, heart = None, None, ("map", "evaluate", "report"), {}

    @classmethod
    def make(cls, *arguments, code=0):
        return cls.work.output(f"SITE={cls.site}", *arguments, code=code)

    @classmethod
    def map_as_published(cls):
        cls.addClassCleanup(cls.work.remove)
        cls.make(*cls.goals, f"PROFILE={cls.profile}")
        cls.maps = cls.work.folder / "maps" / cls.site
        cls.metrics = json.loads((cls.maps / "evaluate/metrics.json").read_text())

    def queries(self):
        return read_csv(self.maps / "localize/queries.csv")

    def effective(self, options, key):
        return tomllib.loads((self.maps / f"config/{options}.toml").read_text())[key]

    def check_values_and_state(self):
        """Every value of the profile is in the effective configs; the map is up to date and as written."""
        for path in (CONFIGS / self.profile).glob("*.toml"):
            values = tomllib.loads(path.read_text()) if path.name != "pipeline.toml" else {}
            self.assertEqual({key: self.effective(path.stem, key) for key in values}, values, path.name)
        self.assertEqual({key: self.effective(*key.split(".")) for key in self.heart}, self.heart)
        self.make("-q", *self.goals, f"PROFILE={self.profile}")
        self.assertIn("all as written", self.make("verify"))

    def check_that_nothing_is_left(self, job):
        """Without the word, `job` runs, which the profile leaves out; with it, the result is removed."""
        self.make("map")
        self.assertTrue(list((self.maps / job).glob("*.*")))
        self.assertIn(f"{job}:", self.make("why", "SET=pose_graph.max_drift=9"))
        self.make("map", f"PROFILE={self.profile}")
        self.assertEqual(list((self.maps / job).glob("*.*")), [])


class RgbdTest(Published):
    site, profile, goals = SITE, "published_rgbd", ("map", "localize", "plan", "evaluate", "report")
    heart = {"features.max_gap_frames": 0, "matches.pair_offsets": [1], "octree.builder": "octomap", "localize.solver": "dlt6",
             "localize.num_guided_keyframes": 0, "localize.refinement": False, "plan.planner": "astar"}  # fmt: skip

    @classmethod
    def setUpClass(cls):
        cls.work = Workspace.made(RECORDING)
        cls.map_as_published()

    def test_1_queries_are_located_and_a_path_is_planned(self):
        located = [row for row in self.queries() if row["status"] == "located"]
        self.assertGreater(len(located), len(self.queries()) / 2)
        self.assertEqual(self.metrics["queries"]["num_wrong"], 0)
        self.assertLess(self.metrics["trajectory"]["se3"]["ate_rmse_m"], 0.1)
        self.assertGreater(len((self.maps / "plan/path.csv").read_text().splitlines()), 2)

    def test_2_values_are_the_published_ones(self):
        self.check_values_and_state()
        self.assertEqual(list((self.maps / "adjust").glob("*.*")), [])

    def test_3_nothing_is_left(self):
        self.check_that_nothing_is_left("adjust")


class LaserTest(Published):
    site, profile, goals = LASER_SITE, "published_laser", ("map", "localize", "evaluate", "report")
    heart = {"scan_localize.method": "published"}

    @classmethod
    def setUpClass(cls):
        cls.work = Workspace()
        write_laser_site(cls.work.folder)
        cls.make(f"data/{cls.site}/synthesize.json")
        log = (cls.work.folder / "data" / cls.site / "robot.log").read_text()
        (cls.work.folder / "wake.log").write_text([line for line in log.splitlines(True) if line.startswith("FLASER ")][40])
        cls.goals = (*cls.goals, "QUERY=wake.log")
        cls.map_as_published()

    def test_1_a_scan_is_located_by_the_published_steps(self):
        self.assertEqual([row["status"] for row in self.queries()], ["located"])
        self.assertEqual(self.metrics["sections"]["test_localize"]["num_wrong"], 0)
        with_default = self.work.copy().removed_after(self)
        with_default.make(f"SITE={self.site}", "localize", "QUERY=wake.log")
        candidates = "maps/" + self.site + "/localize/candidates.csv"
        self.assertNotEqual(*((work.folder / candidates).read_text() for work in (self.work, with_default)))

    def test_2_values_are_the_published_ones_and_the_others_those_of_the_laser(self):
        self.check_values_and_state()
        default = tomllib.loads((CONFIGS / "laser/default/scan_match.toml").read_text())
        self.assertEqual(tomllib.loads((self.maps / "config/scan_match.toml").read_text()), default)


class PeopleTest(Published):
    """The label pictures of the recording stand for a network: nothing of the made-up building moves."""

    site, profile, heart = SITE, "published_people", {"moving.method": "published", "features.detector": "orb"}

    @classmethod
    def setUpClass(cls):
        cls.work = Workspace.made(RECORDING)
        cls.work.as_recorded()
        config = cls.work.folder / f"configs/sites/{SITE}.toml"
        text = config.read_text().replace("[[sequence]]\n", '[[sequence]]\nlabel_folder = "labels"\n')
        config.write_text(f'profile = "moving"\n{text}\n[import]\nmodel = "model.toml"\n')
        (cls.work.folder / "data/model.toml").write_text(labels_test.MODEL)
        cls.map_as_published()

    def test_1_the_map_has_labels(self):
        self.assertGreater(json.loads((self.maps / "octree/report.json").read_text())["num_occupied_voxels"], 1000)
        classes = json.loads((self.maps / "voxel_labels/legend.json").read_text())["classes"]
        self.assertGreater(sum(entry["num_voxels"] > 0 for entry in classes), 2)
        self.assertLess(self.metrics["trajectory"]["se3"]["ate_rmse_m"], 0.1)

    def test_2_values_are_the_published_ones(self):
        self.check_values_and_state()
