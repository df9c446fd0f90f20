# SPDX-License-Identifier: Apache-2.0
"""resolve_config.py on configs, recordings and receipts that are not as they should be: a clear line, never a
traceback. (What it does with whole ones is in tests/e2e/makefile_test.py.)"""

import json
import os
import shutil
import subprocess
import tempfile
import unittest
from pathlib import Path

from fake_site import SCRIPTS

SITE = 'root = "office"\n[[sequence]]\nfolder = "."\n'
CONFIG = "maps/office/config"


class ResolveConfigTest(unittest.TestCase):
    def setUp(self):
        self.folder = Path(tempfile.mkdtemp())
        self.addCleanup(shutil.rmtree, self.folder)
        self.write("configs/default/plan.toml", 'seed = 0\nstart = ""\nfootprint_m = []\n')
        self.write("configs/sites/office.toml", SITE)
        self.write("data/office/rgb/1.png", "pixels")

    def write(self, name, content):
        path = self.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return path

    def run_script(self, *arguments):
        command = ["/usr/bin/python3", "-I", "-S", SCRIPTS / "resolve_config.py", "--site", "configs/sites/office.toml",
                   "--data", "data", "--out", CONFIG]  # fmt: skip
        return subprocess.run([*command, *arguments], cwd=self.folder, capture_output=True, text=True, timeout=20)

    def resolve(self, *arguments):
        result = self.run_script(*arguments)
        self.assertEqual(result.returncode, 0, result.stderr)
        return result.stdout.split()

    def refused(self, *arguments):
        result = self.run_script(*arguments)
        self.assertEqual(result.returncode, 2, result.stderr)
        self.assertRegex(result.stderr, "^nightmap: [^\n]*\n$")
        return result.stderr

    def recordings(self):
        self.resolve()
        return (self.folder / CONFIG / "recordings").read_text()

    def test_wrong_types_in_the_site_config(self):
        whole = SITE.splitlines(keepends=True)
        for text, word in (
            ("root = 5\n", "root must be text"), ("root = [1]\n" + "".join(whole[1:]), "root must be text"),
            ('sequence = "."\n', "written as [[sequence]]"), ("sequence = [1, 2]\n", "written as [[sequence]]"),
            ("[sequence]\nfolder = '.'\n", "written as [[sequence]]"), ("[query]\na = 1\n", "written as [[query]]"),
            ("[[sequence]]\nfolder = 5\n", "folder of [[sequence]] must be text"),
            ("[[query]]\npictures = ['a']\n", "pictures of [[query]] must be text"),
            ("[[sequence]]\nground_truth = true\n", "ground_truth of [[sequence]] must be text"),
            ("a = " + "[" * 20000, "nested too deep"), (b"a = '\xff'\n", "UTF-8"), ("a = ", "not valid TOML"),
            ("a = " + "9" * 5000, "not valid TOML"),
        ):  # fmt: skip
            with self.subTest(text[:40]):
                self.write("configs/sites/office.toml", text)
                for arguments in ((), ("--query", "data/office/rgb/1.png")):
                    said = self.refused(*arguments)
                    self.assertIn("configs/sites/office.toml", said)
                    self.assertIn(word, said)

    def test_wrong_types_in_stage_configs(self):
        for text, word in (("start = 5\n", "must be like its default"), ("start = " + "[" * 20000, "nested too deep"),
                           ("[start]\na = 1\n", "must be like its default"), ("seed = 99999999999999999999\n", "larger than any"),
                           ("footprint_m = [{a = 1}]\n", "neither a number"),
                           ("footprint_m = [[2020-01-01]]\n", "neither a number"),
                           (b"start = '\xff'\n", "UTF-8")):  # fmt: skip
            with self.subTest(text[:40]):
                path = self.write("configs/sites/office/plan.toml", text)
                said = self.refused()
                self.assertIn("configs/sites/office/plan.toml", said)
                self.assertIn(word, said)
                path.unlink()
        self.resolve("--set", "plan.footprint_m=[[1,2],[3,4]]")

    def test_wrong_values_of_make(self):
        for arguments, word in ((("--seed", "\u00b2"), "whole number"), (("--seed", "9" * 5000), "whole number"),
                                (("--set", "plan.start='a"), "SET: plan.start='a: no closing quotation"),
                                (("--query", "'a"), "QUERY: 'a: no closing quotation"),
                                (("--set", "plan.footprint_m=" + "[" * 20000), "must be like its default")):  # fmt: skip
            with self.subTest(arguments):
                self.assertIn(word, self.refused(*arguments))

    def test_links_pipes_and_names_in_a_recording_are_no_matter_here(self):
        before = self.recordings()
        office = self.folder / "data/office"
        (office / "nowhere").symlink_to("there_is_none")
        (office / "itself").symlink_to("itself")
        (office / "above").symlink_to("..")
        (office / "rgb/circle").symlink_to(".")
        (office / "rgb/other circle").symlink_to("../rgb")
        os.mkfifo(office / "pipe")
        (office / os.fsdecode(b"caf\xe9.png")).write_bytes(b"pixels")
        (office / "line\nbreak.png").write_bytes(b"pixels")
        after = self.recordings()
        self.assertNotEqual(after, before)
        self.assertEqual(self.recordings(), after)
        self.write("data/office/rgb/1.png", "other pixels")
        self.assertNotEqual(self.recordings(), after)

    def test_a_folder_that_cannot_be_read_is_noticed_and_left_to_frames(self):
        script = f"import sys, os\nsys.path.insert(0, {str(SCRIPTS)!r})\n" + (
            "import resolve_config\nscandir = os.scandir\n"
            "def refuse(path):\n    if str(path).endswith('rgb'):\n        raise PermissionError(13, 'Permission denied', path)\n"
            "    return scandir(path)\n"
            "os.scandir = refuse\nsys.exit(resolve_config.main())\n")  # fmt: skip
        before = self.recordings()
        command = ["/usr/bin/python3", "-c", script, "--site", "configs/sites/office.toml", "--data", "data", "--out", CONFIG]
        result = subprocess.run(command, cwd=self.folder, capture_output=True, text=True)
        self.assertEqual((result.returncode, result.stderr), (0, ""))
        self.assertNotEqual((self.folder / CONFIG / "recordings").read_text(), before)

    def test_a_list_of_pictures_that_is_no_text_is_left_to_frames(self):
        self.write("list.txt", b"caf\xe9.png\n\0\n")
        self.resolve("--query", "list.txt")

    def test_damaged_files_of_an_earlier_call_are_made_anew(self):
        whole = self.resolve()
        for name in ("plan.toml", "recordings"):
            path = self.folder / CONFIG / name
            text = path.read_bytes()
            path.write_bytes(b"\xff")
            self.assertEqual(self.resolve(), whole)
            self.assertEqual(path.read_bytes(), text)


if __name__ == "__main__":
    unittest.main()
