# SPDX-License-Identifier: Apache-2.0
"""The Makefile without any stage program."""
import os
import pathlib
import re
import shutil
import subprocess
import tempfile
import unittest

from workspace import PIPELINE, REPOSITORY, environment

FRESH_MACHINE = ("bash", "make", "git", "sed", "expand", "nproc")


class FreshMachineTest(unittest.TestCase):
    def test_front_page_and_first_commands_need_only_make(self):
        with tempfile.TemporaryDirectory() as folder:
            for tool in FRESH_MACHINE:
                os.symlink(shutil.which(tool), os.path.join(folder, tool))
            for goals in ([], ["help"], ["-n", "deps"], ["-n", "build"]):
                result = subprocess.run(["make", "PYTHON=/nonexistent", *goals], cwd=REPOSITORY, text=True,
                                        env=environment() | {"PATH": folder}, capture_output=True)
                self.assertEqual(result.returncode, 0, result.stderr)
                self.assertEqual(result.stderr, "")
            front_page = subprocess.run(["make"], cwd=REPOSITORY, env=environment() | {"PATH": folder},
                                        text=True, capture_output=True).stdout
            for word in ("make demo", "make test", "SITE", "sites:"):
                self.assertIn(word, front_page)

    def test_every_goal_is_on_the_front_page(self):
        text = "".join((REPOSITORY / name).read_text(encoding="utf-8") for name in ("Makefile", "scripts/development.mk"))
        lists = re.findall(r"(?m)^(?:\.PHONY:|OF_SITE :=)(.*)$", text)
        goals = {word for line in lists for word in line.split() if re.fullmatch(r"[a-z][a-z-]*", word)}
        goals |= set(PIPELINE.goals)
        self.assertGreater(len(goals), 20)
        front_page = subprocess.run(["make", "help"], cwd=REPOSITORY, env=environment(), text=True,
                                    capture_output=True).stdout
        for goal in goals - {"the_site"}:
            self.assertIn(f"make {goal} ", front_page)

    def test_the_makefile_is_a_front_page(self):
        text = (REPOSITORY / "Makefile").read_text(encoding="utf-8")
        self.assertLessEqual(len(text.splitlines()), 150)
        for path in (REPOSITORY / "Makefile", *(REPOSITORY / "scripts").glob("*.mk")):
            self.assertNotIn("$(eval", path.read_text(encoding="utf-8"), path.name)


class BuildTest(unittest.TestCase):
    def test_two_at_the_same_time_take_turns(self):
        """Each of two sites made in one checkout builds the programs first."""
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)
            for tool in ("cmake", "ninja"):
                (root / tool).write_text(f"#!/bin/sh\necho {tool} >> {root}/calls\nsleep 0.3\n")
                (root / tool).chmod(0o755)
            command = ["make", "--eval=override PROGRAMS :=", f"BUILD={root}/build", f"{root}/build/programs.mk"]
            path = {"PATH": f"{root}:{os.environ['PATH']}"}
            runs = [subprocess.Popen(command, cwd=REPOSITORY, env=environment() | path, text=True,
                                     stdout=subprocess.DEVNULL, stderr=subprocess.PIPE) for _ in range(2)]
            for run in runs:
                _, errors = run.communicate()
                self.assertEqual((run.returncode, errors), (0, ""))
            self.assertEqual((root / "calls").read_text().split(), ["cmake", "ninja"] * 2)
