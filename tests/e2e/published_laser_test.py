# SPDX-License-Identifier: Apache-2.0
"""Laser relocalization as published (CN110307838A), through make: objects that a site imports, and a rough position of each scan."""
import json
import math
import shutil
import unittest

from workspace import LASER_SITE, Workspace, read_csv, write_laser_site
from nightmap_eval import planar_poses  # workspace finds the scripts
from nightmap_eval.trajectory import read_tum

PUBLISHED = ("PROFILE=published_laser", "SET=hold_out_scans.rough_radius_m=3")


class PublishedTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.work = Workspace().removed_after(cls)
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
        cls.work.output(f"SITE={LASER_SITE}", *arguments)

    @classmethod
    def report(cls):
        return json.loads((cls.maps / "test_localize/report.json").read_text())

    def rows(self, name):
        return read_csv(self.maps / "test_localize" / name)

    def queries_at_the_true_place(self, rows):
        """Queries of which a row is as near to the true place as the filter asks for."""
        truth = read_tum(self.maps / "test_scans/truth.tum")
        headings_rad = planar_poses.headings_rad(truth)
        found = set()
        for row in rows:
            query = int(row["query_idx"])
            x_m, y_m = truth.positions_m[query, :2]
            turn_rad = math.remainder(float(row["heading_rad"]) - headings_rad[query], math.tau)
            if math.hypot(float(row["x_m"]) - x_m, float(row["y_m"]) - y_m) <= 0.5 and abs(turn_rad) <= math.radians(10):
                found.add(query)
        return found

    def test_the_second_list_has_the_true_places(self):
        report = self.report()
        self.assertEqual((self.without_objects["num_objects"], self.without_objects["num_object_poses"]), (0, 0))
        self.assertGreater(report["num_objects"], 0)
        rows = self.rows("object_poses.csv")
        self.assertEqual(len(rows), report["num_object_poses"])
        self.assertGreater(len(rows), 0)
        self.assertTrue(all(int(row["object_idx"]) < report["num_objects"] for row in rows))
        self.assertTrue(all(0.5 <= float(row["overlap"]) <= 1 for row in rows))
        see_objects = self.queries_at_the_true_place(row for row in self.rows("candidates.csv") if int(row["num_confirmed"]) >= 8)
        self.assertGreater(len(see_objects), 1)  # from the other places of this way no object is in sight
        self.assertLessEqual(see_objects, self.queries_at_the_true_place(rows))

    def test_the_filter_acts_and_keeps_the_true_places(self):
        report = self.report()
        self.assertEqual(self.without_objects["num_queries_filtered_by_objects"], 0)
        self.assertGreater(report["num_queries_filtered_by_objects"], 0)
        self.assertEqual(len(self.queries_at_the_true_place(self.rows("candidates.csv"))), report["num_queries"])

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
