# SPDX-License-Identifier: Apache-2.0
"""Two runs that write one file: the files that they leave, and what becomes of the temporaries of a killed one."""

import os
import signal
import subprocess
import sys
from pathlib import Path

from folder_case import FolderTest
from nightmap_eval.artifacts import WritingFolder, write_atomic
from nightmap_site.script_errors import DataError

SCRIPTS = Path(__file__).resolve().parents[2] / "scripts"
WRITER = """
import sys, time
from nightmap_eval.artifacts import WritingFolder
with WritingFolder(sys.argv[1]) as folder:
    (folder / "half.txt").write_text("half a fi")
    print("ready", flush=True)
    time.sleep(600)
"""


class WritingFolderTest(FolderTest):
    def names(self):
        return sorted(path.name for path in self.folder.iterdir())

    def test_write_atomic_leaves_the_file_alone(self):
        write_atomic(self.folder / "a.txt", "old")
        write_atomic(self.folder / "a.txt", b"new")
        self.assertEqual((self.folder / "a.txt").read_text(), "new")
        self.assertEqual(self.names(), ["a.txt"])

    def test_write_atomic_replaces_plain_files_only(self):
        os.mkfifo(self.folder / "fifo")
        for path in (self.folder / "fifo", Path("/dev/null"), self.folder):
            with self.assertRaisesRegex(DataError, f"{path}: is no plain file"):
                write_atomic(path, "new")
        self.assertEqual(self.names(), ["fifo"])

    def test_two_runs_have_two_folders(self):
        with WritingFolder(self.folder) as first, WritingFolder(self.folder) as second:
            self.assertNotEqual(first, second)
            self.assertTrue(first.is_dir())
        self.assertEqual(self.names(), [])

    def test_the_folder_of_a_living_run_stays_and_that_of_a_killed_one_goes(self):
        writer = subprocess.Popen([sys.executable, "-c", WRITER, self.folder], stdout=subprocess.PIPE, text=True,
                                  env=os.environ | {"PYTHONPATH": str(SCRIPTS)})
        try:
            self.assertEqual(writer.stdout.readline(), "ready\n")
            write_atomic(self.folder / "a.txt", "a")
            (left,) = self.folder.glob(".writing.*/half.txt")
            self.assertEqual(left.read_text(), "half a fi")
        finally:
            writer.send_signal(signal.SIGKILL)
            writer.communicate()
        self.assertTrue(left.exists())
        other_host = self.folder / ".writing.another-host.abcdef"
        other_host.mkdir()
        write_atomic(self.folder / "a.txt", "a")
        self.assertEqual(self.names(), [other_host.name, "a.txt"])
