# SPDX-License-Identifier: Apache-2.0
"""A disk that is full when make's own scripts write: one message that names the file and the remedy, no temporary left,
and the next run with room ends in the bytes of an undisturbed one. (crash_test.py fills the disk of the programs.)"""
import os
import subprocess

from nightly import some_of
from stub_site import StubTest
from workspace import environment

PAGE_BYTES = 4096
DISK_BYTES = 4 << 20
FULL = "maps/demo.*: No space left on device: the disk is full: free space there"
MAX_FILE_KB = 100  # more than Python needs for its compiled modules


class FullDiskTest(StubTest):
    def check_told(self, output, *remedies):
        self.assertNotIn("Traceback", output)
        self.assertNotIn("[Errno", output)
        self.assertRegex(output, "|".join(remedies))
        self.assertEqual([path for path in self.site.path("").rglob("*.tmp*")], [])
        self.assertEqual([path for path in self.site.path("").rglob(".writing.*")], [])

    def test_a_limit_of_file_sizes(self):
        """A limit that needs no root: the rules of many shards are larger than the limit."""
        for goal in some_of(("map", "status", "why"), one_in=2):
            with self.subTest(goal):
                command = ["bash", "-c", f'ulimit -f {MAX_FILE_KB}; exec "$@"', "bash", *self.site.command(goal)]
                limited = subprocess.run(command, cwd=self.site.folder, env=environment() | {"STUB_SHARDS": "150"}, text=True,
                                         stdout=subprocess.PIPE, stderr=subprocess.STDOUT)  # fmt: skip
                self.assertEqual(limited.returncode, 2, limited.stdout)
                self.check_told(limited.stdout, r"graph\.mk: File too large: raise the limit of file sizes")
        self.make("map")

    def mounted(self):
        """A small disk for maps/."""
        # A recording of nearly no frames, so that the check before a run asks for little room.
        config = self.site.folder / "configs/sites/demo.toml"
        config.write_text(config.read_text().replace("synthetic = true", "synthetic = false"))
        (self.site.folder / "data/demo/queries").mkdir()
        for part in ("", "queries/"):
            (self.site.folder / f"data/demo/{part}groundtruth.txt").touch()
        folder = self.site.folder / "maps"
        folder.mkdir()
        mount = subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={DISK_BYTES}", "tmpfs", folder], capture_output=True, text=True)
        if mount.returncode != 0:
            self.skipTest(f"needs root to mount a small tmpfs: {mount.stderr.strip()}")
        self.addCleanup(subprocess.run, ["umount", folder], check=True)
        return folder

    def fill(self, folder, num_pages_free):
        free = os.statvfs(folder)
        (folder / "ballast").write_bytes(bytes(max(0, free.f_bfree - num_pages_free) * PAGE_BYTES))

    def test_full_at_any_moment(self):
        folder = self.mounted()
        self.make("map")
        expected = self.site.hashes()
        for num_pages_free in (0, 1, 2, 4, 8, 12, 16, 24, 32, 40):
            for goal in ("map", "status"):
                with self.subTest(goal, num_pages_free=num_pages_free):
                    subprocess.run(["rm", "-rf", self.site.path("")], check=True)
                    self.fill(folder, num_pages_free)
                    result = self.site.make(goal)
                    (folder / "ballast").unlink()
                    if result.returncode != 0:
                        self.assertEqual(result.returncode, 2)
                        self.check_told(result.stdout, FULL, "maps/demo: .* are free, .* make room, or set MAPS")
        self.check_recovers(expected)

    def check_recovers(self, expected):
        self.make("map")
        self.assertEqual({name: digest for name, digest in self.site.hashes().items() if name in expected}, expected)
        self.make("-q", "map")

    def test_full_while_a_job_runs(self):
        """No room for the end of the journal, for failure.json or for the page; nothing that was made is lost."""
        folder = self.mounted()
        self.make("map")
        expected = self.site.hashes()
        program = self.site.folder / "build/run/grid"
        program.unlink()
        program.write_text(f"#!/bin/sh\ncase \"$*\" in *--check-config*) exit 0 ;; esac\ncat /dev/zero >{folder}/ballast\nexit 1\n")
        program.chmod(0o755)
        output = self.make("map", code=2)
        self.check_told(output, FULL)
        self.assertIn("nightmap: grid: exit code 1", output)
        self.assertNotIn("the report shows", output)
        self.check_told(self.make("status", code=2), FULL)
        self.assertEqual(self.site.hashes(), expected)
        (folder / "ballast").unlink()
        program.unlink()
        self.site.add_program("grid")
        self.check_recovers(expected)
