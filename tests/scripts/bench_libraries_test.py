# SPDX-License-Identifier: Apache-2.0
"""bench_libraries.py: the table goes between the markers, and a failed run leaves the page alone."""

import os
import subprocess
import tempfile
import unittest
from pathlib import Path

SCRIPT = Path(__file__).resolve().parents[1] / "bench" / "bench_libraries.py"
PAGE = "before\n<!-- bench_libraries:begin -->\nold\n<!-- bench_libraries:end -->\nafter\n"


class BenchLibrariesTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.page = self.folder / "page.md"
        self.page.write_text(PAGE)
        self.program("ninja", "exit 0")
        self.program("bench_libraries", 'echo "| $1 | $2 |"')

    def program(self, name, body):
        path = self.folder / name
        path.write_text(f"#!/bin/sh\n{body}\n")
        path.chmod(0o755)

    def run_script(self):
        environment = {**os.environ, "PATH": f"{self.folder}:{os.environ['PATH']}"}
        return subprocess.run([SCRIPT, "some/maps/office", "--data", "recordings", "--build", self.folder, "--page", self.page],
                              env=environment, capture_output=True, text=True)  # fmt: skip

    def test_the_table_replaces_the_old_one(self):
        self.assertEqual(self.run_script().returncode, 0)
        text = self.page.read_text()
        self.assertIn("<!-- bench_libraries:begin -->\n| recordings | some/maps/office |\n", text)
        self.assertTrue(text.endswith("\n<!-- bench_libraries:end -->\nafter\n"))
        self.assertNotIn("old", text)
        self.assertTrue(text.startswith("before\n"))

    def test_a_failed_build_or_run_leaves_the_page(self):
        for program in ("ninja", "bench_libraries"):
            self.program(program, "exit 1")
            result = self.run_script()
            self.assertEqual(result.returncode, 1)
            self.assertIn(program, result.stderr)
            self.assertEqual(self.page.read_text(), PAGE)

    def test_a_page_without_markers_is_refused(self):
        self.page.write_text("no markers\n")
        result = self.run_script()
        self.assertEqual(result.returncode, 1)
        self.assertIn("no markers", result.stderr)
        self.assertEqual(self.page.read_text(), "no markers\n")


if __name__ == "__main__":
    unittest.main()
