# SPDX-License-Identifier: Apache-2.0
"""The declared pipeline and the rules of a site: mistakes in a declaration, profiles, runs that were interrupted."""

import json
import os
import tempfile
import unittest
from pathlib import Path

import fake_site  # noqa: F401  (finds the scripts)
from nightmap_eval.job_results import CONFIGS
from nightmap_make import preflight, why
from nightmap_make.graph import Graph
from nightmap_make.pipeline import PipelineError, read_pipeline
from nightmap_make.rules_file import RulesFile, Times
from nightmap_make.site_state import SiteState

DECLARED = """
[frames]
purpose = "lists frames"
lists = "shard"
in.site = "site"
out.shards = "shards.txt"
beside.shard = "shard_{unit}.csv"

[odometry]
purpose = "estimates motion"
unit = "shard"
in.frames = "frames.shard of previous and this"
out.odometry = "shard_{unit}.h5"

[grid]
purpose = "projects"
in.odometry = "odometry.odometry"
out.pgm = "map.pgm"
"""


class Declared(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.write("pipeline.toml", DECLARED)

    def write(self, name, text):
        path = self.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
        return path

    def declared(self, change=lambda text: text):
        path = self.folder / "pipeline.toml"
        path.write_text(change(path.read_text()))

    def graph(self, profile="default", imports=(), goals=("map",)):
        state = SiteState("office", str(self.folder / "office"), "data")
        state.lists["shard"], state.imports = ["0000", "0001"], dict.fromkeys(imports, "some/file")
        return Graph(read_pipeline(str(self.folder), profile, imports), state, goals)


class PipelineTest(Declared):
    def test_the_declared_pipeline_of_the_project(self):
        pipeline = read_pipeline(str(CONFIGS))
        programs = {path.parent.name for path in CONFIGS.parent.glob("stages/*/main.cc")}
        self.assertLessEqual(set(pipeline.programs()), programs)
        self.assertEqual({path.stem for path in (CONFIGS / "default").glob("*.toml")}, programs)

    def test_mistakes_name_the_file_and_the_job(self):
        for old, new, said in (
            ('purpose = "projects"\n', "", r"\[grid\] needs a purpose"),
            ('unit = "shard"', 'unit = "day"', "unit = .day. is none of site, shard, tile"),
            ("frames.shard of", "frames.shares of", "has no output"),
            ('"odometry.odometry"', '"odometri.odometry"', "no job 'odometri' before it"),
            ('"odometry.odometry"', '"odometry.poses"', "has no output 'poses'"),
            ("in.odometry", "inn.odometry", "unknown key 'inn'"),
            ("[grid]", "[grid", "not valid TOML"),
        ):
            with self.subTest(new):
                whole = (self.folder / "pipeline.toml").read_text()
                self.assertIn(old, whole)
                self.declared(lambda text: text.replace(old, new))
                with self.assertRaisesRegex(PipelineError, f"pipeline.toml: .*(?:{said})"):
                    read_pipeline(str(self.folder))
                (self.folder / "pipeline.toml").write_text(whole)

    def test_a_profile_fills_a_slot_and_leaves_a_job_out(self):
        self.write("imported/pipeline.toml", """
[odometry]
given = "poses"
leave_out = true
[grid]
given = "poses"
program = "import_grid"
in = {map = "import.map"}
""")
        default = self.graph("imported")
        self.assertEqual([job.program for job in default.jobs.values()], ["frames", "odometry", "grid"])
        graph = self.graph("imported", ("poses", "map"))
        self.assertEqual([job.program for job in graph.jobs.values()], ["frames", "import_grid"])
        self.assertEqual(graph.rules[-1].inputs, [("map", "data/some/file")])
        with self.assertRaisesRegex(PipelineError, r"\[grid\] needs a file of your own: .*office.toml(.|\n)*map = "):
            self.graph("imported", ("poses",))

    def test_rules_of_shards_read_the_one_before(self):
        rules = {rule.name: rule for rule in self.graph().rules}
        self.assertEqual(list(rules), ["frames", "odometry_0000", "odometry_0001", "grid"])
        names = [os.path.basename(path) for _, path in rules["odometry_0001"].inputs]
        self.assertEqual(names, ["shard_0000.csv", "shard_0001.csv"])
        self.assertEqual(len(rules["odometry_0000"].inputs), 1)


class InterruptedTest(Declared):
    def setUp(self):
        super().setUp()
        for rule in self.graph().rules:
            for port, path in rule.outputs:
                self.write(path, '{"config": "a = 1"}\n')
        for unit in ("0000", "0001"):
            self.write(f"office/frames/shard_{unit}.csv", "")
        self.grid = self.folder / "office/grid"

    def must_run(self):
        graph = self.graph()
        rules = RulesFile(graph, Times())
        return [rule.name for rule in graph.rules if rules.must_run(rule)]

    def set_time(self, name, seconds):
        os.utime(self.grid / name, (seconds, seconds))

    def test_a_run_that_was_killed_while_it_committed_runs_again(self):
        self.assertEqual(self.must_run(), [])
        for name in ("map.pgm", "report.json", "receipt.json"):
            self.set_time(name, 1000)
        self.set_time("map.pgm", 2000)
        self.assertEqual(self.must_run(), ["grid"])

    def test_a_lost_output_or_a_damaged_receipt(self):
        receipt = self.grid / "receipt.json"
        for content in ("", "{", "[]", "[" * 1000, "{}"):
            receipt.write_text(content)
            self.assertEqual(self.must_run(), ["grid"])
        receipt.unlink()
        os.mkfifo(receipt)
        self.assertEqual(self.must_run(), ["grid"])
        receipt.unlink()
        self.assertEqual(self.must_run(), ["grid"])

    def test_a_lost_file_of_a_list(self):
        (self.folder / "office/frames/shard_0001.csv").unlink()
        self.assertEqual(self.must_run(), ["frames"])

    def test_why_survives_damaged_reports(self):
        graph = self.graph()
        grid = graph.rules[-1]
        self.write("office/config/grid.toml", "a = 2\n")
        report = self.grid / "report.json"
        report.write_text(json.dumps({"config": "a = 1"}))
        self.assertEqual(why.config_change(graph.site, graph, grid), "options of grid changed: a 1 -> 2")
        for content in ("", "{", "5", '{"config": "="}', '{"config": 5}', "\0"):
            report.write_text(content)
            self.assertIsNone(why.config_change(graph.site, graph, grid))


class PreflightTest(unittest.TestCase):
    def texts(self, **values):
        return {name: preflight.ConfigText(config, "", dict.fromkeys(config, "SET"), {}) for name, config in values.items()}

    def check(self, condition, **values):
        preflight.check_clashes([{"when": condition, "remedy": "raise it"}], self.texts(**values))

    def test_a_clash_names_both_values(self):
        condition = "octree.max_range_m + 3 * octree.resolution_m > tiles.edge_m"
        values = {"octree": {"max_range_m": 4.0, "resolution_m": 0.05}, "tiles": {"edge_m": 24.0}}
        self.check(condition, **values)
        values["tiles"]["edge_m"] = 4.1
        with self.assertRaisesRegex(PipelineError, r"octree.max_range_m = 4.0 \(SET\).*tiles.edge_m = 4.1 \(SET\): raise it"):
            self.check(condition, **values)

    def test_only_arithmetic_is_evaluated(self):
        for condition in ("__import__('os').getcwd()", "[1]", "open('x')"):
            with self.assertRaises(PipelineError):
                self.check(condition)

    def test_room_on_the_disk(self):
        preflight.check_disk("/nowhere/maps", 1, "the map")
        with self.assertRaisesRegex(PipelineError, "are free, and the map needs about 1000000000000.00 GB"):
            preflight.check_disk("/nowhere/maps", 1e21, "the map")


if __name__ == "__main__":
    unittest.main()
