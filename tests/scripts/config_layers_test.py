# SPDX-License-Identifier: Apache-2.0
"""The effective configs: which layer wins, when a file is written anew, and what is refused."""

import os
import subprocess

from config_folder import CONFIG, PREVIEW, ConfigFolder
from fake_site import SCRIPTS


class LayersTest(ConfigFolder):
    def test_later_layers_win(self):
        self.resolve()
        self.assertEqual(self.config("octree"), {"resolution_m": 0.05, "num_hits": 2, "mode": "ray"})
        self.assertEqual(self.config("plan")["seed"], 0)
        self.write("configs/coarse/octree.toml", "resolution_m = 0.1\nnum_hits = 3\n")
        self.write("configs/sites/office/octree.toml", "num_hits = 4\n")
        self.resolve(profile="coarse", seed="5", set="octree.mode=beam  plan.start='1 2'")
        self.assertEqual(self.config("octree"), {"resolution_m": 0.1, "num_hits": 4, "mode": "beam"})
        self.assertEqual(self.config("plan"), {"seed": 5, "start": "1 2", "footprint_m": []})
        self.resolve(profile="coarse", set="octree.num_hits=9", ends=["plan.start=3 4"])
        self.assertEqual((self.config("octree")["num_hits"], self.config("plan")["start"]), (9, "3 4"))

    def test_a_profile_comes_after_its_pieces(self):
        self.write("configs/coarse/octree.toml", "resolution_m = 0.1\nnum_hits = 3\n")
        self.write("configs/coarse/default/scan.toml", "sigma_m = 0.5\nmode = 'ray'\n")
        self.write("configs/coarse/pipeline.toml", "pieces = []\n")
        self.write("configs/over/pipeline.toml", 'pieces = ["coarse"]\n')
        self.write("configs/over/octree.toml", "num_hits = 5\n")
        self.write("configs/over/scan.toml", "mode = 'beam'\n")
        self.resolve(profile="over")
        self.assertEqual(self.config("octree"), {"resolution_m": 0.1, "num_hits": 5, "mode": "ray"})
        self.assertEqual(self.config("scan"), {"sigma_m": 0.5, "mode": "beam"})

    def test_a_declaration_has_no_options(self):
        self.write("configs/default/pipeline.toml", "pieces = []\n")
        self.resolve()
        self.assertFalse((self.folder / CONFIG / "pipeline.toml").exists())
        self.assertIn("no stage 'pipeline'", self.refused(set="pipeline.pieces=[]"))

    def test_rewritten_only_when_the_meaning_changes(self):
        self.resolve()
        octree, plan = self.time("octree"), self.time("plan")
        self.write("configs/default/octree.toml", "mode = 'ray' # said otherwise\nnum_hits=2\nresolution_m = 5e-2\n")
        self.resolve(set="octree.resolution_m=0.050")
        self.assertEqual(self.time("octree"), octree)
        self.resolve(set="octree.resolution_m=1")
        self.assertNotEqual(self.time("octree"), octree)
        self.assertEqual(self.time("plan"), plan)

    def test_preview_leaves_the_real_configs_alone(self):
        self.resolve()
        octree = self.time("octree")
        self.resolve(work_dir=PREVIEW, set="octree.num_hits=5")
        self.assertEqual((self.time("octree"), self.config("octree")["num_hits"]), (octree, 2))
        self.assertEqual(self.config("octree", PREVIEW)["num_hits"], 5)
        self.assertEqual(self.time("plan", PREVIEW), self.time("plan"))

    def test_a_damaged_config_of_an_earlier_call_is_made_anew(self):
        self.resolve()
        text = self.text("plan.toml")
        self.write(f"{CONFIG}/plan.toml", b"\xff")
        self.resolve()
        self.assertEqual(self.text("plan.toml"), text)

    def test_mistakes_say_what_is_right(self):
        self.write("configs/coarse/octre.toml", "num_hits = 3\n")
        for changes, message in (({"set": "octre.num_hits=3"}, "stages: octree, plan"),
                                 ({"set": "octree.hits=3"}, "known keys: mode, num_hits, resolution_m"),
                                 ({"set": "octree.num_hits"}, "not STAGE.KEY=VALUE"),
                                 ({"set": "octree.num_hits="}, "not STAGE.KEY=VALUE"),
                                 ({"set": "octree.num_hits=3.5"}, "must be like its default 2"),
                                 ({"set": "octree.num_hits=true"}, "must be like its default 2"),
                                 ({"set": "octree.mode='ray"}, "SET: octree.mode='ray: no closing quotation"),
                                 ({"set": "plan.footprint_m=" + "[" * 20000}, "must be like its default"),
                                 ({"profile": "fine"}, "PROFILE: no profile 'fine' in configs; profiles: coarse, default"),
                                 ({"profile": "sites"}, "profiles: coarse, default"),
                                 ({"profile": "coarse"}, "no stage 'octre'"),
                                 ({"seed": "-1"}, "whole number"), ({"seed": "\u00b2"}, "whole number"),
                                 ({"seed": "9" * 5000}, "whole number"),
                                 ({"site": "configs/sites/home.toml"}, "sites: office"),
                                 ({"data": "elsewhere"}, "datasets.md")):  # fmt: skip
            with self.subTest(changes):
                self.assertIn(message, self.refused(**changes))
        self.write("configs/default/plan.toml", "seed = \n")
        self.assertIn("plan.toml: not valid TOML", self.refused())

    def test_wrong_types_in_stage_configs(self):
        for text, word in (("start = 5\n", "must be like its default"), ("start = " + "[" * 20000, "nested too deep"),
                           ("[start]\na = 1\n", "must be like its default"), ("seed = 99999999999999999999\n", "larger than any"),
                           ("footprint_m = [{a = 1}]\n", "neither a number"),
                           ("footprint_m = [[2020-01-01]]\n", "neither a number"),
                           (b"start = '\xff'\n", "UTF-8")):  # fmt: skip
            with self.subTest(text[:40]):
                path = self.write("configs/sites/office/plan.toml", text)
                said = self.refused()
                self.assertIn("configs/sites/office/plan.toml", said)
                self.assertIn(word, said)
                path.unlink()
        self.resolve(set="plan.footprint_m=[[1,2],[3,4]]")
        self.assertEqual(self.config("plan")["footprint_m"], [[1, 2], [3, 4]])

    def test_imports_little(self):
        """make_site.py runs whenever make does. Imports are nearly all of its time, and their number does not depend on load. It
        needs no library beyond Python's own."""
        program = f"import sys; sys.path.insert(0, {os.fspath(SCRIPTS)!r}); import make_site"
        result = subprocess.run(["/usr/bin/python3", "-I", "-S", "-X", "importtime", "-c", program], capture_output=True, text=True)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertLess(result.stderr.count("import time:"), 150)
