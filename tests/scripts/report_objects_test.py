# SPDX-License-Identifier: Apache-2.0
"""The section of the report in which objects are drawn: what it hands to its script, and files that cannot be read."""

import base64
import io
import json
import re
from pathlib import Path

import numpy as np
from PIL import Image

import laser_site
from nightmap_eval.grid import FREE, OCCUPIED, UNKNOWN, read_grid
from nightmap_eval.laser import report_laser
from nightmap_eval.laser.report_laser import objects_section
from nightmap_eval.page.floor_map import GRAYS, cells_png
from nightmap_site.script_errors import DataError
from nightmap_site.site import Site

JOB = '[objects]\npurpose = "proposes objects"\nin.grid = "grid.yaml"\nout.objects = "objects.yaml"\n'


def data_of(section):
    """Data that the page hands to its script."""
    [text] = re.findall(r'<script type="application/json" id="objects-data">(.*?)</script>', section, re.DOTALL)
    return json.loads(text)


class ObjectsSectionTest(laser_site.LaserFolderTest):
    def setUp(self):
        super().setUp()
        profile = self.folder / "configs" / "scans" / "pipeline.toml"
        profile.write_text(profile.read_text() + JOB)
        laser_site.write_site(self.site_dir)

    def section(self):
        return str(objects_section(Site(self.site_dir, self.folder)))

    def use(self, name, content=None):
        self.write("config/site/hall.toml", f"[import]\nobjects = {json.dumps(name)}\n")
        if content is not None:
            (self.folder / name).write_bytes(content)

    def test_hands_the_grid_to_the_script(self):
        data = data_of(self.section())
        grid = data["grid"]
        self.assertEqual((grid["columns"], grid["rows"], grid["resolution_m"]), (60, 40, 0.1))
        self.assertEqual((grid["origin_x_m"], grid["origin_y_m"], grid["origin_yaw_rad"]), (-3, -2, 0))
        self.assertEqual((data["max_size_m"], data["files"]), (4.0, []))
        picture = Image.open(io.BytesIO(base64.b64decode(grid["png"].removeprefix("data:image/png;base64,"))))
        cells = read_grid(self.site_dir / "grid" / "map.yaml").cells
        np.testing.assert_array_equal(np.asarray(picture.convert("L")) == GRAYS[OCCUPIED], cells[::-1] == OCCUPIED)

    def test_each_state_of_a_cell_has_its_gray_from_the_top_row_on(self):
        picture = Image.open(io.BytesIO(cells_png(np.array([[FREE, OCCUPIED], [UNKNOWN, FREE]], np.uint8))))
        np.testing.assert_array_equal(np.asarray(picture.convert("L")), [[200, 255], [255, 32]])

    def test_the_script_is_whole_and_loads_nothing(self):
        section = self.section()
        [script] = re.findall(r"<script>(.*?)</script>", section, re.DOTALL)
        for name in report_laser.PARTS:
            self.assertIn((Path(report_laser.__file__).parent / name).read_text(), script)
        for word in ("fetch(", "XMLHttpRequest", "import(", "innerHTML", "eval("):
            self.assertNotIn(word, script)
        self.assertNotRegex(section.replace("http://www.w3.org/2000/svg", ""), r"https?:|<link|src=")
        self.assertEqual(self.section(), section)

    def test_names_end_no_script(self):
        text = '  - name: "</script><script>alert(1)</script><!--<script>"\n'
        self.use("objects.yaml", text.encode())
        section = self.section()
        self.assertEqual(data_of(section)["files"][0]["text"], text)
        self.assertEqual((section.count("<script"), section.count("</script>")), (2, 2))
        self.assertNotIn("<!--", section)

    def test_objects_in_use_come_before_proposals(self):
        self.write("objects/objects.yaml", "proposed\n")
        self.assertEqual([file["text"] for file in data_of(self.section())["files"]], ["proposed\n"])
        self.use("mine.yaml", b"mine\n")
        self.assertEqual([(file["name"], file["text"]) for file in data_of(self.section())["files"]],
                         [("mine.yaml", "mine\n"), ("objects.yaml", "proposed\n")])  # fmt: skip

    def test_a_file_that_is_no_text_is_told_and_the_page_appears(self):
        self.use("mine.yaml", b"\xff\xfe\x00")
        section = self.section()
        self.assertIn("mine.yaml: not a text file; correct it, or name another file", section)
        self.assertEqual(data_of(section)["files"], [])

    def test_a_file_that_is_no_more_is_none(self):
        self.use("gone.yaml")
        self.assertEqual(data_of(self.section())["files"], [])

    def test_a_name_of_another_type_is_an_error(self):
        self.use("mine.yaml")
        self.write("config/site/hall.toml", "[import]\nobjects = 5\n")
        with self.assertRaisesRegex(DataError, "hall.toml: import: objects: '5' is not of type str"):
            self.section()

    def test_a_site_without_a_grid_has_no_section(self):
        (self.site_dir / "grid" / "map.yaml").unlink()
        self.assertIsNone(objects_section(Site(self.site_dir, self.folder)))

    def test_the_page_of_a_laser_has_the_section_once(self):
        self.assertEqual(self.report().count("<h2>Objects</h2>"), 1)
