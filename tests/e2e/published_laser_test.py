#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Laser relocalization as published (CN110307838A), through make: objects that a site imports, and a rough position of each scan."""
import csv
import json
import shutil
import unittest

from workspace import LASER_SITE, Workspace, write_laser_site

PUBLISHED = ("PROFILE=published_laser", "SET=hold_out_scans.rough_radius_m=3")


class PublishedTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.work = Workspace()
        cls.addClassCleanup(cls.work.remove)
        write_laser_site(cls.work.folder)
        cls.maps = cls.work.folder / "maps" / LASER_SITE
        cls.make("map", "report", *PUBLISHED)
        cls.without_objects = cls.report()
        given = cls.work.folder / "data" / LASER_SITE / "objects.yaml"
        shutil.copyfile(cls.maps / "objects/objects.yaml", given)
        config = cls.work.folder / f"configs/sites/{LASER_SITE}.toml"
        config.write_text(config.read_text() + f'\n[import]\nobjects = "{LASER_SITE}/objects.yaml"\n')
        cls.make("map", "evaluate", "report", *PUBLISHED)

    @classmethod
    def make(cls, *arguments):
        result = cls.work.make(f"SITE={LASER_SITE}", *arguments)
        if result.returncode:
            raise AssertionError(result.stdout[-4000:])

    @classmethod
    def report(cls):
        return json.loads((cls.maps / "test_localize/report.json").read_text())

    def test_the_second_list_has_the_true_places(self):
        report = self.report()
        self.assertEqual((self.without_objects["num_objects"], self.without_objects["num_object_poses"]), (0, 0))
        self.assertGreater(report["num_objects"], 0)
        with open(self.maps / "test_localize/object_poses.csv", encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
        self.assertEqual(len(rows), report["num_object_poses"])
        self.assertGreater(len(rows), 0)
        self.assertTrue(all(int(row["object_idx"]) < report["num_objects"] for row in rows))
        self.assertTrue(all(0.5 <= float(row["overlap"]) <= 1 for row in rows))

    def test_scans_are_located_at_their_places(self):
        figures = json.loads((self.maps / "evaluate/metrics.json").read_text())["sections"]["test_localize"]
        self.assertGreater(figures["num_queries"], 5)
        self.assertGreaterEqual(figures["num_by_verdict"]["located"], max(1, self.without_objects["num_by_verdict"]["located"]))
        self.assertEqual(figures["num_wrong"], 0)
        self.assertGreater(figures["num_queries_near_objects"], 0)

    def test_the_page_counts_what_objects_did(self):
        page = (self.maps / "report/index.html").read_text()
        for title in ("Objects of the map", "Poses at which an object is where the map has it", "Scans of which objects removed a place"):
            self.assertIn(title, page)


if __name__ == "__main__":
    unittest.main()
