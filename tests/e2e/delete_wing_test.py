# SPDX-License-Identifier: Apache-2.0
"""Deleting a wing takes its own folders. A copy of the tree loses those of the wing `ceiling`, with what bears its name among tests,
sites and profiles; all else still composes, builds and passes."""
import os
import pathlib
import re
import shutil
import subprocess
import unittest

from add_wing_test import copy_of_the_tree
from nightly import IS_NIGHT
from workspace import said_by

WING = "ceiling"
FOLDERS = (f"pipeline/{WING}", f"stages/{WING}", f"configs/{WING}", f"scripts/nightmap_eval/{WING}", f"tests/{WING}", f"tests/stages/{WING}")
NAMED = ("tests/e2e/delete_wing_test.py", f"configs/published_{WING}", f"configs/sites/{WING}_*", f"tests/*/{WING}_*", f"tests/bench/bench_{WING}_*", f"docs/methods/{WING}.md")
USES = re.compile(rf'#include "(?:tests/)?(?:pipeline|stages)/{WING}/|\bnightmap_eval\.{WING}\b|\b(?:from|import) {WING}_\w+')
SCRIPTS = ("pieces_test", "config_layers_test", "rules_test", "layers_test", "evaluate_test", "report_test", "verdict_test", "site_configs_test")


def forget_it_in_pages(folder):
    """Links to its page become text; rows and items that name its files go; programs write the other tables."""
    for page in [*folder.glob("*.md"), *folder.glob("docs/**/*.md")]:
        text = re.sub(rf"`([^`\n]*/{WING}/[^`\n]*)`", r"\1", re.sub(r"(?:CeilingMap|CornerTracks) \d+, ", "", page.read_text(encoding="utf-8")))
        text = re.sub(rf"\[([^\]]+)\]\([^)]*{WING}\.md[^)]*\)", r"\1", text)
        lines = [line for line in text.splitlines(keepends=True) if not re.search(rf"^[|-].*\b{WING}(?:[/_]|`)", line) or "figures.md" in str(page)]
        page.write_text("".join(lines), encoding="utf-8")


class DeleteWingTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = copy_of_the_tree()
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        for folder in FOLDERS:
            shutil.rmtree(cls.folder / folder)  # each must have been there
        for path in [path for pattern in NAMED for path in cls.folder.glob(pattern)]:
            shutil.rmtree(path) if path.is_dir() else path.unlink()
        forget_it_in_pages(cls.folder)
        for script in ("describe_pipeline", "describe_packages"):
            subprocess.run(["/usr/bin/python3", f"scripts/{script}.py", "--write"], cwd=cls.folder, check=True)
        for command in (["init", "-q"], ["add", "-A"], ["-c", "user.name=n", "-c", "user.email=e", "commit", "-qm", "without the wing"]):
            subprocess.run(["git", *command], cwd=cls.folder, check=True)

    def run_in(self, folder, *command, **variables):
        return said_by(command, self.folder / folder, **{"NIGHTMAP_BUILD": str(self.folder / "build")} | variables)

    def test_nothing_that_is_left_includes_or_imports_it(self):
        left = [path for path in self.folder.rglob("*") if path.suffix in (".cc", ".h", ".py") and path.name != pathlib.Path(__file__).name]
        self.assertGreater(len(left), 1000)
        found = [f"{path}: {use}" for path in left for use in USES.findall(path.read_text(encoding="utf-8"))]
        self.assertEqual(found, [])
        self.assertTrue(USES.search(f'#include "pipeline/{WING}/x.h"') and USES.search(f"from nightmap_eval.{WING}.x import y"))

    def test_the_other_profiles_are_whole(self):
        page = self.run_in("", "/usr/bin/python3", "scripts/describe_pipeline.py")
        self.assertIn("| `labels` |", page)
        self.assertNotIn(WING, page)

    def test_what_is_left_builds_and_passes(self):
        programs = ("frames", "pose_graph")
        self.run_in("", "make", "build/programs.mk", NIGHTMAP_PROGRAMS=" ".join(programs))
        self.assertLessEqual(set(programs), set(os.listdir(self.folder / "build/run")))
        self.run_in("", "cmake", "-S", ".", "-B", "build/all", "-G", "Ninja", "-DNIGHTMAP_TESTS=ON", "--log-level=WARNING")
        self.assertNotRegex((self.folder / "build/all/build.ninja").read_text(), f"-lnightmap_|nightmap_{WING}|stage_{WING}")
        self.run_in("tests/scripts", "/usr/bin/python3", "-m", "unittest", *SCRIPTS)

    @unittest.skipUnless(IS_NIGHT, "takes half an hour: set NIGHTMAP_NIGHTLY=1")
    def test_all_builds_and_passes(self):
        self.run_in("", "make", "test", NIGHTMAP_NIGHTLY="0")
