#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""evaluate: measures a site's map and located queries against the truth; writes metrics.json.

Trajectory: ATE after SE(3) and Sim(3) alignment, RPE per frame and per metre. Queries: error in the
map aligned by its own mapping frames, as a whole (global) and around each query (local), recall with
missing poses counted as failures. Synthetic sites: distance of the cloud to the exact surfaces, and each
floor's grid, walls and doors against the exact plan. A site without truth gets counts only; metrics.json
says so. A job's own figures (section.evaluation) stand in `sections`; a site without map_frame or without a camera has
only these: those of a laser are in nightmap_eval/laser/laser_accuracy.py, those of a ceiling in ceiling_accuracy.py.
Exit codes: 0 written; 1 missing or inconsistent data; 2 wrong command line.
"""

import numpy as np

from nightmap_eval.artifacts import Frames, bridged_frames, frames_apart, num_unusable_frames, to_json, truths_apart, write_atomic
from nightmap_eval.dense.cloud_accuracy import cloud_metrics
from nightmap_eval.loop_accuracy import loop_counts, loop_metrics, read_loops, read_relative_poses
from nightmap_eval.metrics_json import lead_figures
from nightmap_eval.ply import read_ply
from nightmap_eval.query_errors import PROTOCOLS, VERDICTS, query_summary, read_located
from nightmap_eval.trajectory import FRAME_GAP_NS, associate, read_truth, read_tum
from nightmap_eval.trajectory_errors import coverage, trajectory_metrics
from nightmap_eval.walls_and_doors import evaluate_floors, truth_folder
from nightmap_site.script_errors import DataError, paths_parser, run_main
from nightmap_site.site import Site

MAX_TURN_DEG = 30  # half of what a camera sees: no map hangs together that is wrong by more, by the same at all poses


def evaluate_coverage(site, frames, estimate):
    """The pose of a bridged frame in the trajectory is a guess, so the frame counts as without a pose. So do
    frames in parts of the map that no loop joined to the largest, and frames that the frames stage skipped."""
    strangers = set(estimate.times_ns.tolist()) - set(frames.times_ns.tolist())
    if strangers:
        raise DataError(f"trajectory.tum has {len(strangers)} poses of frames that the shards do not list "
                        f"(first at {min(strangers)} ns); run map_frame again")  # fmt: skip
    bridged, apart = bridged_frames(site), frames_apart(site)
    guessed = {"num_frames_bridged": len(bridged), "frames_bridged": bridged, "frames_apart": apart}
    figures = coverage(frames, estimate, num_unusable_frames(site), [*bridged, *apart], guessed)
    keyframes = site.made("map_frame", "keyframes")
    return figures | ({"num_keyframes": len(read_tum(keyframes))} if keyframes else {})


def match_with_truth(estimate, truth):
    """The frames with a true pose and these poses, row by row."""
    pairs = associate(estimate.times_ns, truth.times_ns, FRAME_GAP_NS)
    if len(pairs) < 3:
        raise DataError(f"{len(pairs)} frames have a true pose within {FRAME_GAP_NS / 1e9} s; "
                        "the ground_truth of the site config has to cover the frames, by their clock")  # fmt: skip
    return estimate.select(pairs[:, 0]), truth.select(pairs[:, 1])


def query_errors(located, truth, times_ns, map_pair):
    """Figures for both protocols, and the errors of each query by its time; see nightmap_eval.query_errors."""
    queried_ns = np.sort(times_ns)
    pairs = associate(queried_ns, truth.times_ns, FRAME_GAP_NS)
    truth_of = dict(zip(queried_ns[pairs[:, 0]].tolist(), pairs[:, 1].tolist()))
    matched = located.select([i for i, t in enumerate(located.times_ns.tolist()) if t in truth_of])
    matched_truth = truth.select([truth_of[t] for t in matched.times_ns.tolist()])
    figures, errors = {}, {time_ns: {} for time_ns in matched.times_ns.tolist()}
    for name, protocol in PROTOCOLS.items():
        translation_m, rotation_deg = protocol(matched, matched_truth, *map_pair)
        figures[name] = query_summary(translation_m, rotation_deg, len(truth_of))
        prefix = "" if name == "global" else f"{name}_"
        for entry, metres, degrees in zip(errors.values(), translation_m, rotation_deg):
            entry[f"{prefix}translation_error_cm"] = 100 * metres
            entry[f"{prefix}rotation_error_deg"] = degrees
    return figures, errors


def evaluate_queries(path, truth_path, map_pair):
    """Counts of the queries and, when their truth is known, their errors. The global figures also appear
    at the top level. map_pair: mapping frames and their true poses, or None."""
    rows, times_ns, located = read_located(path)
    figures = {"num_queries": len(rows), "num_located": len(located), "num_failed": len(rows) - len(located),
               "num_by_verdict": {verdict: sum(row["status"] == verdict for row in rows) for verdict in VERDICTS}}  # fmt: skip
    errors = {}
    if truth_path.exists() and map_pair is not None:
        by_protocol, errors = query_errors(located, read_truth(truth_path), times_ns, map_pair)
        figures |= by_protocol["global"] | by_protocol
    figures["rows"] = [{name: row[name] for name in ("color_path", "status", "reason")}
                       | {"query_idx": int(row["query_idx"])}  # read_located checked it
                       | errors.get(int(time_ns), {}) for row, time_ns in zip(rows, times_ns)]  # fmt: skip
    return figures


def evaluate_loops(site, frames):
    """Counts of the loop candidates and, where the truth is known, their accuracy."""
    rows = read_loops(site.path("pose_graph", "loops_csv"))
    figures = loop_counts(rows)
    measured = site.made("loops", "loops")
    if site.ground_truth.exists() and measured:
        truth = read_truth(site.ground_truth)
        pairs = associate(frames.times_ns, truth.times_ns, FRAME_GAP_NS)
        known, truth = frames.frame_idxs[pairs[:, 0]], truth.select(pairs[:, 1])
        figures |= loop_metrics(rows, read_relative_poses(measured), known, truth)
    return figures


def evaluate_map(site, truth_dir, alignment):
    """Cloud and grid against the exact building (truth frame = building frame)."""
    figures = {}
    surfaces = truth_dir / "surfaces.ply"
    if surfaces.exists() and (cloud := site.made("join_clouds", "cloud")):
        vertices, triangles = read_ply(surfaces)
        figures["cloud"] = cloud_metrics(read_ply(cloud)[0], alignment, vertices, triangles)
    if (truth_dir / "floor_plan.yaml").exists() and site.made("grid", "yaml"):
        figures["grid"] = evaluate_floors(site, truth_dir, alignment)
    return figures


def evaluate_camera(site, site_config):
    """Figures of the camera's trajectory, the located queries, the loops and the map."""
    estimate, frames = read_tum(site.path("map_frame", "trajectory")), Frames(site)
    figures = {"coverage": evaluate_coverage(site, frames, estimate), "has_ground_truth": site.ground_truth.exists()}
    map_pair = alignment = None
    if site.ground_truth.exists():
        map_pair = match_with_truth(estimate, read_truth(site.ground_truth))
        row_of_time = {int(t): row for row, t in enumerate(frames.times_ns)}
        rows = [row_of_time[int(t)] for t in map_pair[0].times_ns]
        figures["trajectory"], alignment = trajectory_metrics(*map_pair, frames.frame_idxs[rows], frames.sequence_idxs[rows])
    queries = site.made("localize", "queries")
    if queries:
        figures["queries"] = evaluate_queries(queries, site.query_ground_truth, map_pair)
    if site.made("pose_graph", "loops_csv"):
        figures["loops"] = evaluate_loops(site, frames)
    truth_dir = truth_folder(site, site_config)
    if alignment is not None and truth_dir is not None and truth_dir.exists():
        figures["map"] = evaluate_map(site, truth_dir, alignment)
    return figures


def evaluate(arguments):
    site = Site(arguments.site_dir, arguments.data)
    for file, _, what in truths_apart(site):  # such a truth would pass for none
        raise DataError(f"{file}: {what}")
    metrics = {"format": "nightmap metrics", "version": 1, "site": site.name}
    if site.has_camera() and site.has("map_frame"):
        metrics |= evaluate_camera(site, arguments.site_config)
    else:
        metrics["has_ground_truth"] = site.robot_truth.exists()
        queries = site.made("localize", "queries")
        if queries:
            metrics["queries"] = evaluate_queries(queries, site.query_ground_truth, None)
    for job, module in site.sections("evaluation"):
        metrics.setdefault("sections", {})[job.name] = module.evaluate(site)
    return metrics


def print_summary(metrics):
    trajectory = lead_figures(metrics, "trajectory")
    if not trajectory:
        print(f"{metrics['site']}: no ground truth: counts only, no accuracy")
        return
    se3 = trajectory["se3"]
    text = f"{metrics['site']}: ATE RMSE {100 * se3['ate_rmse_m']:.2f} cm, {se3['rotation_rmse_deg']:.2f} deg (SE(3) alignment)"
    far = trajectory.get("relative_10m", {})
    if far.get("num_pairs"):
        text += f"; over 10 m {100 * far['translation_mean_m']:.2f} cm, {far['rotation_mean_deg']:.3f} deg"
    turn_deg, most_deg = se3["rotation_median_deg"], se3["rotation_max_deg"]
    if turn_deg > MAX_TURN_DEG and most_deg - turn_deg < MAX_TURN_DEG / 2:
        text += (f"; the truth turns all poses by {turn_deg:.0f} deg: are its axes those of the camera (x right, y down, z forward) or of "
                 "the robot (x forward, y left, z up)?")  # fmt: skip
    print(text)


def main():
    arguments = paths_parser(__doc__, site_dir="maps/<site>", data="folder of the recordings", out="metrics.json to write",
                             site_config="?default: maps/<site>/config/site/<site>.toml").parse_args()  # fmt: skip
    metrics = evaluate(arguments)
    write_atomic(arguments.out, to_json(metrics))
    print_summary(metrics)


if __name__ == "__main__":
    run_main(main)
