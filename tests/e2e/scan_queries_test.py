# SPDX-License-Identifier: Apache-2.0
"""make localize on a site of laser scans, up to the list of the queries: what QUERY, NEAR, NEAR_RADIUS and TURN ask, and what reruns."""
import json
import unittest

import h5py
import numpy as np

from laser_test import LaserSite
from workspace import write_black

LIST = "maps/demo_laser/queries/queries.txt"
NUM_SCANS = 8  # of a log: those of 0.7 m of path


class ScanQueriesTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.site = LaserSite()
        cls.addClassCleanup(cls.site.work.remove)
        cls.site.make("data/demo_laser/synthesize.json")
        scans = [line for line in (cls.site.data / "robot.log").read_text().splitlines() if line.startswith("FLASER ")]
        cls.scans, cls.folder = scans, cls.site.work.folder
        (cls.folder / "wake.log").write_text(scans[300] + "\n")
        (cls.folder / "turn here.log").write_text("\n".join(scans[:NUM_SCANS]) + "\n")

    def ask(self, *arguments, code=0):
        return self.site.make(LIST, *arguments, code=code)

    def names(self):
        header, *names = (self.site.work.folder / LIST).read_text().splitlines()
        self.assertEqual(header, f"nightmap queries, version 1, {len(names)} names")
        return names

    def arrays(self):
        with h5py.File(self.site.maps / "queries/queries.h5") as file:
            return {name: np.array(file[name]) for name in file}

    def test_each_scan_of_a_log_is_asked_for(self):
        self.ask("QUERY=wake.log")  # after a failure of another test, this makes the report, too
        self.ask("QUERY='turn here.log' wake.log")
        self.assertEqual(self.names(), [*(f"../../turn here.log#{k}" for k in range(1, NUM_SCANS + 1)), "../../wake.log"])
        arrays = self.arrays()
        self.assertEqual(np.ravel(arrays["scan_offset"]).tolist(), list(range(NUM_SCANS + 2)))
        self.assertEqual(arrays["range_m"].size, 360 * (NUM_SCANS + 1))
        words = self.scans[300].split()
        np.testing.assert_allclose(np.ravel(arrays["range_m"])[-360:], [float(word) for word in words[2:362]], rtol=1e-6)
        self.assertFalse(np.any(arrays["rough_position"]))
        report = json.loads((self.site.maps / "queries/report.json").read_text())
        self.assertEqual(report["num_queries"], NUM_SCANS + 1)
        self.assertEqual(self.site.jobs_that_ran() - {"synthesize", "queries"}, set())  # nothing of the map

    def test_a_robot_that_turned_asks_once_and_says_where_it_may_be(self):
        self.ask("QUERY='turn here.log'", "TURN=1", "NEAR=3.5,-2", "NEAR_RADIUS=1.5")
        self.assertEqual(self.names(), ["../../turn here.log"])
        arrays = self.arrays()
        np.testing.assert_array_equal(arrays["rough_position"], [[3.5, -2, 1.5]])
        poses = np.array([[float(word) for word in line.split()[365:368]] for line in self.scans[:NUM_SCANS]])
        heading_rad = (poses[:, 2] - poses[0, 2] + np.pi) % (2 * np.pi) - np.pi
        np.testing.assert_allclose(arrays["query_from_laser"][:, 0], heading_rad, atol=1e-9)
        np.testing.assert_allclose(np.hypot(*arrays["query_from_laser"][:, 1:].T),
                                   np.hypot(*(poses[:, :2] - poses[0, :2]).T), atol=1e-9)  # fmt: skip

    def test_the_same_question_reruns_nothing_and_no_question_empties_the_list(self):
        self.ask("QUERY=wake.log")
        time_ns = (self.site.maps / "queries/queries.h5").stat().st_mtime_ns
        self.assertEqual(self.site.make("-q", LIST, "QUERY=wake.log"), "")
        self.ask("QUERY=wake.log", "NEAR=1,2")
        self.assertGreater((self.site.maps / "queries/queries.h5").stat().st_mtime_ns, time_ns)
        log = self.folder / "wake.log"
        log.write_text(self.scans[400] + "\n")
        self.site.make("-q", LIST, "QUERY=wake.log", "NEAR=1,2", code=1)
        self.ask()
        self.assertEqual(self.names(), [])

    def test_mistakes_name_the_variable_or_the_file(self):
        for arguments, code, message in (
            (["QUERY=missing.log"], 2, "QUERY: missing.log does not exist"),
            (["QUERY=wake.log", "NEAR=1"], 2, "NEAR=1: give x and y"),
            (["QUERY=wake.log", "NEAR_RADIUS=1"], 2, "NEAR_RADIUS is the radius around NEAR"),
            (["QUERY=wake.log", "FOV_DEG=60"], 2, "CAMERA and FOV_DEG describe pictures; site demo_laser with profile laser"),
            (["QUERY=wake.log", "TURN=yes"], 2, "TURN=yes: give 1"),
        ):  # fmt: skip
            with self.subTest(arguments):
                self.assertIn(message, self.ask(*arguments, code=code))
        write_black(self.folder / "photo.png", 32, 24)
        self.assertIn("photo.png: holds no scan: correct `scans`, `format` or `message` in QUERY of make",
                      self.ask("QUERY=photo.png", code=2))  # fmt: skip
        result = self.site.work.make("localize", "QUERY=photo.png", "NEAR=1,2")  # of the site with a camera
        self.assertEqual(result.returncode, 2, result.stdout)
        self.assertIn("NEAR, NEAR_RADIUS and TURN describe laser scans; site small with profile default", result.stdout)

    def test_a_mistake_in_the_config_names_its_line(self):
        config = self.site.config()
        text = config.read_text()
        self.addCleanup(config.write_text, text)
        config.write_text(text + '[[query]]\nscans = "robot.log"\nnear_radius_m = 3\n')
        line = text.count("\n") + 1
        self.assertIn(f"configs/sites/demo_laser.toml:{line}: 'near_radius_m' needs near_m", self.ask(code=2))
