# SPDX-License-Identifier: Apache-2.0
"""figures.py and figure_page.py: tables say what made them, commands name files that exist."""

import re
import shlex
from pathlib import Path
from unittest import mock

import fake_site
import figures
from folder_case import FolderTest
from nightmap_eval import figure_page
from nightmap_site.script_errors import DataError

PAGE = "a\n<!-- accuracy:begin -->\nold\n<!-- accuracy:end -->\nb\n"
FOLDERS = {key: Path("folder") for key in ("data", "maps", "build", "page")} | {"threads": 2}


class PageTest(FolderTest):
    def setUp(self):
        self.page = self.folder / "figures.md"

    def test_replaces_between_markers_and_says_which_programs(self):
        self.page.write_text(PAGE)
        figure_page.put_figure(self.page, "accuracy", "| new |")
        text = self.page.read_text()
        self.assertRegex(text, r"^a\n<!-- accuracy:begin -->\n\| new \|\n\nMeasured on \d{4}-\d\d-\d\d with the programs of "
                               r"commit [0-9a-f]{10}(, changed since)?\.\n<!-- accuracy:end -->\nb\n$")  # fmt: skip
        figure_page.put_figure(self.page, "accuracy", "| new |")
        self.assertEqual(self.page.read_text(), text)

    def test_no_markers_is_an_error(self):
        self.page.write_text("text")
        with self.assertRaises(DataError):
            figure_page.put_figure(self.page, "accuracy", "new")

    def test_a_cell_is_found_by_its_row_and_title(self):
        page = self.write("page.md", "<!-- t:begin -->\n| | | b |\n|---|---|---|\n| x | y | 1 |\n| x | z | 2 |\n<!-- t:end -->\n| x | y | 3 |\n")
        self.assertEqual(figure_page.read_cell(page, "t", "x | y", "b"), "1")
        self.assertIsNone(figure_page.read_cell(page, "u", "x | y", "b"))
        for asked in (("t", "x", "b"), ("t", "x | y", "c"), ("t", "y", "b")):
            with self.assertRaisesRegex(DataError, f"FIGURES={asked[0]}"):
                figure_page.read_cell(page, *asked)

    def test_changed_sources_are_said(self):
        with mock.patch.object(figure_page, "_git", lambda *words: "abc" if words[0] == "rev-parse" else " M stages/x.cc"):
            self.assertEqual(figure_page.program_version(), "commit abc, changed since")
        with mock.patch.object(figure_page, "_git", lambda *words: ""):
            self.assertIn("unknown", figure_page.program_version())


class CommandTest(FolderTest):
    def test_commands_name_scripts_and_sites_that_exist(self):
        for commands in (figures.FIGURES | figures.LONG).values():
            for command in commands:
                words = shlex.split(command.format(**FOLDERS))
                if words[0].endswith(".py"):
                    script = fake_site.CHECKOUT / ("" if "/" in words[0] else "tests/bench") / words[0]
                    self.assertTrue(script.exists(), words[0])
                for site in re.findall(r"SITE=(\w+)", command):
                    self.assertTrue((fake_site.CHECKOUT / f"configs/sites/{site}.toml").exists(), site)

    def test_the_page_has_a_place_for_every_table(self):
        pages = [fake_site.CHECKOUT / "docs" / name for name in ("figures.md", "ours_instead_of.md")]
        page = "".join(path.read_text(encoding="utf-8") for path in pages)
        for name in figures.FIGURES | figures.LONG:
            self.assertEqual(page.count(f"<!-- {name}:begin -->"), 1, name)

    def test_headlines_are_those_of_the_tables(self):
        path = fake_site.CHECKOUT / "docs/figures.md"
        page = self.write("figures.md", path.read_text(encoding="utf-8"))
        figures.put_headlines(page)
        self.assertEqual(page.read_text(), path.read_text(encoding="utf-8"))

    def test_a_failed_table_keeps_its_rows_and_the_others_are_made(self):
        page = self.write("figures.md", PAGE)
        tables = {"accuracy": ("false",), "other": ("true",)}
        with mock.patch.dict(figures.FIGURES, tables, clear=True), mock.patch.object(figures, "put_headlines"):
            self.check_failed(fake_site.run("figures.py", "--data", self.folder, "--page", page), "not measured: accuracy")
            self.assertEqual(fake_site.run("figures.py", "other", "--data", self.folder, "--page", page).returncode, 0)
            self.assertEqual(fake_site.run("figures.py", "third", "--data", self.folder).returncode, 2)
        self.assertEqual(page.read_text(), PAGE)

    def test_what_a_program_prints_is_the_table(self):
        page = self.write("figures.md", PAGE)
        page.write_text("<!-- headlines:begin --><!-- headlines:end -->" + PAGE)
        commands, headline = {"accuracy": ("printf '| | a |\\n|---|---|\\n| printed | 7 |' > accuracy",)}, ("w", "S", "accuracy", "printed", "a")
        with mock.patch.dict(figures.FIGURES, commands, clear=True), mock.patch.object(figures, "HEADLINES", (headline,)):
            self.assertEqual(fake_site.run("figures.py", "--data", self.folder, "--page", page).returncode, 0)
        self.assertIn("| printed | 7 |", page.read_text())
        self.assertIn("| [w](#s) | 7 |", page.read_text())
