# SPDX-License-Identifier: Apache-2.0
"""A site without depth: its frames are listed and described, and goals whose jobs need depth are refused before anything runs."""
import unittest

import h5py
from workspace import RECORDING, SITE, Workspace

FEATURES = f"maps/{SITE}/features/shard_0000.h5"


class WithoutDepthTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.work = Workspace.made(RECORDING).removed_after(cls)
        cls.site = cls.work.folder / f"configs/sites/{SITE}.toml"
        cls.site.write_text(cls.site.read_text().replace("[[sequence]]\n", '[[sequence]]\ndepth = "none"\n'))

    def test_features_are_made_and_a_map_is_refused_once(self):
        self.assertNotIn(": skipped", self.work.output(FEATURES))
        with h5py.File(self.work.folder / FEATURES) as file:
            depths_m = file["depth_m"][:]
        self.assertGreater(len(depths_m), 1000)
        self.assertFalse(depths_m.any())

        before = self.work.runs()
        line = self.site.read_text().split("[[sequence]]")[0].count("\n") + 1
        for goal in ("map", "localize", "report", f"maps/{SITE}/matches/shard_0000.h5"):
            said = self.work.output(goal, code=2)
            self.assertEqual(said.count(f"{SITE}.toml:{line}: no recording has depth"), 1, said)
            self.assertIn("record depth, or choose a profile", said)
            self.assertNotIn("== ", said)
        self.assertIn("which matches need", said)
        self.assertEqual(self.work.runs(), before)
