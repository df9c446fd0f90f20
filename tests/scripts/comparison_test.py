# SPDX-License-Identifier: Apache-2.0
"""Alignment of COLMAP's models, which of them are used, and evaluate_colmap.py on what COLMAP left."""

import csv
import json
import shutil

import numpy as np

import fake_colmap
import fake_site
from fake_site import moved, rotation_about, walk
from folder_case import FolderTest, SiteFolderTest
from nightmap_eval.colmap.colmap_files import read_model
from nightmap_eval.colmap.colmap_run import MAPPER_RUNS, RUNS
from nightmap_eval.colmap.comparison import Part, fit_to_map, locate_by_models, matched, model_trajectory, summaries
from nightmap_eval.colmap.report_comparison import comparison_section
from nightmap_site.job_results import folders_up_to
from nightmap_site.site import Site

STEPS = ("features", "matches", "triangulate", "queries", "queries_default", *MAPPER_RUNS,
         *(run.register_step for run in RUNS))  # fmt: skip
MAP_NAMES = [f"rgb/{i}.png" for i in range(fake_site.NUM_FRAMES)]
QUERIES = walk(11).select(range(10))
QUERIES.times_ns = QUERIES.times_ns + 5
QUERY_NAMES = [f"queries/{i}.png" for i in range(10)]
MAP_TIMES = dict(zip(MAP_NAMES, walk().times_ns.tolist()))
QUERY_TIMES = dict(zip(QUERY_NAMES, QUERIES.times_ns.tolist()))


def joined(a, b):
    return fake_site.Trajectory(*(np.concatenate(pair) for pair in (
        (a.times_ns, b.times_ns), (a.positions_m, b.positions_m), (a.quaternions, b.quaternions))))  # fmt: skip


def write_model(folder, frames, queries=range(10), num_observations=50, bend=None):
    """A model of some map frames and queries; `bend` spoils it."""
    names = [MAP_NAMES[i] for i in frames] + [QUERY_NAMES[i] for i in queries]
    poses = fake_colmap.in_colmaps_world(joined(walk().select(frames), QUERIES.select(queries)))
    if bend is not None:
        bend(poses)
    fake_colmap.write_model(folder, names, poses, num_observations)


def scatter(poses):
    poses.positions_m = np.random.default_rng(1).permutation(poses.positions_m)


class ModelsTest(FolderTest):
    def setUp(self):
        self.models, self.mapped = self.folder / "models", None

    def locate(self):
        return locate_by_models(
            "colmap_mapper", self.mapped or self.models, self.models, MAP_TIMES, QUERY_TIMES, walk()
        )

    def test_a_model_is_put_on_the_metric_map_by_its_map_cameras(self):
        write_model(self.models / "0", range(40))
        located = self.locate()
        self.assertAlmostEqual(located.models[0]["metres_per_unit"], 1 / fake_colmap.UNITS_PER_METRE, places=9)
        queries, truth = matched(located.parts[0].queries, QUERIES)
        self.assertEqual(len(queries), 10)
        np.testing.assert_allclose(queries.positions_m, truth.positions_m, atol=1e-9)
        figures = summaries(located, Part(walk(), QUERIES))
        for protocol in ("global", "local"):
            self.assertEqual(figures[protocol]["recall_1cm_1deg_percent"], 100)

    def test_a_model_that_does_not_fit_is_told_and_not_used(self):
        write_model(self.models / "0", range(40), bend=scatter)
        write_model(self.models / "1", range(20), queries=range(4))
        located = self.locate()
        self.assertEqual([model["fits"] for model in located.models], [False, True])
        self.assertIn("% of its map cameras", located.models[0]["reason"])
        self.assertEqual(located.num_located(), 4)
        shutil.rmtree(self.models / "1")
        self.assertIn("no model fits", self.locate().failed)

    def test_mirrored_looks_alone_do_not_fit(self):
        def turn_around(poses):
            flip = rotation_about([0, 0, 1], np.pi)
            turned = [fake_site.quaternion(r @ flip) for r in poses.rotations()]
            poses.quaternions = np.array(turned)

        write_model(self.models / "0", range(40), bend=turn_around)
        self.assertFalse(self.locate().models[0]["fits"])

    def test_too_few_map_cameras_do_not_fit(self):
        write_model(self.models / "0", range(2))
        located = self.locate()
        self.assertFalse(located.models[0]["fits"])
        self.assertIn("at least 3", located.models[0]["reason"])

    def test_a_query_counts_in_the_model_where_it_sees_most(self):
        write_model(self.models / "0", range(30), queries=range(6), num_observations=20)
        write_model(self.models / "1", range(10, 40), queries=range(4, 10), num_observations=30)
        located = self.locate()
        counts = [part.queries.times_ns.tolist() for part in located.parts]
        self.assertEqual(counts[0], QUERIES.times_ns[:4].tolist())
        self.assertEqual(counts[1], QUERIES.times_ns[4:].tolist())
        self.assertEqual(len(located.merged().queries), 10)
        self.assertEqual(len(located.merged().map_frames), 40)

    def test_map_images_that_were_registered_with_the_queries_are_no_map_frames(self):
        self.mapped = self.models.with_name("mapped")
        write_model(self.mapped / "0", range(30), queries=[])
        write_model(self.models / "0", range(40))
        located = self.locate()
        self.assertEqual(located.models[0]["num_map_frames"], 30)
        self.assertEqual(len(located.parts[0].map_frames), 30)

    def test_models_are_taken_in_order_of_number(self):
        for name in ("10", "2"):
            write_model(self.models / name, range(40))
        self.assertEqual([model["model"] for model in self.locate().models], ["2", "10"])

    def test_queries_take_no_part_in_the_fit(self):
        def move_queries(poses):
            poses.positions_m[40:] += 0.4 * fake_colmap.TURN @ [0, 0, 1.0]

        write_model(self.models / "0", range(40), bend=move_queries)
        located = self.locate()
        self.assertAlmostEqual(located.models[0]["rmse_to_map_cm"], 0, places=6)
        figures = summaries(located, Part(walk(), QUERIES))
        self.assertAlmostEqual(figures["global"]["median_translation_error_cm"], 100)
        self.assertEqual(figures["global"]["num_wrong"], 10)

    def test_fit_of_frames_without_pose_in_the_map(self):
        write_model(self.models / "0", range(40))
        model = read_model(self.models / "0")
        similarity, figures = fit_to_map(model_trajectory(model, MAP_TIMES), walk().select([]))
        self.assertIsNone(similarity)
        self.assertFalse(figures["fits"])


class EvaluateColmapTest(SiteFolderTest):
    def setUp(self):
        self.colmap = self.site_dir / "evaluate_colmap"
        fake_site.write_site(self.site_dir)
        map_from_truth = (rotation_about([0, 0, 1], 0.5), np.array([1.0, -2.0, 0.0]))
        located = moved(QUERIES.select(range(8)), *map_from_truth)
        fake_site.write_queries(self.site_dir, located, 0)
        text = (self.site_dir / "localize" / "queries.csv").read_text()
        failed = [f"{i},{QUERIES.times_ns[i]},queries/{i}.png,no_features,no_features,,,,,,,,,," for i in (8, 9)]
        (self.site_dir / "localize" / "queries.csv").write_text(text + "\n".join(failed) + "\n")
        fake_site.write_tum(self.site_dir / "queries" / "query_ground_truth.tum", QUERIES)
        for stage in folders_up_to("localize"):
            fake_site.write_receipt(self.site_dir, stage)
        (self.site_dir / "landmarks" / "landmarks.h5").write_bytes(bytes(1000))
        (self.site_dir / "vocabulary" / "vocabulary.h5").write_bytes(bytes(500))
        (self.site_dir / "landmarks" / "report.json").write_text('{"num_landmarks": 7}')
        for step in STEPS:
            fake_colmap.write_receipt(self.colmap / step, parts=[(f"tool_{step}", 2.0)], matching="exhaustive")
        (self.colmap / "matches" / "database.db").write_bytes(bytes(300))
        # The second of the mapper's runs is the one in the middle, with 6.
        for made, num_queries in (*((step, 0) for step in MAPPER_RUNS), ("triangulate", 0),
                                  ("register_mapper_1", 5), ("register_mapper_2", 6), ("register_mapper_3", 7),
                                  ("register_triangulate", 6), ("register_held", 7)):  # fmt: skip
            write_model(self.colmap / made / "models" / "0", range(40), queries=range(num_queries))
        for step in ("queries_default", *(run.register_step for run in RUNS if run.queries_step == "queries_default")):
            fake_colmap.write_receipt(self.colmap / step, skipped="all frames are matched")

    def evaluate(self, *more):
        out = self.colmap / "results.json"
        result = fake_site.run("evaluate_colmap.py", "--site-dir", self.site_dir, "--out", out, *more)
        self.assertEqual(result.returncode, 0, result.stderr)
        return json.loads(out.read_text()), result.stdout

    def read_csv(self, name):
        return list(csv.DictReader((self.colmap / name).read_text().splitlines()))

    def test_figures_of_all_methods(self):
        results, table = self.evaluate()
        nightmap, mapper = (results["methods"][name] for name in ("nightmap", "colmap_mapper"))
        self.assertEqual((nightmap["num_located"], nightmap["num_refused"]), (8, 2))
        self.assertEqual((mapper["num_located"], mapper["num_refused"]), (6, 4))
        for protocol in ("global", "local"):
            self.assertEqual(nightmap["against"]["truth"][protocol]["recall_1cm_1deg_percent"], 80)
            self.assertEqual(mapper["against"]["truth"][protocol]["recall_1cm_1deg_percent"], 60)
            # Nightmap located 8: of these the others have 6.
            self.assertEqual(mapper["against"]["nightmap"][protocol]["recall_1cm_1deg_percent"], 75)
        self.assertEqual(mapper["map_time_s"], 6)
        self.assertEqual(mapper["time_per_query_s"], 0.4)
        self.assertEqual(nightmap["map_time_s"], len(folders_up_to("landmarks")) * 12.5)
        for name in ("colmap_triangulate", "colmap_held"):  # the same map
            self.assertEqual(results["methods"][name]["map_time_s"], 6 + len(folders_up_to("map_frame")) * 12.5)
        self.assertEqual(nightmap["map_size_bytes"], 1500)
        self.assertGreater(mapper["map_size_bytes"], 300)
        self.assertIn("| located | 8 | 6 | 6 | 7 |", table)

    def test_of_several_runs_of_the_mapper_the_one_in_the_middle_counts_and_each_is_told(self):
        results, table = self.evaluate()
        mapper = results["methods"]["colmap_mapper"]
        self.assertEqual(mapper["map"], "mapper_2")
        self.assertEqual([run["num_located"] for run in mapper["runs"]], [5, 6, 7])
        self.assertIn("| located, per run |  | 5, 6, 7 |  |  |", table)
        fake_colmap.write_receipt(self.colmap / "register_mapper_3", failed="out of memory")
        mapper = self.evaluate()[0]["methods"]["colmap_mapper"]
        self.assertEqual((mapper["map"], mapper["num_located"]), ("mapper_1", 5))
        self.assertEqual(mapper["runs"][2]["failed"], "out of memory")

    def test_the_default_number_of_retrieved_images_is_a_method_of_its_own(self):
        fake_colmap.write_receipt(self.colmap / "queries_default", matching="with the 100 most similar")
        fake_colmap.write_receipt(self.colmap / "register_held_default")
        write_model(self.colmap / "register_held_default" / "models" / "0", range(40), queries=range(9))
        results, table = self.evaluate()
        self.assertEqual(list(results["methods"])[1:],
                         ["colmap_mapper", "colmap_triangulate", "colmap_held", "colmap_held_default"])  # fmt: skip
        self.assertIn("| located | 8 | 6 | 6 | 7 | 9 |", table)
        self.assertIn("with the 100 most similar", " ".join(results["setting"]))

    def test_search_registration_and_adjustment_are_timed_apart(self):
        parts = [("feature_extractor", 1.0), ("vocab_tree_retriever", 2.0), ("matches_importer", 3.0)]
        fake_colmap.write_receipt(self.colmap / "queries", parts=parts, matching="exhaustive")
        parts = [("image_registrator", 4.0), ("bundle_adjuster", 5.0)]
        fake_colmap.write_receipt(self.colmap / "register_triangulate", parts=2 * parts)
        fake_colmap.write_receipt(self.colmap / "register_held", parts=[("mapper", 6.0)])
        results, table = self.evaluate()
        self.assertEqual(results["methods"]["colmap_triangulate"]["query_phases_s"],
                         {"features": 0.1, "search": 0.5, "registration": 0.8, "adjustment": 1.0})  # fmt: skip
        self.assertEqual(results["methods"]["colmap_held"]["query_phases_s"]["registration"], 0.6)
        self.assertRegex(table, r"\| adjustment per query \(s\) \| in search \| 0.000 \| 1.000 \| in registration \|")

    def test_cpu_time_is_told_where_every_receipt_has_it(self):
        results, table = self.evaluate()
        self.assertIn("| time per query (CPU s) | n/a | n/a | n/a | n/a |", table)
        for path in [self.site_dir / "localize" / "receipt.json",
                     *self.colmap.glob("queries/receipt.json"), *self.colmap.glob("register_*/receipt.json")]:  # fmt: skip
            receipt = json.loads(path.read_text())
            receipt["cpu_time_s"] = 20.0
            for part in receipt["parts"]:
                part["cpu_time_s"] = 30.0
            path.write_text(json.dumps(receipt))
        results, _ = self.evaluate()
        self.assertEqual(results["methods"]["nightmap"]["cpu_time_per_query_s"], 2)
        parts = results["methods"]["colmap_mapper"]["query_parts_s"]
        self.assertEqual(results["methods"]["colmap_mapper"]["cpu_time_per_query_s"], 3 * len(parts))

    def test_writing_the_map_for_colmap_is_no_time_of_nightmap(self):
        path = self.site_dir / "landmarks" / "receipt.json"
        receipt = json.loads(path.read_text())
        receipt["parts"] += [{"name": "write", "wall_time_s": 1.0}, {"name": "export", "wall_time_s": 4.0}]
        path.write_text(json.dumps(receipt))
        results, _ = self.evaluate()
        nightmap = results["methods"]["nightmap"]
        self.assertEqual(nightmap["map_parts_s"]["landmarks"], 8.5)
        self.assertEqual(nightmap["map_time_s"], len(folders_up_to("landmarks")) * 12.5 - 4)

    def test_tables_and_plots_are_beside_the_results(self):
        results, _ = self.evaluate()
        rows = self.read_csv("summary.csv")
        self.assertEqual(len(rows), 4 * 4 * 2)  # each against the truth and the three others, two protocols
        queries = self.read_csv("queries.csv")
        self.assertEqual(len(queries), 10)
        self.assertEqual([row["colmap_mapper_status"] for row in queries].count("located"), 6)
        self.assertLess(float(queries[0]["nightmap_local_error_cm"]), 0.01)
        self.assertEqual(queries[9]["nightmap_global_error_cm"], "")
        for name in results["plots"]:
            self.assertEqual((self.colmap / name).read_bytes()[:4], b"\x89PNG")
        self.assertEqual(len(results["plots"]), 3)

    def test_a_failed_variant_is_told_and_the_other_counts(self):
        for step in MAPPER_RUNS:
            fake_colmap.write_receipt(self.colmap / f"register_{step}", failed="colmap mapper: no model")
        results, table = self.evaluate()
        self.assertEqual(results["methods"]["colmap_mapper"]["failed"], "colmap mapper: no model")
        self.assertEqual(results["methods"]["colmap_triangulate"]["num_located"], 6)
        self.assertIn("failed: colmap mapper: no model", table)

    def test_all_variants_failed(self):
        for variant in (*MAPPER_RUNS, "triangulate", "held"):
            fake_colmap.write_receipt(self.colmap / f"register_{variant}", failed="out of memory")
        results, _ = self.evaluate()
        self.assertEqual(results["methods"]["nightmap"]["num_located"], 8)

    def test_a_method_that_cannot_be_aligned_on_the_truth_is_told_and_the_others_count(self):
        fake_site.write_tum(self.site_dir / "frames" / "ground_truth.tum", walk().select(range(22)))
        for folder, queries in (*((step, []) for step in MAPPER_RUNS),
                                *((f"register_{step}", range(6)) for step in MAPPER_RUNS)):
            shutil.rmtree(self.colmap / folder / "models")
            write_model(self.colmap / folder / "models" / "0", range(20, 40), queries=queries)
        results, table = self.evaluate()
        mapper = results["methods"]["colmap_mapper"]["against"]
        self.assertIn("at least 3", mapper["truth"]["global"]["failed"])
        self.assertEqual(mapper["nightmap"]["global"]["recall_1cm_1deg_percent"], 75)
        against_truth = results["methods"]["nightmap"]["against"]["truth"]
        self.assertEqual(against_truth["global"]["recall_1cm_1deg_percent"], 80)
        self.assertIn("| global 1 cm, 1 deg (%) | 80 | n/a | 60 | 70 |", table)
        queries = self.read_csv("queries.csv")
        self.assertEqual(queries[0]["colmap_mapper_status"], "located")
        self.assertEqual(queries[0]["colmap_mapper_global_error_cm"], "")
        told = [row for row in self.read_csv("summary.csv") if "at least 3" in row["failed"]]
        self.assertEqual({row["method"] for row in told}, {"colmap_mapper"})
        self.assertIn("alignment needs at least 3", comparison_section(Site(self.site_dir)))

    def test_no_method_can_be_aligned_on_the_truth(self):
        fake_site.write_tum(self.site_dir / "frames" / "ground_truth.tum", walk().select([]))
        results, _ = self.evaluate()
        for figures in results["methods"].values():
            for protocol in ("global", "local"):
                self.assertIn("failed", figures["against"]["truth"][protocol])
        self.assertEqual(results["plots"], ["queries.png"])

    def test_without_truth_the_methods_are_held_against_each_other(self):
        (self.site_dir / "frames" / "ground_truth.tum").unlink()
        results, table = self.evaluate()
        self.assertNotIn("truth", results["methods"]["nightmap"]["against"])
        self.assertEqual(results["methods"]["colmap_mapper"]["against"]["nightmap"]["global"]["num_with_truth"], 8)
        self.assertIn("errors against nightmap", table)

    def test_section_of_the_report(self):
        self.assertIsNone(comparison_section(Site(self.site_dir)))
        self.evaluate()
        section = comparison_section(Site(self.site_dir))
        for text in ("Comparison with COLMAP", "Errors against truth", "recall.png", "tool_mapper_2"):
            self.assertIn(text, section)
        self.assertNotIn("changed after this comparison", section)
        for name in ("map_frame/trajectory.tum", "frames/ground_truth.tum", "queries/query_ground_truth.tum"):
            path = self.site_dir / name
            before = path.read_text()
            path.write_text(before + "# another\n")
            self.assertIn("changed after this comparison", comparison_section(Site(self.site_dir)), name)
            path.unlink()
            self.assertIn("changed after this comparison", comparison_section(Site(self.site_dir)), name)
            path.write_text(before)
        self.assertNotIn("changed after this comparison", comparison_section(Site(self.site_dir)))

    def test_a_truth_that_came_later_is_told(self):
        truth = self.site_dir / "frames" / "ground_truth.tum"
        text = truth.read_text()
        truth.unlink()
        self.evaluate()
        self.assertNotIn("changed after this comparison", comparison_section(Site(self.site_dir)))
        truth.write_text(text)
        self.assertIn("changed after this comparison", comparison_section(Site(self.site_dir)))

    def test_a_query_that_is_mapped_is_refused(self):
        self.replace("localize/queries.csv", "queries/3.png", "rgb/3.png")
        self.check_failed(fake_site.run("evaluate_colmap.py", "--site-dir", self.site_dir, "--out", self.colmap / "results.json"), "rgb/3.png: this query is also a mapping frame")

    def test_page_table(self):
        page = self.write("figures.md", "a\n<!-- colmap_office:begin -->old<!-- colmap_office:end -->\nb\n")
        self.evaluate("--page", page)
        self.assertIn("| map (s) |", page.read_text())
        self.assertRegex(page.read_text(), "Measured on [0-9]{4}-[0-9]{2}-[0-9]{2} with the programs of commit [0-9a-f]{10}")
        self.assertNotIn("old", page.read_text())
