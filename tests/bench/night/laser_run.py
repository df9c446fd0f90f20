# SPDX-License-Identifier: Apache-2.0
"""Runs the jobs of the laser on a composed site, as the pipeline declares them and with its default configs, and scores its map."""

import csv

import numpy as np
from checkout import CHECKOUT  # first: it makes the packages of scripts/ importable

from nightmap_eval.artifacts import read_hdf5
from nightmap_eval.query_errors import read_located
from nightmap_eval.trajectory import associate, read_truth, read_tum, travelled_m
from nightmap_site.pipeline import closure, read_pipeline

from night.score import SAME_NS, true_pairs

CONFIGS = CHECKOUT / "configs"
GIVEN = ("synthesize", "queries", "frames")
LOOP = 1  # kind of an edge
REVISIT_M = 1.0  # of way, between a scan and the end of a loop
WRONG_M = 0.5  # of a query, against the map around it


def pipeline():
    return read_pipeline(str(CONFIGS), "laser")


def jobs_of_whole():
    """The jobs of the laser's map and its test that have a program, in order."""
    jobs = pipeline().jobs
    return [jobs[name] for name in jobs if name in closure(pipeline(), ["map"]) and jobs[name].program and name not in GIVEN]


def run(job, programs, folder):
    """Runs a job on a site; returns its StageResult. Raises DataError when its program fails."""
    declared, inputs = pipeline().jobs, {}
    for given in job.inputs:
        inputs.setdefault(given.port, []).append(folder / given.job / declared[given.job].file_of(given.output))
    [config] = CONFIGS.glob(f"*/default/{job.options}.toml")
    inputs = {port: paths if len(paths) > 1 else paths[0] for port, paths in inputs.items()}
    return programs.run(job.program, inputs, job.outputs, folder / job.name, config)


def loop_figures(folder, truth, visit_scans):
    """The loops that pose_graph accepted: their number, how many disagree with the truth, and the share of the second visit's way
    along which a true loop with the first visit ends nearby."""
    kinds, times_ns, b_from_a = read_hdf5(folder / "loops/edges.h5", "kind", "time_ns", "target_from_source")
    with open(folder / "pose_graph/loops.csv", newline="") as file:
        accepted = {(int(row["frame_a"]), int(row["frame_b"])) for row in csv.DictReader(file) if row["status"] == "accepted"}
    keyscans = read_tum(folder / "odometry/keyframes.tum").times_ns
    loops = np.flatnonzero(kinds[:, 0] == LOOP)
    numbers = np.searchsorted(keyscans, times_ns[loops])
    loops = loops[[tuple(pair) in accepted for pair in numbers.tolist()]]
    scans = np.searchsorted(truth.times_ns, times_ns[loops])
    is_true = true_pairs(scans, b_from_a[loops], truth)
    closing = np.sort(scans[is_true & (scans[:, 0] < visit_scans) & (scans[:, 1] >= visit_scans), 1])
    way_m = travelled_m(truth.positions_m)
    ends_m, revisits_m = np.r_[-np.inf, way_m[closing], np.inf], way_m[visit_scans:]
    after = np.searchsorted(ends_m, revisits_m)
    nearest_m = np.minimum(revisits_m - ends_m[after - 1], ends_m[after] - revisits_m)
    return {"num_accepted": len(loops), "num_false": int(np.sum(~is_true)), "closed_percent": 100 * float(np.mean(nearest_m <= REVISIT_M))}


def query_figures(folder):
    """Queries of the test: their number, how many were located, and how many of these in a wrong place of the map."""
    _, _, located = read_located(folder / "test_localize/queries.csv")
    true = read_truth(folder / "test_scans/truth.tum")
    pairs = associate(located.times_ns, true.times_ns, SAME_NS)
    apart_m = np.linalg.norm(located.positions_m[pairs[:, 0]] - true.positions_m[pairs[:, 1]], axis=1)
    return {"num_queries": len(true), "num_located": len(pairs), "num_wrong": int(np.sum(apart_m > WRONG_M))}
