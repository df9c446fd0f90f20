# SPDX-License-Identifier: Apache-2.0
"""objects.yaml as the page of a laser map writes and opens it: round trip, mistakes in a file, files of the site."""
import os
import re
import subprocess
import tomllib

from objects_page import COLUMN, ObjectsPageCase, fake_site


class ObjectsFileTest(ObjectsPageCase):
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
        dropped = self.folder / "dropped.yaml"
        dropped.write_text(COLUMN)
        self.page.drop_file(self.at(0, 0), dropped)
        self.page.wait("document.querySelector('#objects .notice').textContent.includes('dropped.yaml: 1 ')")
        self.assertEqual(self.objects()[0]["name"], "column")
        self.page.click("#objects .undo")
        self.assertEqual(self.text(), text)

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
        text = COLUMN.replace('"column"', "the 'old' column # 3")
        text = text.replace("    x_m: 1\n", "    x_m: 1.0   # centre\n\n  # a line of its own\n")
        self.open_file("\ufeff" + text.replace("\n", "\r\n"), "hand.yaml")
        [found] = self.objects()
        self.assertEqual((found["name"], found["x_m"]), ("the 'old' column", 1))
        self.open_file(COLUMN.replace('"column"', "'it''s # 1'"), "quoted.yaml")
        self.assertEqual(self.objects()[0]["name"], "it's # 1")

    def test_the_page_says_the_command_that_gives_a_file_to_the_next_make(self):
        self.open()
        self.draw((-2, -1), (-1, 0))
        text = self.text()
        self.assertIn("The command above", self.notice())
        said = self.page.value("[...document.querySelectorAll('code')].map((code) => code.textContent).join('\\n')")
        [command] = re.findall(r"^make use-objects SITE=hall OBJECTS=(\S+)$", said, re.MULTILINE)
        self.assertEqual(command, "~/Downloads/objects.yaml")
        for config in ('profile = "laser"\n', 'profile = "laser"\n[import]\nmap = "map.yaml"\n'):
            with self.subTest(config):
                self.assertEqual(self.use_objects(config, text, command), "hall_objects.yaml")
        self.assertEqual(self.use_objects('profile = "laser"\n[import]\nobjects = "sub/own.yaml"\n', text, command), "sub/own.yaml")

    def test_a_file_that_is_none_changes_nothing(self):
        config = 'profile = "laser"\n[import]\nobjects = "own.yaml"\n'
        for text, path, said in (("x\n", "~/Downloads/objects.yaml", "its format is not"), (COLUMN, "none.yaml", "name the file"),
                                 (COLUMN, "", "make use-objects SITE=")):
            result = self.run_use_objects(config, text, path)
            self.assertNotEqual(result.returncode, 0)
            self.assertIn(said, result.stderr)
            self.assertFalse((self.folder / "own.yaml").exists())
        inline = 'profile = "laser"\nimport = { map = "map.yaml" }\n'
        self.assertIn("by hand", self.run_use_objects(inline, COLUMN, "~/Downloads/objects.yaml").stderr)
        self.assertEqual((self.folder / "sites/hall.toml").read_text(), inline)

    def use_objects(self, config, text, path):
        """The name that the site's config has after the command; the file of that name is the one that was drawn."""
        result = self.run_use_objects(config, text, path)
        self.assertEqual(result.returncode, 0, result.stderr)
        before, after = tomllib.loads(config), tomllib.loads((self.folder / "sites/hall.toml").read_text())
        name = after["import"]["objects"]
        self.assertEqual(after, before | {"import": before.get("import", {}) | {"objects": name}})
        self.assertEqual((self.folder / name).read_text(), text)
        return name

    def run_use_objects(self, config, text, path):
        site, home = self.folder / "sites" / "hall.toml", self.folder / "home"
        for folder in (site.parent, home / "Downloads"):
            folder.mkdir(parents=True, exist_ok=True)
        site.write_text(config)
        (home / "Downloads" / "objects.yaml").write_text(text)
        command = ["make", "-C", fake_site.CHECKOUT, "use-objects", "SITE=hall", f"OBJECTS={path}", f"SITES={site.parent}",
                   f"DATA={self.folder}"]  # fmt: skip
        return subprocess.run(command, env=os.environ | {"HOME": str(home)}, capture_output=True, text=True, check=False)

    def test_objects_in_use_and_proposals_can_both_be_opened(self):
        configs = self.folder / "configs" / "scans" / "pipeline.toml"
        configs.write_text(configs.read_text() +
                           '[objects]\npurpose = "proposes"\nin.grid = "grid.yaml"\nout.objects = "objects.yaml"\n')
        (self.site_dir / "objects").mkdir()
        (self.site_dir / "objects" / "objects.yaml").write_text(COLUMN.replace('"column"', '"proposed </script>"'))
        self.use(COLUMN)
        self.open()
        self.assertEqual(self.objects()[0]["name"], "column")
        self.page.click("#objects .files button:nth-child(2)")
        self.assertEqual(self.objects()[0]["name"], "proposed </script>")
