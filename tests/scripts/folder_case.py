# SPDX-License-Identifier: Apache-2.0
"""Tests that work in a temporary folder, and those of scripts on a site's results in it."""

import json
import tempfile
import unittest
from functools import cached_property
from pathlib import Path

import fake_site


class FolderTest(unittest.TestCase):
    @cached_property
    def folder(self):
        """The test's own; it is made at its first use."""
        return Path(self.enterContext(tempfile.TemporaryDirectory()))

    def write(self, name, content):
        path = self.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return path

    def replace(self, name, old, new):
        path = self.folder / name
        text = path.read_text()
        self.assertIn(old, text)
        return self.write(name, text.replace(old, new))

    def check_failed(self, result, said, code=1):
        self.assertEqual(result.returncode, code, result.stderr)
        self.assertIn(said, result.stderr)


class SiteFolderTest(FolderTest):
    SITE = "office"

    @cached_property
    def site_dir(self):
        return self.folder / "maps" / self.SITE

    def write(self, name, content):
        return super().write(self.site_dir / name, content)

    def replace(self, name, old, new):
        return super().replace(self.site_dir / name, old, new)

    def run_script(self, script, out, *more):
        return fake_site.run(script, "--site-dir", self.site_dir, "--data", self.folder, "--out", self.site_dir / out, *more)

    def written(self, script, out, *more):
        """Text that a script writes; it must succeed."""
        result = self.run_script(script, out, *more)
        self.assertEqual(result.returncode, 0, result.stderr)
        return (self.site_dir / out).read_text()

    def metrics(self):
        return json.loads(self.written("evaluate.py", "evaluate/metrics.json"))

    def report(self):
        return self.written("report.py", "report/index.html")

    def check_refused(self, script, message):
        result = self.run_script(script, "x")
        self.assertEqual(result.returncode, 1)
        self.assertRegex(result.stderr, message)
