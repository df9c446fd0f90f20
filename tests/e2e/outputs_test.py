# SPDX-License-Identifier: Apache-2.0
"""Outputs in the wrong place cost nothing; those that nobody wants are left out; inputs that are no files."""
import os
import socket
import stat
import subprocess
import unittest

from workspace import BUILD, GOALS, SITE, Workspace

MAP = f"maps/{SITE}"
GRID = ("floors=o/floors.json", "pgm=o/map.pgm", "yaml=o/map.yaml")
PLAN = ("csv=o/path.csv", "json=o/path.json")
LANDMARKS = ("landmarks=o/landmarks.h5",)
TIMEOUT_S = 60


class OutputsTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.work = Workspace.made(*GOALS).removed_after(cls)

    def setUp(self):
        subprocess.run(["rm", "-rf", self.work.folder / "o"], check=True)

    def inputs(self, stage):
        shards = sorted(path.name for path in self.work.path("features").glob("shard_*.h5"))
        return {
            "grid": [f"octree={MAP}/octree/map.ot", f"keyframes={MAP}/map_frame/keyframes.tum"],
            "plan": [f"grid={MAP}/grid/floors.json", f"trajectory={MAP}/map_frame/trajectory.tum",
                     f"queries={MAP}/localize/queries.csv"],
            "landmarks": [*(f"frames={MAP}/frames/{name.replace('.h5', '.csv')}" for name in shards),
                          f"cameras={MAP}/adjust/cameras.json",
                          *(f"features={MAP}/features/{name}" for name in shards),
                          f"vocabulary={MAP}/vocabulary/vocabulary.h5",
                          *(f"{name}={MAP}/map_frame/{name}.tum" for name in ("trajectory", "keyframes"))],
        }[stage]

    def run_stage(self, stage, outputs, inputs=None):
        command = [BUILD / "bin" / stage, "--config", f"{MAP}/config/{stage}.toml"]
        for port in self.inputs(stage) if inputs is None else inputs:
            command += ["--in", port]
        for port in outputs:
            command += ["--out", port]
        return subprocess.run(command, cwd=self.work.folder, text=True, timeout=TIMEOUT_S,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT)

    def check_refused(self, result, *words):
        self.assertEqual(result.returncode, 2, result.stdout)
        for word in words:
            self.assertIn(word, result.stdout)
        self.assertFalse((self.work.folder / "o").exists(), "the stage made a folder before it refused")

    def test_what_is_no_plain_file_is_not_replaced(self):
        fifo, listening, null = (self.work.folder / name for name in ("fifo", "socket", "to_null"))
        os.mkfifo(fifo)
        null.symlink_to("/dev/null")
        with socket.socket(socket.AF_UNIX) as server:
            server.bind(os.path.relpath(listening))
            for path, what in (("/dev/null", "a device"), (null, "a device"), (fifo, "a FIFO"),
                               (listening, "a socket"), (self.work.folder, "a folder")):
                before = os.lstat(path)
                self.check_refused(self.run_stage("grid", (*GRID, f"png={path}")), f"--out png={path}: is {what}")
                after = os.lstat(path)
                self.assertEqual((stat.S_IFMT(after.st_mode), after.st_ino),
                                 (stat.S_IFMT(before.st_mode), before.st_ino))

    def test_an_input_is_not_overwritten(self):
        octree = self.work.path("octree/map.ot")
        bytes_before = octree.read_bytes()
        (self.work.folder / "hard_link").hardlink_to(octree)
        for path in (f"{MAP}/octree/map.ot", f"./{MAP}/grid/../octree/map.ot", "hard_link"):
            result = self.run_stage("grid", (f"floors={path}", *GRID[1:]))
            self.check_refused(result, f"--out floors={path} is the file of --in octree")
            self.assertEqual(octree.read_bytes(), bytes_before)

    def test_a_grid_that_floors_json_names_is_not_overwritten(self):
        pgm = self.work.path("grid/map.pgm")
        bytes_before = pgm.read_bytes()
        result = self.run_stage("plan", (*PLAN, f"png={MAP}/grid/map.pgm"))
        self.check_refused(result, f"--out png={MAP}/grid/map.pgm is the file of", "map.yaml names")
        self.assertEqual(pgm.read_bytes(), bytes_before)

    def test_two_outputs_have_two_paths(self):
        (self.work.folder / "real").mkdir()
        (self.work.folder / "link").symlink_to("real")
        for one, other in (("q", "./q"), ("real/q", "link/q")):
            result = self.run_stage("grid", (*GRID, f"png={one}", f"distances={other}"))
            self.check_refused(result, f"--out distances={other}", f"--out png={one}", "are one file")
            self.assertFalse((self.work.folder / one).exists())

    def test_an_input_that_is_no_file_is_refused_at_once(self):
        fifo = self.work.folder / "input_fifo"
        os.mkfifo(fifo)
        self.check_refused(self.run_stage("grid", GRID, [f"octree={fifo}"]), "is a FIFO, a file is needed")
        self.check_refused(self.run_stage("grid", GRID, [f"octree={MAP}/octree"]), "is a folder, a file is needed")
        features = self.run_stage("features", ("features=o/shard_0000.h5",),
                                  [f"frames={MAP}/frames/shard_0000.csv", f"cameras={MAP}/frames/cameras.json",
                                   f"data={MAP}/octree/map.ot"])
        self.check_refused(features, "is a file, a folder is needed")
        config = subprocess.run([BUILD / "bin" / "grid", "--print-config", "--config", fifo], text=True,
                                timeout=TIMEOUT_S, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        self.check_refused(config, "is a FIFO, a file is needed")

    def check_made(self, stage, outputs):
        """Only what was asked for is made, with the bytes of the whole run."""
        result = self.run_stage(stage, outputs)
        self.assertEqual(result.returncode, 0, result.stdout)
        names = {path.name for path in (self.work.folder / "o").iterdir()}
        self.assertEqual(names, {port.partition("=o/")[2] for port in outputs})
        return {name: (self.work.folder / "o" / name).read_bytes() for name in names}

    def test_outputs_that_nobody_wants_are_left_out(self):
        for name, made in self.check_made("plan", PLAN).items():
            self.assertEqual(made, self.work.path(f"plan/{name}").read_bytes(), name)
        self.setUp()
        made = self.check_made("grid", GRID)
        for name in ("map.pgm", "map.yaml"):
            self.assertEqual(made[name], self.work.path(f"grid/{name}").read_bytes(), name)
        self.setUp()
        self.assertEqual(self.check_made("landmarks", LANDMARKS)["landmarks.h5"],
                         self.work.path("landmarks/landmarks.h5").read_bytes())

    def test_a_part_of_a_colmap_model_is_a_mistake(self):
        self.check_refused(self.run_stage("landmarks", (*LANDMARKS, "images.bin=o/images.bin")),
                           "cameras.bin=PATH", "points3D.bin=PATH")
