#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""A real recording to which frames are appended ends in the bytes of a clean build, and reruns only the shards it
reaches."""
import os
import pathlib
import shutil
import tempfile
import unittest

from workspace import REPOSITORY, Workspace

SITE = "tum_fr1_xyz_15hz"
DATA = pathlib.Path(os.environ.get("NIGHTMAP_DATA", REPOSITORY / "../shared/data")).resolve()
FIRST = 300
SHARD = 100


class AppendTest(unittest.TestCase):
    def setUp(self):
        if not (DATA / SITE).is_dir():
            if os.environ.get("CI") == "true":
                self.fail(f"no recording {DATA / SITE}; set NIGHTMAP_DATA")
            self.skipTest(f"no recording {DATA / SITE}: set NIGHTMAP_DATA")
        self.work = Workspace(tempfile.mkdtemp(prefix="nightmap-e2e-"))
        self.addCleanup(self.work.remove)
        (self.work.folder / "data").mkdir()
        (self.work.folder / "data" / SITE).symlink_to(DATA / SITE)
        sites = self.work.folder / "configs/sites" / SITE
        sites.mkdir(exist_ok=True)
        (sites / "frames.toml").write_text(f"shard_size = {SHARD}\n")

    def make(self, *arguments):
        result = self.work.make(f"SITE={SITE}", "map", *arguments)
        self.assertEqual(result.returncode, 0, result.stdout)
        return result.stdout

    def hashes(self):
        return self.work.hashes(SITE)

    def test_appended_frames(self):
        self.make(f"SET=frames.max_frames={FIRST}")
        output = self.make()
        for job in ("features", "matches", "odometry"):
            self.assertRegex(output, rf"(?m)^{job} +1 of 4 ", output)
            self.assertNotIn(f"== {job}_0000", output)
            self.assertIn(f"== {job}_0003", output)
        appended = self.hashes()
        shutil.rmtree(self.work.folder / "maps")
        self.make()
        self.assertEqual(appended, self.hashes())


if __name__ == "__main__":
    unittest.main()
