# SPDX-License-Identifier: Apache-2.0
"""The programs that map a site as a whole, on one that is composed of copies of the demo building's second and third shard (tests/bench/night),
along which the way leads twice: a short one of tests/bench/bench_night.py. Every revisit is closed, no copy is taken for another, and the
map is as exact as the building's own."""
import shutil
import sys
import tempfile
import unittest
from pathlib import Path

import numpy as np

from accuracy import FOLDER, make
from workspace import BUILD, REPOSITORY

from nightmap_eval.trajectory import read_truth

sys.path.append(str(REPOSITORY / "tests/bench"))
from night import run, score  # noqa: E402
from night.compose import NUM_VISITS, Composer, link_data  # noqa: E402
from night.source import Source, read_table  # noqa: E402
from stage_run import Programs  # noqa: E402

MAX_EDGE_ERROR_M, MAX_EDGE_ERROR_DEG = 0.02, 0.5  # of the motion between two keyframes, the joints included


class NightTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.source_dir = make("demo", FOLDER / "data", "map", "localize")
        cls.site = Path(tempfile.mkdtemp(dir=BUILD)) / "site"
        cls.addClassCleanup(shutil.rmtree, cls.site.parent)
        source, programs = Source(cls.source_dir), Programs(BUILD, 2)
        cls.composer = Composer(source, source.choose_unit(2), 2000, programs)
        cls.truth = cls.composer.write(cls.site)
        link_data(cls.site / "data", FOLDER / "data", NUM_VISITS * cls.composer.num_copies)
        for job in run.jobs_of_whole():
            run.run(job, programs, cls.site, cls.source_dir, FOLDER / "data")

    def odometry(self):
        return [read_table(path) for path in run.shards(self.site, "odometry")]

    def test_edges_measure_the_truth_also_from_a_copy_to_the_next_and_one_bridge_leads_to_the_second_visit(self):
        num_bridges = 0
        for odometry in self.odometry():
            is_bridge = odometry["edge_is_bridge"][:, 0] > 0
            num_bridges += np.count_nonzero(is_bridge)
            frames, edges = odometry["edge_frame"][~is_bridge], odometry["edge_b_from_a"][~is_bridge]
            errors_m, errors_deg = score.pair_errors(frames, edges, self.truth)
            self.assertLess(errors_m.max(), MAX_EDGE_ERROR_M)
            self.assertLess(errors_deg.max(), MAX_EDGE_ERROR_DEG)
        self.assertEqual((num_bridges, self.composer.num_copies), (1, 3))

    def test_every_revisit_is_closed_and_no_copy_is_taken_for_another(self):
        figures = score.loop_figures(self.site / "loops/loops.h5", self.site / "pose_graph/graph.h5", self.truth, self.composer.visit_frames)
        self.assertEqual((figures["closed_percent"], figures["num_false"]), (100, 0))

    def test_the_map_is_better_than_odometry_alone_and_about_as_good_as_that_of_the_source(self):
        """The source's map has more loops for its length: its way passes each room from two sides."""
        figures = score.trajectory_figures(self.site / "map_frame/trajectory.tum", self.truth, self.composer.visit_frames)
        self.assertEqual(figures["num_without"], 0)
        of_odometry_m, _ = score.odometry_errors(run.first_visit(self.site), self.truth)
        self.assertLess(figures["rpe_m"], of_odometry_m)
        true = read_truth(self.source_dir / "frames/ground_truth.tum")
        of_source = score.trajectory_figures(self.source_dir / "map_frame/trajectory.tum", true, len(true))
        self.assertLess(figures["rpe_m"], 2 * of_source["rpe_m"])

    def test_queries_are_located_in_the_copy_that_they_were_taken_in(self):
        figures = score.query_figures(self.site / "localize/queries.csv", self.source_dir / "queries/query_ground_truth.tum",
                                      self.site / "map_frame/trajectory.tum", self.truth, self.composer.copy_of_frames() == 0)
        self.assertGreater(figures["num_queries"], 20)
        self.assertGreaterEqual(figures["num_located"], figures["num_queries"] - 1)
        self.assertEqual(figures["num_wrong"], 0)
        self.assertLess(figures["median_m"], 0.005)
