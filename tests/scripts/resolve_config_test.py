# SPDX-License-Identifier: Apache-2.0
"""resolve_config.py on configs, recordings and receipts that are not as they should be: a clear line, never a
traceback. (What it does with whole ones is in tests/e2e/makefile_test.py.)"""

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

    def times(self):
        """Of the site config of each stage."""
        return {path.parent.name: path.stat().st_mtime_ns for path in (self.folder / CONFIG).glob("*/office.toml")}

    def test_each_stage_sees_only_the_tables_that_it_takes(self):
        query = '[[query]]\nlayout = "pictures"\npictures = "asked"\n'
        signal = '[[sensor]]\nid = "imu"\n[[signal]]\nsensor = "imu"\nfile = "imu.txt"\n'
        for name in ("asked/a.png", "imu.txt"):
            self.write(f"data/office/{name}", "x")
        self.resolve()
        before = self.times()
        self.write("configs/sites/office.toml", SITE + query)
        self.resolve()
        after = self.times()
        self.assertEqual(after["site"], before["site"])
        self.assertNotEqual(after["queries"], before["queries"])
        for part in ("site", "queries"):
            self.assertIn(query, (self.folder / CONFIG / part / "office.toml").read_text())
        self.write("configs/sites/office.toml", "hold_out_every = 5\n" + SITE + query + signal)
        self.resolve()
        last = self.times()
        self.assertNotEqual(last["site"], after["site"])
        self.assertEqual(last["queries"], after["queries"])
        self.resolve("--query", "data/office/rgb/1.png")
        self.assertEqual(self.times()["site"], last["site"])
        self.assertNotIn("rgb/1.png", (self.folder / CONFIG / "site/office.toml").read_text())

    def test_pictures_and_recordings_have_times_of_their_own(self):
        self.write("asked.png", "x")
        names = ("--query", "asked.png")
        self.assertEqual(self.resolve(*names), [f"recordings={CONFIG}/recordings", f"pictures={CONFIG}/pictures"])
        before = {name: (self.folder / CONFIG / name).read_text() for name in ("recordings", "pictures")}
        self.write("asked.png", "another")
        self.resolve(*names)
        self.assertEqual((self.folder / CONFIG / "recordings").read_text(), before["recordings"])
        self.assertNotEqual((self.folder / CONFIG / "pictures").read_text(), before["pictures"])

    def test_without_recordings_none_is_looked_at(self):
        self.write("asked.png", "x")
        self.resolve()
        shutil.rmtree(self.folder / "data/office")
        self.assertIn("data/office does not exist", self.refused())
        self.assertEqual(self.resolve("--no-recordings", "--query", "asked.png"), [f"pictures={CONFIG}/pictures"])

    def test_a_log_of_signals_is_an_input(self):
        self.write("configs/sites/office.toml", 'root = "office"\n[[signal]]\nfile = "scans.log"\n')
        self.assertIn("scans.log does not exist", self.refused())
        self.write("data/office/scans.log", "x")
        before = self.recordings()
        self.write("data/office/unused.log", "x")
        self.assertEqual(self.recordings(), before)
        self.write("data/office/scans.log", "more")
        self.assertNotEqual(self.recordings(), before)
        self.write("configs/sites/office.toml", "[[signal]]\nfile = 5\n")
        self.assertIn("file of [[signal]] must be text", self.refused())

    def test_a_file_of_the_same_size_with_the_old_time_is_noticed(self):
        path = self.folder / "data/office/rgb/1.png"
        for name, files in (("recordings", ()), ("pictures", ("--query", "data/office/rgb/1.png"))):
            self.resolve(*files)
            before, status = (self.folder / CONFIG / name).read_text(), path.stat()
            path.write_text("sixels" if name == "pictures" else "PIXELS")
            os.utime(path, ns=(status.st_atime_ns, status.st_mtime_ns))
            self.assertEqual((path.stat().st_size, path.stat().st_mtime_ns), (status.st_size, status.st_mtime_ns))
            self.resolve(*files)
            self.assertNotEqual((self.folder / CONFIG / name).read_text(), before)

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
