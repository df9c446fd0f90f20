# SPDX-License-Identifier: Apache-2.0
"""The declared pipeline and the rules of a site: mistakes in a declaration, profiles, runs that were interrupted."""

import json
import os
import struct
from pathlib import Path
from types import SimpleNamespace

from folder_case import FolderTest  # first: it makes scripts and benchmarks importable

import describe_pipeline
from nightmap_make import preflight, slots, why
from nightmap_make.clashes import check_clashes
from nightmap_make.graph import Graph
from nightmap_make.request import Asked
from nightmap_make.rules_file import RulesFile, Times
from nightmap_make.site_state import SiteState
from nightmap_site.needs import check_needs
from nightmap_site.pipeline import PipelineError, read_pipeline
from nightmap_site.site import CONFIGS
from nightmap_site.toml_file import read_toml

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


class Declared(FolderTest):
    def setUp(self):
        self.write("pipeline.toml", DECLARED)

    def declared(self, change=lambda text: text):
        self.write("pipeline.toml", change((self.folder / "pipeline.toml").read_text()))

    def graph(self, profile="default", imports=(), goals=("map",)):
        state = SiteState("office", str(self.folder / "office"), "data")
        state.lists["shard"], state.tables = ["0000", "0001"], {"import": dict.fromkeys(imports, "some/file")}
        return Graph(read_pipeline(str(self.folder), profile, imports), state, goals)


class PipelineTest(Declared):
    def test_lists_stand_for_the_inputs_by_hash(self):
        """The list of an input by hash is of the job that made it. Tests of such a list change all that its readers take:
        tests/labels/labelled_frames_test.cc, tests/stages/labels/moving/moving_test.cc, tests/e2e/people_test.py."""
        found = set()
        for imports in ((), ("model",)):
            for profile in (path.parent.name for path in CONFIGS.glob("*/pipeline.toml")):
                jobs = read_pipeline(str(CONFIGS), profile, imports).jobs
                by_hash = {(reference.job, reference.output) for job in jobs.values() for reference in job.inputs if reference.by_hash}
                self.assertLessEqual({job for job, _ in by_hash}, self.jobs_of_lists(jobs), profile)
                found |= by_hash
        self.assertEqual(found, {("features", "masks"), ("features", "labels"), ("moving", "masks"), ("labels", "labels"), ("ghosts", "masks")})

    def jobs_of_lists(self, jobs):
        """The job that makes the list of frames of the tiles, and those whose lists it hands on with what they added."""
        lists, readers = set(), ["tiles"] if "tiles" in jobs else []
        while readers:
            more = {reference.job for reference in jobs[readers.pop()].inputs if reference.output == "frames"}
            lists |= more
            readers += more
        return lists

    def test_the_declared_pipeline_of_the_project(self):
        pipeline = read_pipeline(str(CONFIGS))
        programs = {path.parent.name for path in CONFIGS.parent.glob("stages/*/*/main.cc")}
        self.assertLessEqual(set(pipeline.programs()), programs)
        defaults = [path.stem for path in CONFIGS.glob("*/default/*.toml")]
        of_jobs = {name for profile in CONFIGS.glob("*/pipeline.toml")
                   for name, program in read_pipeline(str(CONFIGS), profile.parent.name).options.items() if name != program}  # fmt: skip
        self.assertEqual(sorted(defaults), sorted(programs | of_jobs))  # each in one place

    def test_options_of_a_job(self):
        self.write("again/pipeline.toml", '[grid]\noptions = "fine_grid"\n[coarse]\npurpose = "projects"\nprogram = "grid"\n'
                                          'in.odometry = "odometry.odometry"\nout.pgm = "map.pgm"\n')  # fmt: skip
        graph = self.graph("again")
        self.assertEqual(graph.pipeline.options, {"frames": "frames", "odometry": "odometry", "fine_grid": "grid", "grid": "grid"})
        grid, coarse = (next(rule for rule in graph.rules if rule.name == name) for name in ("grid", "coarse"))
        rules, config = RulesFile(graph, Times()), self.folder / "office/config"
        self.assertEqual(rules.tool(grid), ["build/run/grid", f"{config}/fine_grid.toml"])
        self.assertEqual(rules.tool(coarse), ["build/run/grid", f"{config}/grid.toml"])
        self.assertEqual(self.graph().pipeline.options["grid"], "grid")

    def test_options_are_of_one_program(self):
        self.changed_options("odometry", r"again/pipeline.toml:2: \[grid\]: options \"odometry\" are those of odometry, and grid runs grid")
        for wrong in ("../grid", "", "Grid"):
            self.changed_options(wrong, r"again/pipeline.toml:2: \[grid\]: options = '.*' is no name of a file")

    def changed_options(self, options, said):
        self.write("again/pipeline.toml", f'[grid]\noptions = "{options}"\n')
        with self.subTest(options), self.assertRaisesRegex(PipelineError, said):
            self.graph("again")

    def test_mistakes_name_the_file_and_the_job(self):
        for old, new, said in (
            ('purpose = "projects"\n', "", r":15: \[grid\] needs a purpose"),
            ('unit = "shard"', 'unit = "day"', r":11: \[odometry\]: unit = .day. is none of site, shard"),
            ("frames.shard of", "frames.shares of", r":12: \[odometry\]: .* has no output"),
            ('"odometry.odometry"', '"odometri.odometry"', r":17: \[grid\]: in.odometry: no job 'odometri'"),
            ('"odometry.odometry"', '"odometry.poses"', "has no output 'poses'"),
            ('"odometry.odometry"', '"odometri.poses else odometry.odometry"', r":17: \[grid\]: in.odometry: no job 'odometri'"),
            ('"odometry.odometry"', '"odometry.poses else frames.shard"', "has no output 'poses'"),
            ('"odometry.odometry"', '"odometry else frames.shard"', "'odometry' is no reference"),
            ('"odometry.odometry"', "5", "in.odometry = 5 is no reference"),
            ("in.odometry", "inn.odometry", "unknown key 'inn'"),
            ('out.pgm', 'goal = "draw"\nout.pgm', r":18: \[grid\]: goal = .draw. is none of map; declare it"),
            ('out.pgm', 'stamp = "x"\nout.pgm', "none of recordings, pictures"),
            ('out.pgm', 'needs = ["depht"]\nout.pgm', r":18: \[grid\]: needs = \['depht'\] is no list of depth"),
            ('out.pgm', 'needs = "depth"\nout.pgm', "is no list of depth, one camera"),
            ('out.pgm', 'when = "a b"\nout.pgm', "no key of a site's config"),
            ('out.pgm', 'lists = "shard"\nout.pgm', "job 'frames' lists each shard already"),
            ('in.odometry', 'in.shards = "grid.pgm"\nin.odometry', "each of these jobs reads the one before it: grid -> grid"),
            ('unit = "shard"\n', 'unit = "shard"\nin.grid = "grid.pgm"\n', "odometry -> grid -> odometry"),
            ("[grid]", "[grid", "not valid TOML"),
            ("[frames]", "grids = 5\n[frames]", r": \[grids\] must be a table"),
            ('out.pgm = "map.pgm"', 'out = "map.pgm"', r": \[grid\] must be a table"),
        ):
            with self.subTest(new):
                whole = (self.folder / "pipeline.toml").read_text()
                self.assertIn(old, whole)
                self.declared(lambda text: text.replace(old, new))
                with self.assertRaisesRegex(PipelineError, f"pipeline.toml.*(?:{said})"):
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
in = {odometry = false, map = "import.map"}
""")
        default = self.graph("imported")
        self.assertEqual([job.program for job in default.jobs.values()], ["frames", "odometry", "grid"])
        graph = self.graph("imported", ("poses", "map"))
        self.assertEqual([job.program for job in graph.jobs.values()], ["frames", "import_grid"])
        self.assertEqual(graph.rules[-1].inputs, [("map", "data/some/file")])
        with self.assertRaisesRegex(PipelineError, r"\[grid\] needs a file of your own: .*office.toml(.|\n)*map = "):
            self.graph("imported", ("poses",))

    def test_a_profile_says_why_it_leaves_a_job_out(self):
        self.write("bare/pipeline.toml", '[grid]\nleave_out = "it needs a laser"\n')
        self.assertNotIn("grid", read_pipeline(str(self.folder), "bare").jobs)
        self.assertEqual(read_pipeline(str(self.folder), "bare").goals["map"].why_without, "it needs a laser")
        self.assertIsNone(read_pipeline(str(self.folder)).goals["map"].why_without)

    def test_several_tables_of_a_job_are_applied_one_after_the_other(self):
        tables = """
[[odometry]]
program = "scan_match"
unit = "site"
in.frames = "frames.shards"

[[odometry]]
given = "poses"
leave_out = true

[[grid]]
program = "laser_grid"

[[grid]]
given = "poses"
in = {odometry = false, map = "import.poses"}
"""
        path = self.write("laser/pipeline.toml", tables)
        graph = self.graph("laser")
        self.assertEqual([job.program for job in graph.jobs.values()], ["frames", "scan_match", "laser_grid"])
        self.assertEqual([port for port, _ in graph.rules[-1].inputs], ["odometry"])
        graph = self.graph("laser", ("poses",))
        self.assertEqual([job.program for job in graph.jobs.values()], ["frames", "laser_grid"])
        self.assertEqual(graph.rules[-1].inputs, [("map", "data/some/file")])
        path.write_text(tables.replace('map = "import.poses"', 'map = "grids.map"'))
        with self.assertRaisesRegex(PipelineError, r"laser/pipeline.toml:16: \[grid\]: in.map: no job 'grids'"):
            self.graph("laser", ("poses",))

    def test_else_reads_the_first_job_that_the_profile_leaves(self):
        self.declared(lambda text: text.replace('"odometry.odometry"', '"odometry.odometry else frames.shard"'))
        self.write("posed/pipeline.toml", "[odometry]\nleave_out = true\n")
        names = [[Path(path).name for path in self.graph(profile).rules[-1].inputs[0][1].paths] for profile in ("default", "posed")]
        self.assertEqual(names, [["shard_0000.h5", "shard_0001.h5"], ["shard_0000.csv", "shard_0001.csv"]])

    def test_a_file_beside_a_list_is_made_with_it_before_there_is_a_list(self):
        self.declared(lambda text: text.replace('"odometry.odometry"', '"frames.scans"').replace(
            '[odometry]', 'beside.scans = "scans.h5"\n[odometry]'))  # fmt: skip
        graph = self.graph()
        scans, shards = (f"{self.folder}/office/frames/{name}" for name in ("scans.h5", "shards.txt"))
        self.assertEqual(graph.files_beside(graph.jobs["frames"]), [scans])
        self.assertIn(f"\n{scans}: | {shards} ;\n", RulesFile(graph, Times()).text())

    def test_a_profile_adds_a_port_and_keeps_the_others(self):
        self.write("more/pipeline.toml", '[odometry]\nin.wheels = "frames.shards"\nkB_per_frame = 3\n')
        odometry = self.graph("more").jobs["odometry"]
        self.assertEqual([reference.port for reference in odometry.inputs], ["frames", "wheels"])
        self.assertEqual((odometry.outputs, odometry.kB_per_frame), ({"odometry": "shard_{unit}.h5"}, 3))

    def test_a_profile_inserts_a_job_before_its_readers(self):
        self.write("people/pipeline.toml", """
[masks]
purpose = "where things move"
unit = "shard"
in.labels = "labels.labels"
out.masks = "shard_{unit}.h5"
[labels]
purpose = "what is where"
unit = "shard"
in.frames = "frames.shard"
out.labels = "shard_{unit}.h5"
[odometry]
in.masks = "masks.masks"
""")
        self.assertEqual(list(self.graph("people").jobs), ["frames", "labels", "masks", "odometry", "grid"])
        self.write("circle/pipeline.toml", '[frames]\nin.grid = "grid.pgm"\n')
        with self.assertRaisesRegex(PipelineError, r"circle/pipeline.toml:1: .*frames -> odometry -> grid -> frames|"
                                                   r"frames -> grid -> odometry -> frames"):  # fmt: skip
            self.graph("circle")

    def test_files_of_another_kind_of_unit(self):
        rooms = """
[rooms]
purpose = "lists rooms"
lists = "room"
in.grid = "grid.pgm"
out.rooms = "rooms.txt"
[draw]
purpose = "draws a room"
unit = "room"
in.odometry = "odometry.odometry{}"
out.png = "room_{{unit}}.png"
"""
        self.write("rooms/pipeline.toml", rooms.format(""))
        with self.assertRaisesRegex(PipelineError, r"rooms/pipeline.toml:10: \[draw\]: in.odometry: odometry.odometry has a file per shard, "
                                                   r"and draw runs per room: \"odometry.odometry of all\" reads all"):  # fmt: skip
            self.graph("rooms")
        self.write("rooms/pipeline.toml", rooms.format(" of near").replace('unit = "room"', 'unit = "shard"'))
        with self.assertRaisesRegex(PipelineError, "only tiles are near each other"):
            self.graph("rooms")
        self.write("rooms/pipeline.toml", rooms.format(" of all"))
        pipeline = read_pipeline(str(self.folder), "rooms")
        self.write("office/rooms/rooms.txt", "nightmap rooms, version 1, 2 names\nhall\nkitchen\n")
        state = SiteState("office", str(self.folder / "office"), "data")
        state.lists["shard"] = ["0000", "0001"]
        told = []
        state.read_lists(pipeline, told.append)
        self.assertEqual(told, [])
        rules = {rule.name: rule for rule in Graph(pipeline, state, ["map"]).rules}
        self.assertIn("draw_kitchen", rules)
        self.assertEqual([os.path.basename(path) for path in rules["draw_hall"].inputs[0][1].paths], ["shard_0000.h5", "shard_0001.h5"])
        for damaged in ("hall\nhall\n", "../hall\nx\n", "a b\nx\n", "hall\n"):
            self.write("office/rooms/rooms.txt", f"nightmap rooms, version 1, 2 names\n{damaged}")
            state.read_lists(pipeline, told.append)
            self.assertEqual((state.damaged, len(told)), ({"rooms"}, 1), damaged)
            told.clear()

    def test_a_job_for_sites_with_a_key(self):
        self.write("people/pipeline.toml", """
[labels]
purpose = "what is where"
when = "import.model"
in.model = "import.model"
out.labels = "labels.h5"
[grid]
in.labels = "labels.labels if made"
""")
        self.assertNotIn("labels", self.graph("people").jobs)
        graph = self.graph("people", ("model",))
        self.assertEqual(list(graph.jobs), ["frames", "odometry", "labels", "grid"])
        self.assertEqual(graph.rules[-1].inputs[-1], ("labels", f"{self.folder}/office/labels/labels.h5"))

    def test_rules_of_shards_read_the_one_before(self):
        rules = {rule.name: rule for rule in self.graph().rules}
        self.assertEqual(list(rules), ["frames", "odometry_0000", "odometry_0001", "grid"])
        names = [os.path.basename(path) for _, path in rules["odometry_0001"].inputs]
        self.assertEqual(names, ["shard_0000.csv", "shard_0001.csv"])
        self.assertEqual(len(rules["odometry_0000"].inputs), 1)


class ListedPortTest(Declared):
    """A port that takes a list: files of several jobs, in their order."""

    PROFILE = """
[loops]
purpose = "finds places again"
in.frames = "frames.shards"
out.edges = "edges.h5"
[grid]
in.odometry = false
in.edges = ["odometry.odometry", "loops.edges"]
"""

    def setUp(self):
        super().setUp()
        self.write("laser/pipeline.toml", self.PROFILE)

    def changed(self, old, new):
        self.assertIn(old, self.PROFILE)
        self.write("laser/pipeline.toml", self.PROFILE.replace(old, new))

    def grid(self):
        graph = self.graph("laser")
        return graph, next(rule for rule in graph.rules if rule.name == "grid")

    def test_rules_name_the_files_of_both_jobs(self):
        graph, grid = self.grid()
        self.assertEqual([job.name for job in graph.jobs.values()], ["frames", "odometry", "loops", "grid"])
        (first, shards), (second, loops) = grid.inputs
        self.assertEqual((first, second), ("edges", "edges"))
        self.assertEqual([Path(path).name for path in shards.paths], ["shard_0000.h5", "shard_0001.h5"])
        self.assertEqual(loops, f"{graph.site.folder}/loops/edges.h5")
        text = RulesFile(graph, Times()).text()
        command = text[text.index("# grid: "):].split("--out")[0]
        self.assertLess(command.index("--in-list edges="), command.index(f"--in edges={loops}"))
        before = RulesFile(graph, Times()).prerequisites(grid)
        self.assertLessEqual({loops, "$(odometry.odometry)", f"{graph.site.folder}/lists/shards.txt"}, set(before))

    def test_a_profile_replaces_the_list_and_takes_it_away(self):
        self.changed('["odometry.odometry", "loops.edges"]', '"loops.edges"')
        self.assertEqual([port for port, _ in self.grid()[1].inputs], ["edges"])
        self.changed('["odometry.odometry", "loops.edges"]', "false")
        self.assertEqual(self.grid()[1].inputs, [])

    def test_a_mistake_in_the_second_names_its_line(self):
        for new, said in (("loops.edgs", r"\[grid\]: in.edges: job 'loops' has no output 'edgs'"),
                          ("lops.edges", r"\[grid\]: in.edges: no job 'lops'"),
                          ("loops", r"\[grid\]: in.edges = 'loops' is no reference")):
            with self.subTest(new):
                self.changed('"loops.edges"', f'"{new}"')
                with self.assertRaisesRegex(PipelineError, f"laser/pipeline.toml:8: {said}"):
                    self.graph("laser")
        self.changed('"loops.edges"', "5")
        with self.assertRaisesRegex(PipelineError, r"laser/pipeline.toml:8: \[grid\]: in.edges = 5 is no reference"):
            self.graph("laser")

    def test_a_job_reads_nothing_of_a_later_one_in_its_list(self):
        self.changed('in.frames = "frames.shards"', 'in.frames = ["frames.shards", "grid.pgm"]')
        with self.assertRaisesRegex(PipelineError, "each of these jobs reads the one before it"):
            self.graph("laser")

    def test_the_table_and_the_drawing_show_both(self):
        pipeline = read_pipeline(str(self.folder), "laser")
        self.assertIn("| odometry.odometry, loops.edges |", describe_pipeline.row(pipeline.jobs["grid"]))
        drawing = describe_pipeline.drawing(pipeline)
        self.assertIn("odometry --> grid", drawing)
        self.assertIn("loops --> grid", drawing)

    def difference(self, *names, config=""):
        """What the slot says of a run whose edges were these files; config: what the run's receipt has."""
        graph, grid = self.grid()
        paths = dict(grid.outputs)
        for path in paths.values():
            self.write(path, "")
        self.write(graph.site.config_of(grid.job), "")
        self.write(paths["receipt"], json.dumps({
            "stage": "grid", "start_time": "2026-01-01T00:00:00Z", "config": config,
            "inputs": [{"name": "edges", "path": f"maps/office/{name}", "xxh3": "0"} for name in names],
            "outputs": [{"path": path} for path in paths.values()]}))  # fmt: skip
        return slots.change(graph, grid)

    def test_a_receipt_fits_the_slot_with_both_files_in_their_order(self):
        shards, loops = ("odometry/shard_0000.h5", "odometry/shard_0001.h5"), "loops/edges.h5"
        self.assertIsNone(self.difference(*shards, loops))
        self.assertEqual(self.difference(*shards), "in.edges was not given")
        self.assertEqual(self.difference(), "in.edges was not given")
        self.assertEqual(self.difference(loops), "in.edges: maps/office/loops/edges.h5 -> odometry.odometry")
        self.assertEqual(self.difference(loops, *shards), "in.edges: maps/office/loops/edges.h5 -> odometry.odometry")
        self.assertEqual(self.difference(*shards, "wheels/edges.h5"), "in.edges: maps/office/wheels/edges.h5 -> loops.edges")
        self.assertEqual(self.difference(*shards, loops, "wheels/edges.h5"), "in.edges: maps/office/wheels/edges.h5 -> loops.edges")

    def test_a_receipt_of_other_options_does_not_fit_the_slot(self):
        made_by = "odometry/shard_0000.h5", "odometry/shard_0001.h5", "loops/edges.h5"
        self.assertIsNone(self.difference(*made_by))
        self.assertIsNone(self.difference(*made_by, config="# said otherwise"))
        self.assertEqual(self.difference(*made_by, config="size = 2"), "options are not those of grid")

    def test_the_slot_changes_with_the_list(self):
        def text():
            graph, _ = self.grid()
            slots.settle(graph)
            return Path(slots.slot_path(graph.site, graph.jobs["grid"])).read_text()

        both = text()
        self.assertEqual(both, "program grid\noptions grid\nin.edges odometry.odometry\nin.edges loops.edges\n")
        self.changed('"odometry.odometry", "loops.edges"', '"loops.edges", "odometry.odometry"')
        self.assertNotEqual(text(), both)


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


class NeedsTest(Declared):
    SITE = 'profile = "x"\n\n[[sequence]]\nfolder = "a"\n%s\n[[sequence]]\nfolder = "b"\n%s\n'

    def check(self, first, second, *jobs):
        site = self.write("office.toml", self.SITE % (first, second))
        check_needs([SimpleNamespace(name=name, needs=needs) for name, needs in jobs], read_toml(site).get("sequence", []), str(site))

    def test_depth_that_no_recording_has_is_refused_once_with_places_jobs_and_remedy(self):
        none = 'depth = "none"'
        jobs = ("features", []), ("odometry", ["depth"]), ("octree", ["depth"])
        with self.assertRaisesRegex(PipelineError, r"office.toml:3, .*office.toml:6: no recording has depth \(depth = .none.\), which odometry, "
                                                   r"octree need: record depth, or choose a profile without these jobs"):  # fmt: skip
            self.check(none, none, *jobs)
        self.check(none, "", *jobs)
        self.check('depth = "optional"', none, *jobs)
        self.check(none, none, ("features", []))
        check_needs([SimpleNamespace(name="odometry", needs=["depth"])], [], "a site of signals")

    def test_cameras_that_record_at_once_are_refused_for_jobs_of_one_camera(self):
        jobs = ("features", []), ("odometry", ["depth", "one camera"])
        with self.assertRaisesRegex(PipelineError, r"office.toml:3, .*office.toml:6: cameras of a rig record at once, which odometry cannot use: "
                                                   r"keep one \[\[sequence\]\] of each rig"):  # fmt: skip
            self.check('rig = "head"', 'rig = "head"', *jobs)
        self.check('rig = "head"', 'rig = "feet"', *jobs)
        self.check('rig = "head"', "", *jobs)
        self.check('rig = "head"', 'rig = "head"', ("features", []))


def box(kind, *parts):
    content = b"".join(parts)
    return struct.pack(">I4s", 8 + len(content), kind) + content


def track_of_mp4(header, num_samples):
    samples = box(b"stbl", box(b"stsz", struct.pack(">III", 0, 0, num_samples)))
    return box(b"trak", box(b"tkhd", bytes(84)), box(b"mdia", box(b"minf", box(header, bytes(12)), samples)))


class PreflightTest(FolderTest):
    def texts(self, **values):
        return {name: preflight.ConfigText(name, config, "", dict.fromkeys(config, "SET"), {}, {}) for name, config in values.items()}

    def check(self, condition, **values):
        check_clashes([{"when": condition, "remedy": "raise it"}], self.texts(**values))

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

    def test_results_tell_what_a_frame_takes(self):
        asked = Asked.__new__(Asked)
        jobs = [SimpleNamespace(folder=name, kB_per_frame=size) for name, size in (("features", 90), ("octree", 12), ("octree", 12))]
        asked.folder = self.folder
        self.assertEqual(asked._bytes_per_frame(jobs), 114_000)
        for name in ("frames", "features/deep"):
            os.makedirs(f"{self.folder}/{name}")
        Path(f"{self.folder}/features/deep/shard_0000.h5").write_bytes(bytes(200_000))
        Path(f"{self.folder}/frames/report.json").write_text('{"num_frames": 10}')
        self.assertEqual(asked._bytes_per_frame(jobs), 114_000)  # too few frames
        Path(f"{self.folder}/frames/report.json").write_text('{"num_frames": 200}')
        self.assertEqual(asked._bytes_per_frame(jobs), 1.2 * 1000 + 24_000)

    def test_room_counts_the_frames_of_recordings_without_depth(self):
        movie = box(b"moov", track_of_mp4(b"smhd", 4000), track_of_mp4(b"vmhd", 700))
        files = {"a.mp4": box(b"ftyp", bytes(8)) + struct.pack(">I4sQ", 1, b"mdat", 16 + 5000) + bytes(5000) + movie, "a.avi": b"RIFF" + bytes(4) +
                 b"AVI " + bytes(36) + struct.pack("<I", 90), "a.mkv": b"\x1aE\xdf\xa3" + bytes(499_996), "cut.mp4": movie[:-2],
                 "rgb.txt": b"# time\n0.1 a.png\n\n0.2 b.png\n", "x.color.png": b"", "x.depth.png": b""}  # fmt: skip
        asked = Asked.__new__(Asked)
        os.mkdir(f"{self.folder}/office")
        for name, content in files.items():
            Path(f"{self.folder}/office/{name}").write_bytes(content)
        asked.request = SimpleNamespace(reads_recordings=True, is_synthetic=False)
        asked.env, asked.configs = {"DATA": self.folder}, {"frames": {}}
        for count, sequence in ((700, {"layout": "video", "video": "a.mp4"}), (90, {"layout": "video", "video": "a.avi"}),
                                (10, {"layout": "video", "video": "a.mkv"}), (0, {"layout": "video", "video": "cut.mp4"}),
                                (0, {"layout": "video", "video": "none.mp4"}), (2, {"layout": "tum"}), (1, {"layout": "seven_scenes"})):
            asked.tables = {"root": "office", "sequence": [sequence | {"folder": ".", "depth": "none"}] * 2}
            self.assertEqual(asked._num_recorded(), 2 * count, sequence)
        os.rename(f"{self.folder}/office/rgb.txt", f"{self.folder}/office/associations.txt")
        asked.tables["sequence"] = [{"layout": "tum", "folder": "."}]
        self.assertEqual(asked._num_recorded(), 2)
        asked.tables["sequence"] = [{"layout": "video", "folder": ".", "video": "a.mp4"}]
        asked.configs["frames"]["max_frames"] = 50
        self.assertEqual(asked._num_recorded(), 50)
        asked.request.reads_recordings = False
        self.assertEqual(asked._num_recorded(), 0)

    def test_room_counts_the_frames_that_synthesize_renders(self):
        asked = Asked.__new__(Asked)
        asked.request = SimpleNamespace(reads_recordings=True, is_synthetic=True)
        for made_up, count in (({"num_frames": 700}, 700), ({"num_frames": 700, "render": True}, 700), ({"num_frames": 700, "render": False}, 0)):
            asked.configs = {"frames": {}, "synthesize": made_up}
            self.assertEqual(asked._num_recorded(), count, made_up)

    def test_room_on_the_disk(self):
        preflight.check_disk("/nowhere/maps", 1, "the map")
        with self.assertRaisesRegex(PipelineError, "are free, and the map needs about 1000000000000.00 GB"):
            preflight.check_disk("/nowhere/maps", 1e21, "the map")
