# SPDX-License-Identifier: Apache-2.0
"""Shared parts of the tables of recordings as people have them: a tool outside of the project writes each case, make maps it,
and the verdict is good or names the cause."""
import json
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

from accuracy import DATA
from workspace import BUILD, said_by


class MadeCases(unittest.TestCase):
    """tool: name of the program that writes a case; before: its arguments before the folder to write to."""

    tool, before = "", ()

    @classmethod
    def setUpClass(cls):
        cls.path = DATA.parent / "tools" / cls.tool
        if not cls.path.exists():
            raise unittest.SkipTest(f"{cls.path} makes the cases")
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="nightmap-cases-"))
        cls.addClassCleanup(shutil.rmtree, cls.folder)

    def write_case(self, case):
        return subprocess.run([sys.executable, self.path, *self.before, self.folder, case], check=True, stdout=subprocess.PIPE,
                              text=True).stdout  # fmt: skip

    def make(self, case, *goals, code=0):
        """Output of make."""
        if not self.site(case).exists():
            self.write_case(case)
        folders = (f"{name}={self.folder / name.lower()}" for name in ("SITES", "DATA", "MAPS"))
        return said_by(["make", "--no-print-directory", f"SITE={case}", f"BUILD={BUILD}", *folders, *goals], code=code)

    def made(self, case, *goals):
        """The checks of the verdict after these goals."""
        self.make(case, *goals)
        verdicts = [self.folder / "maps" / case / job / "verdict.json" for job in ("verdict", "check")]
        return next(json.loads(path.read_text()) for path in verdicts if path.exists())

    def site(self, case):
        return self.folder / "sites" / f"{case}.toml"

    def check_names_the_cause(self, verdict, name, word):
        self.assertNotEqual(verdict["verdict"], "good")
        item = next(item for item in verdict["checks"] if item["name"] == name)
        self.assertNotEqual(item["verdict"], "good", item)
        self.assertIn(word, item["advice"])
        return item["advice"]
