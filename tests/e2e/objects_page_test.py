# SPDX-License-Identifier: Apache-2.0
"""Objects drawn on the page of a laser map: by mouse, keyboard and fields."""
import math
import re

from driven_browser import SHIFT
from objects_page import COLUMN, COLUMN_AS_WRITTEN, PLACE_M, ObjectsPageCase

MAX_SIZE_M = 4


class ObjectsPageTest(ObjectsPageCase):
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

    def test_sides_are_as_long_as_localize_takes_them(self):
        config = self.site_dir / "config" / "scan_localize.toml"
        config.parent.mkdir(exist_ok=True)
        config.write_text("max_object_size_m = 1.5\n")
        self.open()
        self.draw((-2.5, -1), (2.5, 0))
        [found] = self.objects_after_notice("A side is 1.5 m long at most")
        self.assertEqual(found["size_x_m"], 1.5)

    def test_the_place_under_the_mouse_and_a_click_for_make_localize(self):
        self.yaml.write_text(self.yaml.read_text().replace("[-3.0, -2.0, 0]", "[-3.0, -2.0, 0.4]"))
        self.open()
        self.page.mouse("mouseMoved", self.at(-1.2, 0.7))
        said = self.page.value("document.querySelector('#objects .where').textContent")
        self.assert_near(re.findall(r"-?\d+\.\d\d", said), -1.2, 0.7)
        near = "document.querySelector('#objects .near').value"
        self.assertEqual(self.page.value(near), "")
        self.press(self.at(0.5, -1.5))
        [place] = re.findall(r'^NEAR="(.*)"$', self.page.value(near))  # as the command line takes it
        self.assert_near(place.split(","), 0.5, -1.5)
        self.draw((-2, -1), (-1, 0))  # no click
        self.assert_near(self.page.value(near)[6:-1].split(","), 0.5, -1.5)
        self.assertEqual(len(self.objects()), 1)
        self.page.press(self.at(-1.5, -0.5))  # on the object, which moves away and back
        for to in ((-1, 0.5), (-1.5, -0.5)):
            self.page.mouse("mouseMoved", self.at(*to), "left", 1)
        self.page.mouse("mouseReleased", self.at(-1.5, -0.5), "left")
        self.assert_near(self.page.value(near)[6:-1].split(","), 0.5, -1.5)

    def assert_near(self, texts, *expected):
        for text, metres in zip(texts, expected, strict=True):
            self.assertAlmostEqual(float(text), metres, delta=PLACE_M)

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

    def test_every_control_has_a_name(self):
        self.use(COLUMN)
        self.open()
        nodes = self.page.call("Accessibility.getFullAXTree")["nodes"]
        controls = [node for node in nodes if node["role"]["value"] in ("button", "textbox", "spinbutton", "application")]
        names = [node["name"]["value"] for node in controls if not node["ignored"]]
        self.assertNotIn("", names)
        for name in ("Delete column", "Name", "Angle (deg)", "Undo", "Move the map", "Download objects.yaml"):
            self.assertIn(name, names)
