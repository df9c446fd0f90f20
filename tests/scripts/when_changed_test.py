# SPDX-License-Identifier: Apache-2.0
"""A test program runs until it passes, and again when it, the configs or what tests obey have changed."""
import os
import pathlib
import re
import subprocess
import sys

from folder_case import FolderTest


SCRIPT = pathlib.Path(__file__).resolve().parents[1] / "when_changed.py"


class WhenChangedTest(FolderTest):
    def setUp(self):
        self.config = self.folder / "configs/dense/default/grid.toml"
        self.config.parent.mkdir(parents=True)
        self.config.write_text("a = 1\n")
        self.program = self.folder / "test_grid"
        self.write_program(0)

    def write_program(self, code):
        self.program.write_text(f"#!/bin/sh\necho ran >> runs\nexit {code}\n")
        self.program.chmod(0o755)

    def runs(self, code=0, **variables):
        """Whether the program ran."""
        environment = {name: value for name, value in os.environ.items() if name not in ("NIGHTMAP_NIGHTLY", "NIGHTMAP_DATA")}
        log = self.folder / "runs"
        log.unlink(missing_ok=True)
        result = subprocess.run([sys.executable, SCRIPT, self.program], cwd=self.folder, env=environment | variables,
                                capture_output=True, text=True)  # fmt: skip
        self.assertEqual(result.returncode, code, result.stderr)
        self.assertEqual("nothing changed" in result.stdout, not log.exists())
        return log.exists()

    def test_what_passed_does_not_run_again(self):
        self.assertTrue(self.runs())
        self.assertFalse(self.runs())

    def test_what_failed_runs_again(self):
        self.write_program(3)
        self.assertTrue(self.runs(code=3))
        self.assertTrue(self.runs(code=3))

    def test_a_failure_forgets_that_it_passed(self):
        self.runs()
        self.assertTrue(self.runs(NIGHTMAP_DATA="elsewhere"))
        self.write_program(3)
        self.runs(code=3)
        self.assertTrue(self.runs(code=3))

    def test_a_change_runs_it(self):
        self.runs()
        for change in (lambda: self.write_program(0), lambda: self.config.write_text("a = 2\n"), self.config.unlink):
            change()
            self.assertTrue(self.runs())
            self.assertFalse(self.runs())
        self.assertTrue(self.runs(NIGHTMAP_DATA="elsewhere"))

    def test_what_lacked_a_recording_runs_again(self):
        self.program.write_text("#!/bin/sh\necho ran >> runs\necho data/tum is missing: set NIGHTMAP_DATA\n")
        self.assertTrue(self.runs())
        self.assertTrue(self.runs())

    def test_one_that_is_killed_fails_and_has_said_what_it_did(self):
        self.program.write_text("#!/bin/sh\necho ran >> runs\necho began\nkill -9 $$\n")
        result = subprocess.run([sys.executable, SCRIPT, self.program], cwd=self.folder, capture_output=True, text=True)
        self.assertNotEqual(result.returncode, 0)
        self.assertIn("began\n", result.stdout)
        self.assertIn("ended by signal 9", result.stdout)
        self.assertFalse(self.program.with_name("test_grid.passed").exists())

    def test_programs_read_only_the_configs_of_the_repository(self):
        tests = SCRIPT.parent
        lines = [line for pattern in ("*.cc", "*.h") for path in tests.rglob(pattern) if "bench" not in path.parts
                 for line in path.read_text(encoding="utf-8").splitlines() if not line.startswith("#include")]
        self.assertTrue([line for line in lines if '"configs/' in line])
        self.assertEqual([line for line in lines if re.search(r'"(\./)?(docs|scripts|tests|stages|pipeline|cmake)/', line)], [])

    def test_it_always_runs_at_night(self):
        self.runs()
        self.assertTrue(self.runs(NIGHTMAP_NIGHTLY="1"))
