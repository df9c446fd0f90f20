# SPDX-License-Identifier: Apache-2.0
"""The states of recordings and query pictures: each change is noticed, and nothing in a folder is a matter of a traceback."""

import os
import shutil
from unittest import mock

from config_folder import CONFIG, ConfigFolder

STAMPS = {"recordings": f"{CONFIG}/recordings", "pictures": f"{CONFIG}/pictures"}


class InputFilesTest(ConfigFolder):
    def recordings(self):
        self.resolve()
        return self.text("recordings")

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
        scandir = os.scandir

        def refuse(path):
            if str(path).endswith("rgb"):
                raise PermissionError(13, "Permission denied", path)
            return scandir(path)

        before = self.recordings()
        with mock.patch("os.scandir", refuse):
            self.assertNotEqual(self.recordings(), before)

    def test_pictures_and_recordings_have_times_of_their_own(self):
        self.write("asked.png", "x")
        self.assertEqual(self.resolve(query="asked.png"), STAMPS)
        before = {name: self.text(name) for name in STAMPS}
        self.write("asked.png", "another")
        self.resolve(query="asked.png")
        self.assertEqual(self.text("recordings"), before["recordings"])
        self.assertNotEqual(self.text("pictures"), before["pictures"])

    def test_without_recordings_none_is_looked_at(self):
        self.write("asked.png", "x")
        self.resolve()
        shutil.rmtree(self.folder / "data/office")
        self.assertIn("data/office does not exist", self.refused())
        self.assertEqual(self.resolve(reads_recordings=False, query="asked.png"), {"pictures": STAMPS["pictures"]})

    def test_a_log_of_signals_is_an_input(self):
        self.write("configs/sites/office.toml", 'root = "office"\n[[signal]]\nfile = "scans.log"\n')
        self.assertIn("scans.log does not exist", self.refused())
        self.write("data/office/scans.log", "x")
        before = self.recordings()
        self.write("data/office/unused.log", "x")
        self.assertEqual(self.recordings(), before)
        self.write("data/office/scans.log", "more")
        self.assertNotEqual(self.recordings(), before)

    def test_a_file_of_the_same_size_with_the_old_time_is_noticed(self):
        path = self.folder / "data/office/rgb/1.png"
        for name, query in (("recordings", ""), ("pictures", "data/office/rgb/1.png")):
            self.resolve(query=query)
            before, status = self.text(name), path.stat()
            path.write_text("sixels" if name == "pictures" else "PIXELS")
            os.utime(path, ns=(status.st_atime_ns, status.st_mtime_ns))
            self.assertEqual((path.stat().st_size, path.stat().st_mtime_ns), (status.st_size, status.st_mtime_ns))
            self.resolve(query=query)
            self.assertNotEqual(self.text(name), before)

    def test_a_changed_picture_of_a_query_is_noticed(self):
        """A recording that synthesize makes has only pictures at first."""
        for name in ("photos/a.jpg", "photos/b.jpg"):
            self.write(name, "pixels")
        self.write("list.txt", "# two\nphotos/a.jpg\n\n")
        for query in ("photos", "photos/a.jpg", "list.txt"):
            for is_synthetic in (False, True):
                with self.subTest(query=query, is_synthetic=is_synthetic):
                    self._check_changes(query, {"query": query, "is_synthetic": is_synthetic})

    def _check_changes(self, query, changes):
        self.assertEqual(self.resolve(**changes), STAMPS)
        before = self.text("pictures")
        self.write("other/c.jpg", "pixels")
        self.resolve(**changes)
        self.assertEqual(self.text("pictures"), before)
        with open("photos/a.jpg", "ab") as file:
            file.write(b"more")
        self.resolve(**changes)
        self.assertNotEqual(self.text("pictures"), before)
        before = self.text("pictures")
        cameras = self.write("cameras.csv" if query == "list.txt" else "photos/cameras.csv", "picture\n")
        self.resolve(**changes)
        self.assertNotEqual(self.text("pictures"), before)
        cameras.unlink()

    def test_a_list_of_pictures_that_is_no_text_is_left_to_queries(self):
        self.write("list.txt", b"caf\xe9.png\n\0\n")
        self.assertEqual(self.resolve(query="list.txt"), STAMPS)

    def test_a_damaged_stamp_is_made_anew(self):
        whole = self.recordings()
        self.write(STAMPS["recordings"], b"\xff")
        self.assertEqual(self.recordings(), whole)
