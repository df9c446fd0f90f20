# SPDX-License-Identifier: Apache-2.0
"""Words of make localize, metrics.json and the page on laser scans that were located."""

import fake_site
import laser_site
from folder_case import SiteFolderTest
from nightmap_site.query_results import asked_names
from nightmap_site.site import Site

HEADER = ("query_idx,time_ns,color_path,status,reason,num_matches,num_inliers,num_rival_inliers,confidence,"
          "reprojection_error_px,position_sigma_m,rotation_sigma_deg,tx_m,ty_m,tz_m,qx,qy,qz,qw")
NAMES = ("own.log", "../wake.log#1", "../wake.log#2", "../turn.log")
# A robot that points along the map's y: turned by 90 degrees about z.
FACING_Y = "0,0,0.70710678,0.70710678"


class ScanResultsTest(SiteFolderTest):
    SITE = "hall"

    def setUp(self):
        laser_site.write_site(self.site_dir)
        self.write("config/profile.toml", 'profile = "laser"\nimports = []\n')
        self.write("config/queries/hall.toml", '[[query]]\nscans = "own.log"\n')
        self.write("config/asked/hall.toml", '[[query]]\nscans = "../wake.log"\n[[query]]\nscans = "../turn.log"\n')
        self.write("queries/queries.txt", "\n".join((f"nightmap queries, version 1, {len(NAMES)} names", *NAMES)) + "\n")
        located = f"located,,181,170,0,0.9,0,0.012,0.3,1.5,-2,0,{FACING_Y}"
        results = (located, located, "not_in_map,low_score,181,20,0,0,0,0,0,,,,,,,", located)
        self.write("localize/queries.csv", "\n".join((HEADER, *(f"{i},{i},{name},{results[i]}" for i, name in enumerate(NAMES)))) + "\n")

    def test_the_scans_of_query_are_those_of_its_logs(self):
        self.assertEqual(asked_names(Site(self.site_dir)), set(NAMES[1:]))
        self.write("config/asked/hall.toml", "")
        self.assertEqual(asked_names(Site(self.site_dir)), set())

    def test_the_heading_is_where_the_robot_points(self):
        lines = fake_site.run("show_queries.py", self.site_dir).stdout.splitlines()
        self.assertEqual([line.split()[0] for line in lines], ["scan", *NAMES[1:], "1"])
        self.assertEqual(lines[1].split(), ["../wake.log#1", "located", "1.50", "-2.00", "0.00", "90", "1.2", "0.30"])
        self.assertEqual(lines[2].split(), ["../wake.log#2", "not_in_map", "low_score"])

    def test_metrics_count_the_verdicts(self):
        queries = self.metrics()["queries"]
        self.assertEqual((queries["num_queries"], queries["num_located"], queries["num_failed"]), (4, 3, 1))
        self.assertEqual(queries["num_by_verdict"]["not_in_map"], 1)
        (self.site_dir / "localize" / "queries.csv").unlink()
        self.assertNotIn("queries", self.metrics())

    def test_the_page_names_scans_and_shows_no_pictures(self):
        self.metrics()
        page = self.report()
        section = page[page.index(">Queries</h2>"):]
        section = section[:section.index("<details class=\"section\"")]
        self.assertIn("<th>scan</th>", section)
        self.assertNotIn("picture", section)
        places = [section.index(f"<td>{name}") for name in (*(f"{name} (of QUERY)" for name in NAMES[1:]), "own.log")]
        self.assertEqual(places, sorted(places))

    def test_a_damaged_list_is_named(self):
        self.write("queries/queries.txt", "nightmap queries, version 1, 9 names\na\n")
        result = fake_site.run("show_queries.py", self.site_dir)
        self.assertEqual(result.returncode, 1)
        self.assertRegex(result.stderr, "^error: .*queries/queries.txt.*delete the file and run make again\n$")
