# SPDX-License-Identifier: Apache-2.0
"""Lists of frames in another form give the same bytes: times in another unit, and color with depth in associations.txt."""
import unittest
from decimal import Decimal

from workspace import RECORDING, SITE, Workspace

LISTS = ("rgb.txt", "depth.txt", "groundtruth.txt")
GOAL = f"maps/{SITE}/features/shard_0000.h5"
START_S = 1305031102


class FrameListsTest(unittest.TestCase):
    def setUp(self):
        self.work = Workspace.made(RECORDING).removed_after(self)
        self.work.as_recorded()
        self.site = self.work.folder / f"configs/sites/{SITE}.toml"
        self.text = self.site.read_text()
        self.lists = {name: (self.work.data() / name).read_text().splitlines() for name in LISTS}

    def write_lists(self, units_per_s):
        for name, lines in self.lists.items():
            rows = [line.split(maxsplit=1) for line in lines if not line.startswith("#")]
            (self.work.data() / name).write_text(
                "".join(f"{((Decimal(time) + START_S) * units_per_s).normalize():f} {rest}\n" for time, rest in rows))

    def results(self, unit):
        self.site.write_text(self.text.replace("[[sequence]]", f'[[sequence]]\ntime_unit = "{unit}"'))
        self.work.output(GOAL)
        return {name: value for name, value in self.work.hashes().items() if name.startswith(("features/", "frames/"))}

    def test_ms_and_ns_give_the_bytes_of_seconds(self):
        self.write_lists(1)
        seconds = self.results("s")
        self.assertTrue({"features/shard_0000.h5", "frames/shard_0000.csv", "frames/held_out.tum"} <= seconds.keys())
        for unit, units_per_s in (("ms", 10**3), ("ns", 10**9)):
            self.write_lists(units_per_s)
            self.assertEqual(self.results(unit), seconds, unit)

    def test_associations_give_the_bytes_of_the_lists(self):
        self.write_lists(1)
        lists = self.results("s")
        color, depth = ((self.work.data() / name).read_text().splitlines() for name in LISTS[:2])
        self.assertEqual(len(color), len(depth))
        (self.work.data() / "associations.txt").write_text("".join(f"{b} {a}\n" for a, b in zip(color, depth)))
        for name in LISTS[:2]:
            (self.work.data() / name).unlink()
        self.assertEqual(self.results("s"), lists)

    def test_a_unit_that_is_not_stated_is_named_with_the_line_to_write(self):
        self.write_lists(10**6)
        said = self.work.output(GOAL, code=2)
        self.assertRegex(said, r'rgb\.txt: its times cannot be in seconds, they look like us: write time_unit = "us" in the table '
                                        rf"at \S*{SITE}\.toml:\d+")
