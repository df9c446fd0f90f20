# SPDX-License-Identifier: Apache-2.0
"""show_queries.py: which pictures it shows, where they are, and that the report puts those of QUERY first."""

import json

import fake_site
from folder_case import SiteFolderTest
from nightmap_eval.camera.report_queries import query_section
from nightmap_site.query_results import asked_names
from nightmap_site.site import Site

HEADER = ("query_idx,time_ns,color_path,status,reason,num_matches,num_inliers,num_rival_inliers,confidence,"
          "reprojection_error_px,position_sigma_m,rotation_sigma_deg,tx_m,ty_m,tz_m,qx,qy,qz,qw")
SITE = 'root = "office"\n[[sequence]]\nfolder = "."\n[[query]]\npictures = "own"\n'
ASKED = '[[query]]\npictures = "a.jpg"\n[[query]]\npictures = "b.jpg"\n'
# The optical axis along y: turned from looking along z by -90 degrees about x.
LOOKING_ALONG_Y = "-0.70710678,0,0,0.70710678"


class ShowQueriesTest(SiteFolderTest):
    def setUp(self):
        self.write("config/queries/office.toml", SITE)
        self.write("config/asked/office.toml", "")
        self.write_queries(num_own=20, asked=())

    def write_queries(self, num_own, asked):
        """Own queries, of which the last is not located, then those of QUERY."""
        names = [(f"own/{i}.jpg", 1) for i in range(num_own)] + [(name, 2 + i) for i, name in enumerate(asked)]
        listed, located = ["frame_idx,time_ns,color_path,sequence_idx"], [HEADER]
        for i, (name, sequence) in enumerate(names):
            listed.append(f"{i},{i},{name},{sequence}")
            result = f"located,,50,40,0,1,0.8,0.0123,0.456,1.5,-2,4.25,{LOOKING_ALONG_Y}"
            if i == num_own - 1 or name == "b.jpg":
                result = "not_in_map,few_inliers,50,4,0,0,0,0,0,,,,,,,"
            located.append(f"{i},{i},{name},{result}")
        self.write("queries/queries.csv", "\n".join(listed) + "\n")
        self.write("localize/queries.csv", "\n".join(located) + "\n")

    def show(self, code=0):
        result = fake_site.run("show_queries.py", self.site_dir)
        self.assertEqual(result.returncode, code, result.stderr)
        return result.stderr if code else result.stdout.splitlines()

    def test_own_queries_are_counted_and_a_dozen_shown(self):
        lines = self.show()
        self.assertEqual(lines[0], "20 queries of the site: 19 located, 1 not_in_map")
        self.assertEqual(len(lines), 1 + 1 + 12 + 1)
        self.assertEqual(lines[1].split("  ")[0].strip(), "picture")
        self.assertEqual(lines[2].split(), ["own/0.jpg", "located", "1.50", "-2.00", "4.25", "90", "1.2", "0.46"])
        self.assertEqual(lines[-1], "...")

    def test_pictures_of_query_are_all_shown(self):
        self.write("config/asked/office.toml", ASKED)
        self.write_queries(num_own=20, asked=["a.jpg", "b.jpg"])
        lines = self.show()
        self.assertEqual([line.split()[0] for line in lines], ["picture", "a.jpg", "b.jpg", "20"])
        self.assertEqual(lines[2].split(), ["b.jpg", "not_in_map", "few_inliers"])

    def test_the_floor_is_told_where_there_are_several(self):
        rows = [{"number": number, "height_m": height_m, "yaml": yaml} for number, height_m, yaml in
                ((-1, -3.0, "floor_-1.yaml"), (0, 0.0, "map.yaml"), (1, 2.9, "floor_1.yaml"))]  # fmt: skip
        self.write("grid/floors.json", json.dumps({"format": "nightmap floors", "version": 2, "floors": rows}))
        lines = self.show()
        self.assertIn("floor", lines[1])
        self.assertEqual(lines[2].split()[6], "1")

    def test_damage_is_named(self):
        for name, text in (("localize/queries.csv", HEADER + "\n1,2,3\n"),
                           ("localize/queries.csv", f"{HEADER}\n" + "x," * 18 + "\n"),
                           ("queries/queries.csv", "color_path\na\n"), ("config/queries/office.toml", "root = \n"),
                           ("config/asked/office.toml", "query = \n")):
            with self.subTest(name):
                self.setUp()
                self.write("config/asked/office.toml", ASKED)
                self.write(name, text)
                self.assertRegex(self.show(code=1), f"^error: .*{name}.*delete the file and run make again\n$")

    def test_the_report_shows_pictures_of_query_first_and_marks_them(self):
        self.write("config/asked/office.toml", ASKED)
        self.write_queries(num_own=20, asked=["a.jpg", "b.jpg"])
        self.assertEqual(asked_names(Site(self.site_dir)), {"a.jpg", "b.jpg"})
        page = str(query_section(Site(self.site_dir), {}, None))
        places = [page.index(f"<td>{name}") for name in ("a.jpg (of QUERY)", "b.jpg (of QUERY)", "own/0.jpg")]
        self.assertEqual(places, sorted(places))
        self.assertEqual(page.count("<tr><td>"), 14)
        self.assertIn("12 of the site&#x27;s 20 queries", page)
