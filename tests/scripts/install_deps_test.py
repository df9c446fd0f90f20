# SPDX-License-Identifier: Apache-2.0
"""install_deps.sh on a machine that has none of the packages: what it would install for what."""
import os
import pathlib
import re
import subprocess

from folder_case import FolderTest


SCRIPT = pathlib.Path(__file__).resolve().parents[2] / "scripts/install_deps.sh"
LARGE = {"libpcl-dev", "libembree-dev", "colmap", "chromium", "clang-tidy"}  # that only some programs or commands need


class InstallDepsTest(FolderTest):
    def run_script(self, *arguments, is_installed=False):
        """The packages that apt-get is asked to install, and what the script says."""
        asked = self.folder / "asked"
        asked.unlink(missing_ok=True)
        tools = {"dpkg-query": "printf 'install ok installed'" if is_installed else "exit 1",
                 "apt-get": f'echo "$@" >> {asked}', "id": "echo 0"}  # fmt: skip
        for name, body in tools.items():
            path = self.folder / name
            path.write_text(f"#!/bin/sh\n{body}\n")
            path.chmod(0o755)
        result = subprocess.run([SCRIPT, *arguments], env={**os.environ, "PATH": f"{self.folder}:{os.environ['PATH']}"},
                                capture_output=True, text=True)  # fmt: skip
        self.assertEqual((result.returncode, result.stderr), (0, ""))
        words = asked.read_text().split("--no-install-recommends")[1].split() if asked.exists() else []
        return {word for word in words if not word.startswith("-")}, result.stdout

    def test_large_packages_are_for_what_needs_them(self):
        for what, large in ({"frames", "octree"}, set()), ({"synthesize"}, {"libembree-dev"}), ({"things"}, {"libpcl-dev"}), (
                {"scan_localize"}, {"libpcl-dev"}), ({"colmap"}, {"colmap"}), ({"lint"}, {"clang-tidy"}), (
                {"tests"}, LARGE - {"clang-tidy"}):  # fmt: skip
            with self.subTest(what):
                packages, _ = self.run_script(*what)
                self.assertEqual(packages & LARGE, large)
                self.assertIn("libopencv-dev", packages)

    def test_all_without_arguments(self):
        packages, _ = self.run_script()
        listed = re.findall(r"(?m)^  ([a-z][\w.-]+(?: [\w.-]+)*) +#", SCRIPT.read_text())
        self.assertEqual(packages, {name for names in listed for name in names.split()} | {"git", "make"})
        self.assertLess(LARGE, packages)

    def test_nothing_is_missing(self):
        packages, said = self.run_script("synthesize", is_installed=True)
        self.assertEqual(packages, set())
        self.assertIn("installed", said)
        self.assertEqual(self.run_script("--quiet", "synthesize", is_installed=True), (set(), ""))
