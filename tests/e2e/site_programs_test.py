# SPDX-License-Identifier: Apache-2.0
"""A run builds the programs that its site runs, and no others; the compiler is a stub."""
import os
import shutil
import unittest

from stub_site import STUB, StubSite
from workspace import PIPELINE, REPOSITORY, read_pipeline

LASER = set(read_pipeline(str(REPOSITORY / "configs"), "laser").programs())
CAMERA = set(PIPELINE.programs())


class SiteProgramsTest(unittest.TestCase):
    def setUp(self):
        self.site = StubSite().removed_after(self)
        self.folder = self.site.folder
        shutil.rmtree(self.folder / "build")
        for program in CAMERA | LASER:
            (self.folder / "stages/wing" / program).mkdir(parents=True)
            (self.folder / "stages/wing" / program / "main.cc").touch()
        (self.folder / "data/demo_laser").mkdir()
        self.add_tool("cmake", "mkdir -p build/bin; touch build/bin/nightmap_media.so")
        self.add_tool("ninja", 'for a; do case $a in *_program) echo ${a%_program} >> calls; '
                               f'cp {STUB} build/bin/${{a%_program}};; esac; done; [ ! -e broken ]')  # fmt: skip

    def add_tool(self, name, body):
        path = self.folder / "tools" / name
        path.parent.mkdir(exist_ok=True)
        path.write_text(f"#!/bin/sh\n{body}\n")
        path.chmod(0o755)

    def make(self, *arguments, code=0):
        """Returns what make says, and the programs that were built."""
        calls = self.folder / "calls"
        calls.unlink(missing_ok=True)
        old = os.environ["PATH"]
        os.environ["PATH"] = f"{self.folder}/tools:{old}"
        try:
            result = self.site.make(*arguments)
        finally:
            os.environ["PATH"] = old
        self.assertEqual(result.returncode, code, result.stdout)
        return result.stdout, set(calls.read_text().split()) if calls.exists() else set()

    def test_only_those_of_the_site(self):
        self.assertEqual(self.make("-q", "map", code=1)[1], set())
        said, built = self.make("-n", "map")
        self.assertEqual(built, set())
        said, built = self.make("map")
        self.assertEqual(built, CAMERA)
        self.make("-q", "map")
        self.assertEqual(self.make("map", "localize")[1], set())

    def test_another_site_adds_its_own(self):
        self.make("map")
        self.assertIn("programs: ", self.make("why", "SITE=demo_laser")[0])
        _, built = self.make("map", "SITE=demo_laser")
        self.assertEqual(built, CAMERA | LASER)

    def test_a_changed_source(self):
        self.make("map")
        (self.folder / "pipeline/base").mkdir(parents=True)
        (self.folder / "pipeline/base/files.h").touch()
        self.make("-q", "map", code=1)
        said, built = self.make("-n", "map")
        self.assertIn("pipeline/base/files.h is newer", said)
        self.assertEqual(built, set())
        self.assertEqual(self.make("map")[1], CAMERA)
        self.make("-q", "map")

    def test_a_build_that_fails(self):
        self.make("map")
        before = self.site.hashes()
        (self.folder / "stages/wing/grid/main.cc").write_text("// changed\n")
        (self.folder / "broken").touch()
        said, _ = self.make("map", code=2)
        self.assertIn("the programs cannot be built", said)
        self.assertEqual(self.site.hashes(), before)
        (self.folder / "broken").unlink()
        self.assertEqual(self.make("map")[1], CAMERA)

    def test_a_mistake_in_the_config_is_told_before_the_build(self):
        said, built = self.make("map", "SET=grid.no_such_key=1", code=2)
        self.assertIn("no_such_key", said)
        self.assertEqual(built, set())
