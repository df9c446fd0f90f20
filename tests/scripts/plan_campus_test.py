# SPDX-License-Identifier: Apache-2.0
"""plan_campus.py: schedules whose lengths are known."""

import json
import unittest

import fake_site
from folder_case import FolderTest
import plan_campus as plan


def cost(name, before=(), frames=0, wall_s=10.0, cores=1, memory_mb=100):
    return plan.JobCost(name, "shard" if frames else "site", frames, wall_s, cores, memory_mb, 1e6, list(before))


def made(costs, buildings=1, frames=400, nodes=1, cores=4, memory_mb=1000, step_s=0.0):
    """Seconds of the schedule, core seconds by job, and the longest chain; 100 frames took what `costs` says."""
    tasks, longest_s = [], 0
    for building in range(buildings):
        of_building = plan.building_tasks(costs, 100, frames, building)
        longest_s = max(longest_s, plan.rank(of_building, step_s))
        tasks += of_building
    return *plan.simulate(tasks, nodes, cores, memory_mb, step_s), longest_s


class PlanCampusTest(unittest.TestCase):
    SHARDS_THEN_ALL = {"features": cost("features", frames=100), "loops": cost("loops", ["features"])}

    def test_shards_run_side_by_side_and_whole_sites_grow_with_the_frames(self):
        wall_s, used, longest_s = made(self.SHARDS_THEN_ALL)
        self.assertEqual((wall_s, longest_s), (10 + 40, 10 + 40))  # 4 shards at a time, then 4 times the frames
        self.assertEqual(used, {"features": 40, "loops": 40})
        self.assertEqual(made(self.SHARDS_THEN_ALL, cores=1)[0], 40 + 40)
        self.assertEqual(made(self.SHARDS_THEN_ALL, cores=1, nodes=4)[0], 10 + 40)

    def test_each_shard_goes_on_without_the_others(self):
        costs = {"a": cost("a", frames=100), "b": cost("b", ["a"], frames=100)}
        self.assertEqual(made(costs, frames=300, cores=2)[0], 30)  # a a | a b | b b

    def test_cores_and_memory_of_a_node_bound_what_runs_on_it(self):
        wide = {"a": cost("a", frames=100, cores=3)}
        self.assertEqual(made(wide)[0], 40)
        self.assertEqual(made(wide, nodes=2)[0], 20)
        self.assertEqual(made({"a": cost("a", frames=100, memory_mb=600)})[0], 40)
        self.assertEqual(made({"a": cost("a", frames=100, cores=99, memory_mb=9999)})[0], 40)  # more than a node has

    def test_no_cluster_is_faster_than_the_longest_chain_nor_than_its_cores(self):
        costs = self.SHARDS_THEN_ALL | {"map": cost("map", ["loops"], frames=50, wall_s=7)}
        for nodes in (1, 3, 50):
            wall_s, used, longest_s = made(costs, buildings=7, frames=1000, nodes=nodes, step_s=0.1)
            self.assertGreaterEqual(wall_s + 1e-9, max(longest_s, sum(used.values()) / (4 * nodes)))
        self.assertAlmostEqual(wall_s, longest_s)

    def test_the_start_of_a_step_counts_once_per_task(self):
        self.assertAlmostEqual(made(self.SHARDS_THEN_ALL, step_s=1.0)[0], 11 + 41)


class CommandTest(FolderTest):
    TAKEN = {"wall_time_s": 2.0, "peak_memory_bytes": 10**8, "inputs": [], "outputs": [{"size_bytes": 10**6}]}

    def run_plan(self, *receipts):
        self.write("frames/report.json", json.dumps({"num_frames": 100}))
        for unit, receipt in enumerate(receipts):
            self.write(f"features/receipt_{unit:04}.json", json.dumps(receipt))
        return fake_site.run("plan_campus.py", self.folder, "--buildings", 1, "--frames", 1000, "--nodes", 1, "--cores", 2, "--step-s", 0.1)

    def test_prints_a_row_per_size_from_the_receipts(self):
        said = self.run_plan(self.TAKEN, self.TAKEN)
        self.assertEqual(said.returncode, 0, said.stderr)
        self.assertIn("| 1 | 20 | 0.0 | 100 | 0.0 | features (100 %) | 4.8 | 0 |", said.stdout)  # 20 shards of 2.1 s, one at a time

    def test_what_is_missing_or_damaged_is_told(self):
        self.check_failed(self.run_plan(), "no receipts of a map; run make map")
        self.check_failed(self.run_plan({"wall_time_s": 2.0}), "features: receipts: damaged")
