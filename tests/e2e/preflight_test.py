# SPDX-License-Identifier: Apache-2.0
"""The check before a run: a value out of range of each program, and each declared clash, stop with exit code 2 in little
time, name the place, and change nothing. The programs are the real ones; none gets to run. (programs_test.py shows every
option's values out of range to the programs themselves.)"""
import unittest

from cpu_time import in_yardsticks
from out_of_range import options, said_of
from stub_site import StubSite
from workspace import BUILD, PIPELINE

MAX_YARDSTICKS = 20
CLASHES = {  # one for each [[clash]] of configs/pipeline.toml, in its order
    "octree.max_range_m=5.9 tiles.max_range_m=5.95 tiles.edge_m=6": None, "tiles.overlap_m=0.4 octree.resolution_m=0.9": "octree.resolution_m",
    "point_cloud.max_depth_m=5": "point_cloud.max_depth_m",
    "octree.max_range_m=5": "octree.max_range_m",
    "octree.occupancy_threshold=0.1": "octree.probability_min", "octree.occupancy_threshold=0.98": "octree.probability_max",
    "point_cloud.surface_radius_m=0.4": "tiles.overlap_m",
    "mesh.radius_voxels=40 mesh.cell_voxels=20 point_cloud.voxel_size_m=0.25 tiles.overlap_m=3": "mesh.radius_voxels",
    "grid.max_step_height_m=0.3 grid.robot_height_m=0.2": "grid.robot_height_m",
    "drive.min_lookahead_m=1.5 drive.max_lookahead_m=1": "drive.max_lookahead_m"}  # fmt: skip


class PreflightTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.site = StubSite().removed_after(cls)
        cls.site.output("map")
        run = cls.site.folder / "build/run"
        for program in PIPELINE.programs():
            (run / program).unlink()
            (run / program).symlink_to(BUILD / "run" / program)
        # The first check of all programs; make must find nothing to do but that.
        cls.site.make("map", "SET=grid.margin_m=-1")

    def state(self):
        maps = self.site.folder / "maps"
        return {path: path.stat().st_mtime_ns for path in maps.rglob("*")}

    def check(self, change, *said):
        """Returns the CPU time of the check."""
        before = self.state()
        yardsticks = in_yardsticks(lambda: self.check_once(change, said), num_runs=1)
        if yardsticks > MAX_YARDSTICKS:  # what else runs shares caches with it
            yardsticks = in_yardsticks(lambda: self.check_once(change, said), num_runs=2)
        self.assertEqual(self.state(), before)
        return yardsticks

    def check_once(self, change, said):
        result = self.site.output("map", f"SET={change}", code=2)
        for text in said:
            self.assertIn(text, result)
        self.assertNotIn("== ", result)

    def test_a_mistake_in_the_site_config(self):
        """The programs that read it check it before the run, and a new site gets no folder."""
        path = self.site.folder / "configs/sites/demo.toml"
        text = path.read_text()
        self.addCleanup(path.write_text, text)
        for wrong, said in ((text.replace("hold_out_every", "hold_out_evry"), "demo.toml:5: unknown key 'hold_out_evry'"),
                            (text.replace("width = 640", "width = -640"), "width"), (text.replace("[[camera]]", "[[kamera]]"), "demo.toml:22: no [[camera]] has id"),
                            (text.replace('layout = "tum"', 'layout = "tmu"'), "tmu"),
                            (text.replace("synthetic = true", 'synthetic = false').replace('root = "demo"', 'root = "nowhere"'),
                             "data/nowhere does not exist")):  # fmt: skip
            with self.subTest(said):
                path.write_text(wrong)
                self.check("plan.start='1 2'", said)
                (path.parent / "new.toml").write_text(wrong)
                result = self.site.output("map", "SITE=new", code=2)
                self.assertIn(said.replace("demo", "new"), result)
                self.assertFalse((self.site.folder / "maps/new").exists())
        path.write_text(text)
        picture = self.site.folder / "a.jpg"
        picture.write_bytes(b"x")
        before = self.state()
        said = self.site.output("map", "QUERY=a.jpg", "CAMERA=phone", code=2)
        self.assertIn('QUERY of make: no [[camera]] has id "phone"', said)
        self.assertEqual(self.state(), before)

    def test_make_refuses_a_value_of_each_program(self):
        for program in PIPELINE.programs():
            name, wrong = next(options(program))
            with self.subTest(f"{program}.{name}={wrong}"):
                self.assertLess(self.check(f"{program}.{name}={wrong}", f"SET: {program}.{name}", *said_of(wrong)), MAX_YARDSTICKS)

    def test_a_program_that_agreed_is_not_asked_again(self):
        checked = self.site.folder / "build/checked"
        for stamp in checked.iterdir():
            stamp.unlink()
        self.check("grid.margin_m=-1", "grid.margin_m")
        programs = {stamp.name.rpartition("_")[0] for stamp in checked.iterdir()}
        self.assertIn("features", programs)
        self.assertNotIn("grid", programs)

    def test_the_file_and_line_of_a_value(self):
        path = self.site.folder / "configs/sites/demo/grid.toml"
        path.parent.mkdir(exist_ok=True)
        path.write_text("# facts\n\nmargin_m = -1.0\n")
        self.check("octree.resolution_m=0.05", "configs/sites/demo/grid.toml:3: grid.margin_m = -1")
        path.unlink()

    def test_each_clash(self):
        self.assertEqual(len(CLASHES), len(PIPELINE.clashes))
        for (change, named), clash in zip(CLASHES.items(), PIPELINE.clashes):
            with self.subTest(change):
                said = (*[named] * bool(named), clash["remedy"])
                self.assertLess(self.check(change, *said), MAX_YARDSTICKS)
                self.check(change, *said)  # what was refused once is refused again
