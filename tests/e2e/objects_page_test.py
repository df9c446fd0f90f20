#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Objects drawn on the page of a laser map in a browser: by mouse, keyboard and fields, to a file and back."""
import json
import math
import pathlib
import sys
import tempfile
import time
import unittest
from unittest import mock

from driven_browser import CONTROL, SHIFT, DrivenPage

sys.path.append(str(pathlib.Path(__file__).resolve().parents[1] / "scripts"))

import fake_site  # noqa: E402
import laser_site  # noqa: E402
from nightmap_eval.grid import read_grid  # noqa: E402

PLACE_M = 0.03  # the mouse is on whole pixels, of about 1 cm each
MAX_SIZE_M = 4
KEYS = ("x_m", "y_m", "size_x_m", "size_y_m", "angle_deg")
COLUMN = 'format: nightmap objects\nversion: 1\nobjects:\n  - name: "column"\n    x_m: 1\n    y_m: -0.5\n    size_x_m: 1\n' \
         "    size_y_m: 0.6\n    angle_deg: 0\n    distinctiveness: 0.83\n"  # fmt: skip
COLUMN_AS_WRITTEN = """\
format: nightmap objects
version: 1
objects:
  - name: "column"
    x_m: 1.000
    y_m: -0.500
    size_x_m: 1.000
    size_y_m: 0.600
    angle_deg: 0.000
    distinctiveness: 0.830
"""


def objects_in(text):
    """Objects of a file that the page wrote, each as a dictionary."""
    objects = []
    for line in text.splitlines()[3:]:
        key, value = line.removeprefix("  - ").strip().split(": ", 1)
        if key == "name":
            objects.append({})
        objects[-1][key] = json.loads(value)
    return objects


class ObjectsPageTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name)
        self.site_dir = self.root / "maps" / "hall"
        laser_site.write_configs(self.root / "configs")
        laser_site.write_site(self.site_dir, truth=False)
        self.yaml = self.site_dir / "grid" / "map.yaml"
        self.given = None

    def use(self, text):
        """Makes a file the objects in use."""
        self.given = self.root / "objects.yaml"
        self.given.write_text(text, encoding="utf-8")
        copy = self.site_dir / "config" / "site" / "hall.toml"
        copy.parent.mkdir(exist_ok=True)
        copy.write_text('[import]\nobjects = "objects.yaml"\n')

    def open(self):
        out = self.site_dir / "report" / "index.html"
        with mock.patch("nightmap_site.site.CONFIGS", self.root / "configs"):
            result = fake_site.run("report.py", "--site-dir", self.site_dir, "--data", self.root, "--out", out)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.page = DrivenPage(self, out)
        self.page.click("details:has(#objects) > summary")
        self.page.middle_of("#objects svg")
        self.grid = read_grid(self.yaml)

    def at(self, x_m, y_m):
        """Pixels of a point of the map, by its cell in the picture of the grid."""
        x, y = x_m - self.grid.origin_x_m, y_m - self.grid.origin_y_m
        cos, sin = math.cos(self.grid.origin_yaw_rad), math.sin(self.grid.origin_yaw_rad)
        column, row = (cos * x + sin * y) / self.grid.resolution_m, (cos * y - sin * x) / self.grid.resolution_m
        return self.page.value(f"""(() => {{ const image = document.querySelector("#objects image");
            const point = new DOMPoint({column}, {self.grid.cells.shape[0] - row}).matrixTransform(image.getScreenCTM());
            return [point.x, point.y]; }})()""")

    def draw(self, start, end):
        self.page.drag(self.at(*start), self.at(*end))

    def handle(self, name):
        return self.page.middle_of(f"#objects [data-handle='{name}']")

    def downloaded(self):
        """Text of the file that the page downloads. A browser without a person refuses after ten."""
        path = pathlib.Path(self.page.downloads) / "objects.yaml"
        path.unlink(missing_ok=True)
        self.page.click("#objects .download")
        for _ in range(200):
            if path.exists():
                return path.read_text(encoding="utf-8")
            time.sleep(0.05)
        return self.fail("no file was downloaded")

    def text(self):
        """The same without a file."""
        self.page.value("[URL.made, HTMLAnchorElement.prototype.clicked] = [URL.createObjectURL, HTMLAnchorElement.prototype.click];"
                        "URL.createObjectURL = (blob) => { URL.blob = blob; return ''; }; HTMLAnchorElement.prototype.click = () => {};")  # fmt: skip
        self.page.click("#objects .download")
        return self.page.value("[URL.createObjectURL, HTMLAnchorElement.prototype.click] = [URL.made, HTMLAnchorElement.prototype.clicked];"
                               "URL.blob.text()")  # fmt: skip

    def objects(self):
        return objects_in(self.text())

    def notice(self):
        return self.page.value("document.querySelector('#objects .notice').textContent")

    def field(self, index, key):
        return f"#objects fieldset:nth-child({index + 1}) .{key} input"

    def undo(self):
        self.page.key("z", CONTROL)

    def open_file(self, text, name="other.yaml"):
        path = self.root / name
        path.write_text(text, encoding="utf-8")
        self.page.choose_file("#objects input[type=file]", path)
        self.page.wait(f"document.querySelector('#objects .notice').textContent.includes({json.dumps(name)})")
        return self.notice()

    def assert_place(self, found, *expected, tolerance=PLACE_M):
        for key, value in zip(KEYS, expected):
            self.assertAlmostEqual(found[key], value, delta=1.5 if key == "angle_deg" else tolerance, msg=f"{key} of {found}")

    def test_a_rectangle_is_where_it_was_drawn(self):
        self.open()
        self.draw_two()

    def test_a_rectangle_is_where_it_was_drawn_on_a_grid_whose_axes_are_not_those_of_the_map(self):
        self.yaml.write_text(self.yaml.read_text().replace("[-3.0, -2.0, 0]", "[-3.0, -2.0, 0.4]"))
        self.open()
        self.draw_two()

    def draw_two(self):
        self.draw((-2, -1), (-0.8, 0.5))
        self.draw((2, 1), (1, 0.2))  # towards the other corner
        first, second = self.objects()
        self.assert_place(first, -1.4, -0.25, 1.2, 1.5, 0)
        self.assert_place(second, 1.5, 0.6, 1, 0.8, 0)
        self.assertEqual([first["name"], second["name"]], ["object 1", "object 2"])

    def test_a_rectangle_that_is_too_large_is_cut_and_the_page_says_so(self):
        self.open()
        self.draw((-2.5, -1), (2.5, 0))
        [found] = self.objects_after_notice("A side is 4 m long at most")
        self.assert_place(found, -0.5, -0.5, MAX_SIZE_M, 1, 0)
        self.assertEqual(found["size_x_m"], MAX_SIZE_M)
        self.page.type_into(self.field(0, "size_y_m"), "9")
        [found] = self.objects_after_notice("A side is 4 m long at most")
        self.assertEqual(found["size_y_m"], MAX_SIZE_M)
        said = self.open_file(COLUMN.replace("size_x_m: 1", "size_x_m: 4.5"))
        self.assertIn('made smaller: "column"', said)
        self.assertEqual(self.objects()[0]["size_x_m"], MAX_SIZE_M)

    def objects_after_notice(self, said):
        self.assertIn(said, self.notice())
        return self.objects()

    def test_a_file_that_was_downloaded_opens_as_the_same_objects(self):
        self.open()
        self.draw((-2, -1), (-0.8, 0.5))
        self.page.drag(self.handle("turn"), self.at(-1, 1))
        self.page.type_into(self.field(0, "name"), 'a "door" \\ <b>, # Tür')
        self.draw((1, 0), (2, 1))
        text = self.downloaded()
        self.page.click("#objects fieldset:nth-child(1) button")
        self.page.click("#objects fieldset:nth-child(1) button")
        self.assertEqual(self.text(), "format: nightmap objects\nversion: 1\nobjects: []\n")
        self.assertIn("2 objects", self.open_file(text))
        self.assertEqual(self.text(), text)
        self.assertRegex(text, r"x_m: -1\.\d{3}\n")
        dropped = self.root / "dropped.yaml"
        dropped.write_text(COLUMN)
        self.page.drop_file(self.at(0, 0), dropped)
        self.page.wait("document.querySelector('#objects .notice').textContent.includes('dropped.yaml: 1 ')")
        self.assertEqual(self.objects()[0]["name"], "column")
        self.page.click("#objects .undo")
        self.assertEqual(self.text(), text)

    def test_the_mouse_moves_turns_and_resizes(self):
        self.use(COLUMN)
        self.open()
        self.page.drag(self.at(1.2, -0.6), self.at(0.2, 0.4))
        self.assert_place(self.objects()[0], 0, 0.5, 1, 0.6, 0)
        self.page.drag(self.handle("turn"), self.at(0, 1.5))
        self.assert_place(self.objects()[0], 0, 0.5, 1, 0.6, 90)
        self.page.drag(self.handle(2), self.at(-1, 1.4))  # of its own axes; turned it is the upper left one
        self.assert_place(self.objects()[0], -0.35, 0.7, 1.4, 1.3, 90)
        self.page.drag(self.handle("turn"), self.at(1, 1.9), modifiers=SHIFT)
        self.assertEqual(self.objects()[0]["angle_deg"], 45)
        for expected in (90, 90, 0, 0):
            self.undo()
            self.assertAlmostEqual(self.objects()[0]["angle_deg"], expected, delta=1.5)
        self.assertEqual(self.text(), COLUMN_AS_WRITTEN)
        self.assertTrue(self.page.value("document.querySelector('#objects .undo').disabled"))

    def test_what_was_measured_of_a_place_is_forgotten_when_it_moves(self):
        self.use(COLUMN)
        self.open()
        self.page.type_into(self.field(0, "name"), "pillar")
        self.assertEqual(self.objects()[0]["distinctiveness"], 0.83)
        self.page.type_into(self.field(0, "x_m"), "1.5")
        self.assertNotIn("distinctiveness", self.objects()[0])
        self.undo()
        self.assertEqual(self.objects()[0]["distinctiveness"], 0.83)

    def test_names_are_unique_and_never_empty(self):
        self.use(COLUMN)
        self.open()
        self.draw((-2, -1), (-1, 0))
        self.page.type_into(self.field(1, "name"), "column")
        self.assertIn('There is an object "column" already', self.notice())
        self.page.type_into(self.field(0, "name"), "")
        self.assertEqual([found["name"] for found in self.objects()], ["object 3", "object 2"])
        self.undo()
        self.assertEqual([found["name"] for found in self.objects()], ["column", "object 2"])

    def test_fields_set_numbers_and_refuse_what_is_none(self):
        self.use(COLUMN)
        self.open()
        for key, text in (("x_m", "0.25"), ("y_m", "-1"), ("size_x_m", "0.4"), ("size_y_m", "2"), ("angle_deg", "270")):
            self.page.type_into(self.field(0, key), text)
        before = self.text()
        self.assert_place(self.objects()[0], 0.25, -1, 0.4, 2, -90, tolerance=0)
        for key, text, said in (("size_x_m", "0", "must be above 0"), ("size_y_m", "-1", "must be above 0"),
                                ("x_m", "", "must be a number"), ("y_m", "1e300", "must be a number")):  # fmt: skip
            self.page.type_into(self.field(0, key), text)
            self.assertIn(said, self.notice())
        self.assertEqual(self.text(), before)

    def test_the_keyboard_deletes_and_brings_back(self):
        self.use(COLUMN)
        self.open()
        self.draw((-2, -1), (-1, 0))
        both = self.text()
        self.press(self.at(1.2, -0.6))
        self.page.key("Delete")
        self.assertEqual([found["name"] for found in self.objects()], ["object 2"])
        self.undo()
        self.assertEqual(self.text(), both)
        self.press(self.at(0, 1.5))  # on empty space: nothing is selected
        self.page.key("Delete")
        self.assertEqual(self.text(), both)
        self.page.click(self.field(0, "name"))
        self.page.key("Delete")  # of the text in the field
        self.assertEqual(len(self.objects()), 2)
        self.page.press(self.at(1.2, -0.6))
        self.page.mouse("mouseMoved", self.at(0, 0), "left", 1)
        self.page.key("Escape")
        self.page.mouse("mouseReleased", self.at(0, 0), "left")
        self.assertEqual(self.text(), both)

    def press(self, at):
        self.page.press(at)
        self.page.mouse("mouseReleased", at, "left")

    def test_wheel_and_drag_change_the_view_alone(self):
        self.use(COLUMN)
        self.open()
        before, corner, anchor = self.text(), self.at(0, 0), self.at(1, 1)
        self.page.mouse("mouseWheel", anchor, deltaX=0, deltaY=-400)
        self.assertGreater(math.dist(self.at(0, 0), self.at(1, 1)), 1.5 * math.dist(corner, anchor))
        self.assertLess(math.dist(self.at(1, 1), anchor), 2)  # what is below the mouse stays there
        for button in ("right", "middle"):
            start = self.at(1, 1)
            self.page.drag(start, [start[0] + 50, start[1] + 30], button)
            self.assertLess(math.dist(self.at(1, 1), [start[0] + 50, start[1] + 30]), 2)
        self.page.click("#objects .pan")
        start = self.at(1, 1)
        self.page.drag(start, [start[0] - 40, start[1]])
        self.assertLess(math.dist(self.at(1, 1), [start[0] - 40, start[1]]), 2)
        self.assertEqual(self.text(), before)
        self.page.click("#objects .pan")
        self.draw((0.5, 0.5), (1.5, 1.1))
        self.assert_place(self.objects()[1], 1, 0.8, 1, 0.6, 0)
        self.page.click("#objects .whole")
        self.assertLess(math.dist(self.at(1, 1), anchor), 2)

    def test_a_file_with_a_mistake_is_told_and_nothing_is_lost(self):
        self.use(COLUMN)
        self.open()
        self.draw((-2, -1), (-1, 0))
        before = self.text()
        item = COLUMN[COLUMN.index("  - name"):]
        for old, new, said in (
            ("angle_deg: 0", "angle: 0", 'line 9: unknown key "angle"'),
            ("    y_m: -0.5\n", "", 'line 4: object "column" has no key "y_m"'),
            ("y_m: -0.5", "y_m: .nan", 'line 4: y_m of object "column" is ".nan", no finite number'),
            ("y_m: -0.5", "y_m: 1e999", "no finite number"),
            ("y_m: -0.5", "y_m:", "no finite number"),
            ("y_m: -0.5", "y_m: 1e9", "beyond 1000000"),
            ("size_x_m: 1", "size_x_m: 0", "size_x_m of object \"column\" is 0"),
            ("size_x_m: 1", "size_x_m: -2", "size_x_m of object \"column\" is -2"),
            ("0.83", "1.5", "not within 0 and 1"),
            (item, item + item, 'line 11: a second object "column"'),
            ("    x_m: 1\n", "    x_m: 1\n    x_m: 2\n", 'line 6: "x_m" is given twice'),
            ("    x_m: 1\n", "     x_m: 1\n", "line 5: \"x_m\" is indented by 5 spaces, the object's first key by 4"),
            ("    x_m: 1\n", "\tx_m: 1\n", "line 5: a tab"),
            ("    x_m: 1\n", "    x_m 1\n", 'line 5: neither "key: value" nor a comment'),
            ('"column"', '"column', "line 4: the quotation marks do not close"),
            ('"column"', '""', "line 4: the object's name is empty"),
            ("version: 1", "version: 2", 'version is "2"; this page reads version 1'),
            ("version: 1\n", "", 'no key "version"'),
            ("nightmap objects", "nightmap floors", 'format is "nightmap floors"'),
            ("objects:\n", "things:\n", 'line 3: unknown key "things"'),
            (COLUMN, "", 'no key "format"'),
            (COLUMN, "\x00\x01\x02", "line 1: a tab or another control character"),
        ):  # fmt: skip
            with self.subTest(said):
                self.assertIn(old, COLUMN)
                self.assertIn(f"other.yaml: {said}" if said[:4] in ("line", "no k") and "no finite" not in said else said,
                              self.open_file(COLUMN.replace(old, new)))
                self.page.value("document.querySelector('#objects .notice').textContent = ''")
        self.assertEqual(self.text(), before)

    def test_comments_quotes_and_line_ends_of_a_hand_written_file_are_read(self):
        self.open()
        text = COLUMN.replace("    x_m: 1\n", "    x_m: 1.0   # centre\n\n  # a line of its own\n").replace('"column"', "the 'old' column # 3")
        self.open_file("\ufeff" + text.replace("\n", "\r\n"), "hand.yaml")
        [found] = self.objects()
        self.assertEqual((found["name"], found["x_m"]), ("the 'old' column", 1))
        self.open_file(COLUMN.replace('"column"', "'it''s # 1'"), "quoted.yaml")
        self.assertEqual(self.objects()[0]["name"], "it's # 1")

    def test_objects_in_use_and_proposals_can_both_be_opened(self):
        configs = self.root / "configs" / "scans" / "pipeline.toml"
        configs.write_text(configs.read_text() + '[objects]\npurpose = "proposes"\nin.grid = "grid.yaml"\nout.objects = "objects.yaml"\n')
        (self.site_dir / "objects").mkdir()
        (self.site_dir / "objects" / "objects.yaml").write_text(COLUMN.replace('"column"', '"proposed </script>"'))
        self.use(COLUMN)
        self.open()
        self.assertEqual(self.objects()[0]["name"], "column")
        self.page.click("#objects .files button:nth-child(2)")
        self.assertEqual(self.objects()[0]["name"], "proposed </script>")

    def test_every_control_has_a_name(self):
        self.use(COLUMN)
        self.open()
        nodes = self.page.call("Accessibility.getFullAXTree")["nodes"]
        controls = [node for node in nodes if node["role"]["value"] in ("button", "textbox", "spinbutton", "application")]
        names = [node["name"]["value"] for node in controls if not node["ignored"]]
        self.assertNotIn("", names)
        for name in ("Delete column", "Name", "Angle (deg)", "Undo", "Move the map", "Download objects.yaml"):
            self.assertIn(name, names)


if __name__ == "__main__":
    unittest.main()
