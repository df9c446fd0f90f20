# SPDX-License-Identifier: Apache-2.0
"""Loops: a building made to be mistaken, wrong loops among the right ones, two recordings of one
building.
"""
import json
import shutil
import sys
import unittest

import numpy as np

from nightly import nightly
from rendered_sites import FOLDER, make_site, recording, synthesize, write_site
from workspace import BUILD, REPOSITORY, said_by

sys.path.append(str(REPOSITORY / "scripts"))
from nightmap_eval.sealed_hdf5 import sealed  # noqa: E402
from nightmap_eval.trajectory import angles_deg, associate, read_tum  # noqa: E402


def make_trajectory(site, *variables):
    """Maps a recording up to the trajectory."""
    return make_site(site, *variables, FOLDER / "maps" / site / "map_frame/trajectory.tum")


def ate_m(site_dir, trajectory):
    """After the best rigid alignment (Umeyama without scale)."""
    estimate, truth = read_tum(trajectory), read_tum(site_dir / "frames/ground_truth.tum")
    pairs = associate(estimate.times_ns, truth.times_ns, 1000)
    a, b = estimate.positions_m[pairs[:, 0]], truth.positions_m[pairs[:, 1]]
    u, _, vt = np.linalg.svd((b - b.mean(0)).T @ (a - a.mean(0)))
    rotation = u @ np.diag([1, 1, np.sign(np.linalg.det(u @ vt))]) @ vt
    return float(np.sqrt(np.mean(np.sum((b - b.mean(0) - (a - a.mean(0)) @ rotation.T) ** 2, axis=1))))


class MirrorTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        site_dir = make_trajectory("mirror")
        cls.site_dir = site_dir
        said_by(["/usr/bin/python3", "scripts/evaluate.py", "--site-dir", site_dir, "--data", FOLDER / "data",
                 "--out", site_dir / "evaluate/metrics.json"])
        cls.metrics = json.loads((site_dir / "evaluate/metrics.json").read_text())

    def test_no_false_loop_and_the_revisits_closed(self):
        self.assertEqual(self.metrics["loops"]["num_false_accepted"], 0)
        self.assertGreaterEqual(self.metrics["loops"]["revisits_closed_percent"], 90)
        self.assertLessEqual(self.metrics["trajectory"]["se3"]["ate_rmse_m"], 0.05)
        report = json.loads((self.site_dir / "pose_graph/report.json").read_text())
        self.assertTrue(report["returns_to_start"])
        self.assertEqual(len(report["parts"]), 1)

    def run_stage(self, stage, inputs, outputs):
        said_by([BUILD / "run" / stage, "--config", self.site_dir / f"config/{stage}.toml",
                 *(word for path in inputs for word in ("--in", path)),
                 *(word for path in outputs for word in ("--out", path))])

    def test_a_third_of_the_loops_wrong(self):
        folder = FOLDER / "wrong_loops"
        folder.mkdir(exist_ok=True)
        shutil.copy(self.site_dir / "loops/loops.h5", folder / "loops.h5")
        rng = np.random.default_rng(1)
        with sealed(folder / "loops.h5", "r+") as file:
            accepted = np.flatnonzero(np.ravel(file["status"]) == 0)
            wrong = rng.choice(accepted, round(0.3 * len(accepted)), replace=False)
            poses = file["b_from_a"][:]
            poses[wrong, :3] = rng.uniform(-1, 1, (len(wrong), 3))
            turns = rng.normal(size=(len(wrong), 4))
            poses[wrong, 3:] = turns / np.linalg.norm(turns, axis=1, keepdims=True)
            file["b_from_a"][:] = poses
        inputs = [f"frames={path}" for path in sorted((self.site_dir / "frames").glob("shard_*.csv"))]
        inputs += [f"odometry={path}" for path in sorted((self.site_dir / "odometry").glob("shard_*.h5"))]
        inputs += [f"loops={folder}/loops.h5"]
        closed = [f"trajectory={folder}/closed.tum", f"keyframes={folder}/closed_keyframes.tum"]
        self.run_stage("pose_graph", inputs, [*closed, f"graph={folder}/graph.h5"])
        inputs += [f"features={path}" for path in sorted((self.site_dir / "features").glob("shard_*.h5"))]
        inputs += [f"cameras={self.site_dir}/frames/cameras.json", f"graph={folder}/graph.h5"]
        adjusted = [f"{name}={folder}/{name}.tum" for name in ("trajectory", "keyframes")]
        self.run_stage("adjust", inputs, [*adjusted, f"cameras={folder}/cameras.json"])
        clean_m = ate_m(self.site_dir, self.site_dir / "map_frame/trajectory.tum")
        self.assertLessEqual(ate_m(self.site_dir, folder / "trajectory.tum"), 1.5 * clean_m)


@nightly
class TwoRecordingsTest(unittest.TestCase):
    """Two drives through the demo building, each two thirds of the route, from different starts."""

    def test_they_merge(self):
        for index, start_ratio in enumerate((0.1, 0.6)):
            synthesize(f"two/{index}", "num_frames = 470\nlength_ratio = 0.64\noverlap_m = 0\n"
                       f"num_queries = 0\nrecording = {index}\nstart_ratio = {start_ratio}\n")
        sites = write_site("two", [recording(str(index), index) for index in range(2)])
        self.check(make_trajectory("two", f"SITES={sites}"))

    def check(self, site_dir):
        report = json.loads((site_dir / "pose_graph/report.json").read_text())
        self.assertEqual(len(report["parts"]), 1)
        estimate, truth = (read_tum(site_dir / name) for name in
                           ("map_frame/trajectory.tum", "frames/ground_truth.tum"))
        pairs = associate(estimate.times_ns, truth.times_ns, 1000)
        self.assertEqual(len(pairs), 940)
        moves = []  # map_from_truth, from each recording alone
        for half in (pairs[:470], pairs[470:]):
            a, b = estimate.select(half[:, 0]), truth.select(half[:, 1])
            u, _, vt = np.linalg.svd((a.positions_m - a.positions_m.mean(0)).T
                                     @ (b.positions_m - b.positions_m.mean(0)))
            rotation = u @ np.diag([1, 1, np.sign(np.linalg.det(u @ vt))]) @ vt
            moves.append((rotation, b.positions_m.mean(0), a.positions_m.mean(0)))
        (first, _, _), (second, middle, second_middle) = moves
        by_first = first @ (middle - moves[0][1]) + moves[0][2]
        self.assertLessEqual(np.linalg.norm(by_first - second_middle), 0.03)
        self.assertLessEqual(angles_deg((first @ second.T)[None])[0], 0.5)
