# SPDX-License-Identifier: Apache-2.0
"""The copies of a site's config that frames and queries read, and the pictures of QUERY."""

import os
import re
import shlex
import shutil
import tempfile
import tomllib
import unittest
from pathlib import Path

from config_folder import CONFIG, PREVIEW, SITE, ConfigFolder
from fake_site import CHECKOUT
from nightmap_make.input_files import COUNTS
from nightmap_site.pipeline import read_pipeline

COPIES = ("site/office", "queries/office")
ASKED = "asked/office"


def rows_of(source):
    """The text of each row of a table with names in a C++ source, by name."""
    words = re.split(r'\.name = "(\w+)"', (CHECKOUT / source).read_text(encoding="utf-8"))
    return dict(zip(words[1::2], words[2::2]))


class TablesTest(unittest.TestCase):
    """Tables of the programs, and what the scripts know of their rows."""

    def test_frames_of_each_layout_of_recordings_are_counted(self):
        layouts = rows_of("pipeline/recording/layouts.cc")
        self.assertCountEqual(COUNTS, [name for name, row in layouts.items() if ".is_recording = false" not in row])
        self.assertIn("pictures", layouts)

    def test_the_file_of_each_kind_of_sensor_is_declared(self):
        declared = read_pipeline(str(CHECKOUT / "configs")).jobs["frames"].beside.values()
        files = [re.search(r'\.file = "([\w.]+)"', row)[1] for row in rows_of("pipeline/recording/signal_kinds.cc").values()]
        self.assertCountEqual(files, [name for name in declared if name.endswith(".h5")])


class SiteConfigsTest(ConfigFolder):
    def test_wrong_types_in_the_site_config(self):
        whole = SITE.splitlines(keepends=True)
        for text, word in (
            ("root = 5\n", "root must be text"), ("root = [1]\n" + "".join(whole[1:]), "root must be text"),
            ('sequence = "."\n', "written as [[sequence]]"), ("sequence = [1, 2]\n", "written as [[sequence]]"),
            ("[sequence]\nfolder = '.'\n", "written as [[sequence]]"), ("[query]\na = 1\n", "written as [[query]]"),
            (SITE + '[query]\nlayout = "pictures"\npictures = "a.jpg"\n', "must be written as [[query]]"),
            ("[[sequence]]\nfolder = 5\n", "folder of [[sequence]] must be text"),
            ("[[query]]\npictures = ['a']\n", "pictures of [[query]] must be text"),
            ("[[sequence]]\nground_truth = true\n", "ground_truth of [[sequence]] must be text"),
            ("[[signal]]\nfile = 5\n", "file of [[signal]] must be text"),
            ("a = " + "[" * 20000, "nested too deep"), (b"a = '\xff'\n", "UTF-8"), ("a = ", "not valid TOML"),
            ("a = " + "9" * 5000, "not valid TOML"),
        ):  # fmt: skip
            with self.subTest(text[:40]):
                self.write("configs/sites/office.toml", text)
                for query in ("", "data/office/rgb/1.png"):
                    said = self.refused(query=query)
                    self.assertIn("configs/sites/office.toml", said)
                    self.assertIn(word, said)

    def test_a_copy_has_the_lines_and_the_name_of_the_users_file(self):
        self.resolve()
        time_ns = self.time("site/office")
        text = "# a new first line\n" + SITE  # means the same, so nothing is stale
        self.write("configs/sites/office.toml", text)
        self.resolve()
        for copy in COPIES:
            self.assertTrue(self.text(f"{copy}.toml").startswith(text))
            self.assertTrue(self.text(f"{copy}.toml").endswith("\n# This was the text of configs/sites/office.toml\n"))
        self.assertEqual(self.time("site/office"), time_ns)
        self.write("configs/sites/office.toml", SITE.encode() + b"# B\xfcro\n")
        self.assertRegex(self.refused(), r"office\.toml: .*not UTF-8 text")

    def test_each_stage_sees_only_the_tables_that_it_takes(self):
        query = '[[query]]\nlayout = "pictures"\npictures = "asked"\n'
        signal = '[[sensor]]\nid = "imu"\n[[signal]]\nsensor = "imu"\nfile = "imu.txt"\n'
        for name in ("asked/a.png", "imu.txt"):
            self.write(f"data/office/{name}", "x")
        self.resolve()
        before = [self.time(copy) for copy in COPIES]
        self.write("configs/sites/office.toml", SITE + query)
        self.resolve()
        after = [self.time(copy) for copy in COPIES]
        self.assertEqual([new == old for new, old in zip(after, before)], [True, False])
        for copy in COPIES:
            self.assertIn(query, self.text(f"{copy}.toml"))
        self.write("configs/sites/office.toml", "hold_out_every = 5\n" + SITE + query + signal)
        self.resolve()
        self.assertEqual([self.time(copy) == old for copy, old in zip(COPIES, after)], [False, True])

    def test_query_asks_for_pictures_in_one_run(self):
        self.write("start.jpg", "pixels")
        self.write("data/office/extra/my goal.jpg", "pixels")
        self.resolve()
        self.assertEqual(self.text(f"{ASKED}.toml"), "")
        before = [self.time(name) for name in (*COPIES, ASKED)]
        self.resolve(query="start.jpg 'data/office/extra/my goal.jpg'", fov_deg="60")
        expected = [{"layout": "pictures", "pictures": path, "horizontal_fov_deg": 60.0} for path in ("../../start.jpg", "extra/my goal.jpg")]
        self.assertEqual(self.config(ASKED), {"query": expected})
        for copy in COPIES:
            self.assertEqual(self.config(copy), tomllib.loads(SITE))
        self.assertEqual([self.time(name) == old for name, old in zip((*COPIES, ASKED), before)], [True, True, False])
        self.resolve()
        self.assertEqual(self.config(ASKED), {})
        self.resolve(query="start.jpg", camera="phone", work_dir=PREVIEW)
        self.assertEqual(self.config(ASKED, PREVIEW)["query"][0]["camera"], "phone")
        self.assertEqual(self.config(ASKED), {})

    def test_the_same_question_keeps_its_time(self):
        self.write("start.jpg", "pixels")
        self.resolve(query="start.jpg")
        time_ns = self.time(ASKED)
        self.resolve(query="'start.jpg'")
        self.assertEqual(self.time(ASKED), time_ns)

    def asked_path(self):
        """Path of the picture of QUERY, from the data folder."""
        return os.path.normpath(os.path.join("office", self.config(ASKED)["query"][0]["pictures"]))

    def test_query_is_found_through_a_data_folder_that_is_a_link(self):
        picture = self.write("photos/start.jpg", "pixels")
        (self.folder / "disk").mkdir()
        (self.folder / "data").rename(self.folder / "disk/recordings")
        (self.folder / "data").symlink_to("disk/recordings")
        self.resolve(query="photos/start.jpg")
        self.assertTrue((self.folder / "data" / self.asked_path()).samefile(picture))
        self.resolve(query=str(picture))
        self.assertFalse(os.path.isabs(self.config(ASKED)["query"][0]["pictures"]))

    def test_query_is_found_from_a_data_folder_beside_the_working_folder(self):
        picture = self.write("photos/start.jpg", "pixels")
        with tempfile.TemporaryDirectory(dir=self.folder.parent) as beside:
            for folder in (Path(beside), Path(beside) / "data"):
                shutil.copytree(self.folder / "data", folder, dirs_exist_ok=True)
                self.resolve(query="photos/start.jpg", data=str(folder))
                self.assertTrue((folder / self.asked_path()).samefile(picture), self.asked_path())

    def test_a_query_whose_name_is_not_text_is_refused(self):
        for name in (b"\xff.jpg", b"a\nb.jpg"):
            with open(os.path.join(os.fsencode(self.folder), name), "wb"):
                pass
            self.assertIn("rename it", self.refused(query=shlex.quote(os.fsdecode(name))))

    def test_mistakes_in_a_query_are_refused(self):
        self.write("a.jpg", "pixels")
        for changes, message in (({"query": "nowhere.jpg"}, "QUERY: nowhere.jpg does not exist"),
                                 ({"query": "a.jpg", "fov_deg": "wide"}, "give a number of degrees"),
                                 ({"camera": "phone"}, "CAMERA and FOV_DEG describe the pictures of QUERY"),
                                 ({"query": "'a.jpg"}, "QUERY: 'a.jpg: no closing quotation")):  # fmt: skip
            with self.subTest(changes):
                self.assertIn(message, self.refused(**changes))
        self.assertFalse(os.path.exists(CONFIG))
