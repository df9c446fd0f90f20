# SPDX-License-Identifier: Apache-2.0
"""Results that are not what their jobs wrote: the job that reads one ends and names it, and deleting it gives the map again. A
result that is newer than its receipt looks like a commit that was killed, and is made again by itself."""
import os
import shutil
import unittest

from workspace import LASER_SITE, SITE, Workspace, write_laser_site


def zero_back_half(path):
    content = path.read_bytes()
    path.write_bytes(content[: len(content) // 2] + bytes(len(content) - len(content) // 2))


def cut_within_a_number(path):
    """The last pose ends with fewer digits, and the file keeps its size."""
    text = path.read_text().rstrip("\n")
    path.write_text(text[:-3] + "\n" * (path.stat().st_size - len(text) + 3))


def flip(path):
    content = bytearray(path.read_bytes())
    content[-1] ^= 1
    path.write_bytes(content)


def of_the_other_site(path):
    site = LASER_SITE if path.parents[1].name == SITE else SITE
    shutil.copy(path.parents[2] / site / path.relative_to(path.parents[1]), path)


# Site, file, damage, the output that a reader of the file makes anew.
CASES = [
    (LASER_SITE, "frames/scans.h5", zero_back_half, "odometry/edges.h5"),
    (LASER_SITE, "map_frame/trajectory.tum", cut_within_a_number, "grid/floors.json"),
    (SITE, "matches/shard_0000.h5", zero_back_half, "odometry/shard_0000.h5"),
    (SITE, "map_frame/keyframes.tum", cut_within_a_number, "tiles/tiles.txt"),
    (SITE, "map_frame/keyframes.tum", of_the_other_site, "landmarks/landmarks.h5"),
    (SITE, "octree/map.ot", flip, "grid/floors.json"),
]


class WrittenFilesTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.base = Workspace.made("map").removed_after(cls)
        write_laser_site(cls.base.folder)
        cls.check(cls.base.make(f"SITE={LASER_SITE}", "map"))
        cls.hashes = {site: cls.base.hashes(site) for site in (SITE, LASER_SITE)}

    @staticmethod
    def check(result):
        if result.returncode != 0:
            raise AssertionError(result.stdout)

    def test_the_file_is_named_and_deleting_it_helps(self):
        for site, name, change, remade in CASES:
            for keeps_time in (True, False):
                with self.subTest(site=site, name=name, keeps_time=keeps_time):
                    self.try_case(site, name, change, remade, keeps_time)

    def try_case(self, site, name, change, remade, keeps_time):
        work = self.base.copy().removed_after(self)
        path = work.folder / "maps" / site / name
        status = path.stat()
        change(path)
        if keeps_time:
            os.utime(path, ns=(status.st_atime_ns, status.st_mtime_ns))
            (work.folder / "maps" / site / remade).unlink()
        result = work.make(f"SITE={site}", "map")
        if result.returncode != 0:
            errors = [line for line in result.stdout.splitlines() if " error " in line]
            self.assertEqual(len(errors), 1, result.stdout)
            self.assertIn(f"maps/{site}/{name}: is not the file that the job wrote", errors[0])
            self.assertIn("delete it and run make again", errors[0])
            path.unlink()
            self.check(work.make(f"SITE={site}", "map"))
        else:
            self.assertFalse(keeps_time, "a file that nobody wrote is taken")
        hashes = work.hashes(site)
        self.assertEqual({name: hashes.get(name) for name in self.hashes[site]}, self.hashes[site])
