# SPDX-License-Identifier: Apache-2.0
"""Artifacts that are damaged or another site's, with the times of good ones, so that make does not notice: the
job that reads one names it, and deleting what the message names gives the map again (by day tried for one case in three)."""
import os
import re
import shutil
import unittest

from nightly import some_of
from workspace import SITE, Workspace, as_its_job_wrote

from nightmap_eval.sealed_hdf5 import sealed


def cut_last_line(path):
    path.write_text("".join(path.read_text().splitlines(keepends=True)[:-1]))


def empty(path):
    path.write_text("# map_from_camera\n")


def move_in_time(path):
    path.write_text(re.sub(r"(?m)^(\d+)\.", lambda found: f"{int(found[1]) + 1000}.", path.read_text()))


def pair_beyond_the_site(path):
    with sealed(path, "r+") as file:
        file["frame"][-1] = 5, 1_000_000


def next_shard(path):
    shutil.copy(path.with_name("shard_0001.h5"), path)


# Each case: the damage, the output that its reader makes anew, the files that the message names.
CASES = [
    ("loops/loops.h5", pair_beyond_the_site, "pose_graph/trajectory.tum", ["loops/loops.h5"]),
    ("matches/shard_0001.h5", pair_beyond_the_site, "odometry/shard_0001.h5", ["matches/shard_0001.h5"]),
    ("frames/shard_0000.csv", cut_last_line, "matches/shard_0001.h5", ["frames/shard_0000.csv", "frames/shard_0001.csv"]),
    ("frames/shard_0001.csv", cut_last_line, "matches/shard_0001.h5", ["frames/shard_0001.csv", "features/shard_0001.h5"]),
    ("features/shard_0000.h5", next_shard, "vocabulary/vocabulary.h5", ["features/shard_0000.h5", "features/shard_0001.h5"]),
    ("adjust/keyframes.tum", move_in_time, "map_frame/keyframes.tum",
     ["adjust/keyframes.tum", "frames/shard_0000.csv"]),
    ("map_frame/keyframes.tum", move_in_time, "tiles/tiles.txt", ["map_frame/keyframes.tum", "frames/shard_0000.csv"]),
    ("map_frame/keyframes.tum", empty, "tiles/tiles.txt", ["map_frame/keyframes.tum"]),
    ("map_frame/keyframes.tum", empty, "grid/floors.json", ["map_frame/keyframes.tum"]),
    ("map_frame/keyframes.tum", empty, "landmarks/landmarks.h5", ["map_frame/keyframes.tum"]),
    ("map_frame/keyframes.tum", move_in_time, "landmarks/landmarks.h5", ["map_frame/keyframes.tum", "frames/shard_0000.csv"]),
]


class RemediesTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.base = Workspace.made("map").removed_after(cls)
        cls.hashes = cls.base.hashes()

    def damage(self, work, name, change):
        status = work.path(name).stat()
        change(work.path(name))
        as_its_job_wrote(work.path(name))  # else the program that reads it says so before it reads
        os.utime(work.path(name), ns=(status.st_atime_ns, status.st_mtime_ns))

    def check(self, damaged, change, remade, named, tries_remedy):
        work = self.base.copy().removed_after(self)
        self.damage(work, damaged, change)
        work.path(remade).unlink()
        result = work.make("map")
        self.assertNotEqual(result.returncode, 0)
        errors = [line for line in result.stdout.splitlines() if " error " in line]
        self.assertEqual(len(errors), 1, result.stdout)
        self.assertRegex(errors[0], "delete (it|them|both) and run make again")
        for name in named:
            self.assertIn(f"maps/{SITE}/{name}", errors[0])
            work.path(name).unlink()
        if not tries_remedy:
            return
        work.output("map")
        hashes = work.hashes()  # with those of localize, which the report of the failed run asked for
        self.assertEqual({name: hashes.get(name) for name in self.hashes}, self.hashes)

    def test_the_message_names_the_file_and_the_remedy_works(self):
        tried = some_of(CASES, one_in=3)
        for case in CASES:
            damaged, change, remade, named = case
            with self.subTest(damaged=damaged, change=change.__name__, read_for=remade):
                self.check(damaged, change, remade, named, case in tried)
