# SPDX-License-Identifier: Apache-2.0
"""Measures the map that a site made of laser scans: a section.evaluation of the job that makes its grid.

Counts always; thickness and doubling of the grid's walls, which need no truth (wall_quality.py). Where frames wrote the
robot's truth: absolute errors after a planar alignment, and relative errors over stretches of path. Where it copied
relations: their errors. Where the exact building is known: the grid against its plan (walls_and_doors.py).
"""

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from nightmap_eval.artifacts import read_hdf5
from nightmap_eval.grid import read_grid
from nightmap_eval.laser.wall_quality import wall_metrics
from nightmap_eval.loop_accuracy import loop_counts, loop_metrics, read_loops
from nightmap_eval.trajectory import angles_deg, associate, interpolated, path_length_m, read_rows, read_tum, rotation_matrices
from nightmap_eval.trajectory_errors import (MAX_TRUTH_GAP_NS, SAME_NS, TRUTH_REMEDY, distance_pairs, relative_errors,
                                             robot_figures, statistics)  # fmt: skip
from nightmap_eval.walls_and_doors import evaluate_floors, read_floors, truth_folder
from nightmap_site.checked_reading import using
from nightmap_site.script_errors import DataError

STRETCHES_M = (1, 10)
# A loop that is farther off is false. Both ends see the same walls from up to 10 m apart, and the published poses of laser logs
# err by a degree.
MAX_LOOP_ERROR_M = 0.5
MAX_GAP_NS = 500_000_000  # between the poses around a relation's time
REMEDY = "correct the relations of the site config, from which it is made, and run make again"


def evaluate(site):
    estimate = read_tum(site.needed("map_frame", "trajectory"))
    scans_ns = scan_times_ns(site, estimate)
    figures = scan_counts(scans_ns, estimate)
    keyscans = site.made("map_frame", "keyframes")
    figures |= {"num_keyscans": len(read_tum(keyscans))} if keyscans else {}
    alignment = None
    if site.robot_truth.exists():
        figures["trajectory"], alignment = trajectory_metrics(scans_ns, estimate, read_tum(site.robot_truth, TRUTH_REMEDY))
    if site.made("pose_graph", "loops_csv") and site.made("loops", "edges"):
        figures["loops"] = loops_of_keyscans(site)
    if site.relations.exists():
        figures["relations"] = relation_metrics(read_relations(site.relations), estimate)
    if site.made("grid", "yaml"):
        figures["walls"], truth_dir = floors_walls(site), truth_folder(site)
        if alignment is not None and truth_dir is not None and (truth_dir / "floor_plan.yaml").exists():  # whose frame is the truth's
            figures["map"] = {"grid": evaluate_floors(site, truth_dir, alignment)}
    return figures


def loops_of_keyscans(site):
    """Counts of the loops and, where the truth is known, of the false ones. Their frames are rows of pose_graph's trajectory."""
    rows = read_loops(site.path("pose_graph", "loops_csv"))
    figures = loop_counts(rows)
    if not site.robot_truth.exists():
        return figures
    nodes_ns = read_tum(site.needed("pose_graph", "trajectory")).times_ns
    known, truth = interpolated(read_tum(site.robot_truth, TRUTH_REMEDY), nodes_ns, MAX_TRUTH_GAP_NS)
    return figures | loop_metrics(rows, measured_loops(site.path("loops", "edges"), nodes_ns), known, truth, MAX_LOOP_ERROR_M)


def measured_loops(path, nodes_ns):
    """(node a, node b) -> measured (rotation, translation) of b_from_a, of edges.h5."""
    times_ns, poses = read_hdf5(path, "time_ns", "target_from_source")
    with using(path):
        nodes = np.minimum(np.searchsorted(nodes_ns, times_ns), len(nodes_ns) - 1)
        if (nodes_ns[nodes] != times_ns).any():
            raise DataError(f"{path}: a loop ends where pose_graph's trajectory has no pose; delete both folders and run make again")
        rotations = rotation_matrices(poses[:, 3:])
        return {(a, b): (r, t) for (a, b), r, t in zip(nodes.tolist(), rotations, poses[:, :3], strict=True)}


def scan_times_ns(site, estimate):
    """Times of all scans of the scanner that the trajectory is of: the one with most scans at its poses."""
    path = site.made("frames", "scans")
    if not path:
        return estimate.times_ns
    times_ns, offsets = read_hdf5(path, "time_ns", "sample_offset")
    with using(path):
        parts = [np.sort(part) for part in np.split(np.ravel(times_ns), np.ravel(offsets)[1:-1])]
        return max(parts, key=lambda part: len(np.intersect1d(part, estimate.times_ns)))


def scan_counts(scans_ns, estimate):
    num_with = len(associate(scans_ns, estimate.times_ns, SAME_NS))
    return {
        "num_scans": len(scans_ns),
        "num_scans_with_pose": num_with,
        "num_scans_without_pose": len(scans_ns) - num_with,
        "path_length_m": path_length_m(estimate.positions_m),
    }


def trajectory_metrics(scans_ns, estimate, truth):
    """Figures of the scans with a true pose, and the planar truth_from_map. A scan with a true pose and no
    estimate has no error; it is counted as missing, as is each stretch that begins or ends at one."""
    _, truth = interpolated(truth, scans_ns, MAX_TRUTH_GAP_NS)
    figures, pairs, alignments = robot_figures(estimate, truth, len(scans_ns), "scans")
    matched = estimate.select(pairs[:, 1])
    for metres in STRETCHES_M:
        figures[f"relative_{metres}m"] = stretch_metrics(matched, truth, pairs[:, 0], metres)
    return figures, alignments["se3"]


def stretch_metrics(matched, truth, rows, distance_m):
    """Errors of the motion over stretches of true path: each scan with the first later one at least so far ahead.

    matched[i] belongs to truth[rows[i]]. The errors are those at the end of the stretch, not divided by its length."""
    stretches, lengths_m = distance_pairs(truth, np.zeros(len(truth), dtype=int), distance_m)
    estimated = np.full(len(truth), -1)
    estimated[rows] = np.arange(len(rows))
    measured = np.all(estimated[stretches] >= 0, axis=1)
    figures = {"num_pairs": int(np.count_nonzero(measured)), "num_missing": int(np.count_nonzero(~measured))}
    if figures["num_pairs"] == 0:
        return figures
    errors = relative_errors(matched, truth.select(rows), estimated[stretches[measured]])
    for name, unit, values in zip(("translation", "rotation"), ("m", "deg"), errors):
        figures |= statistics(values, f"{name}_{{}}_{unit}", "mean", "median", "p90", "max")
    return figures | {"length_mean_m": float(np.mean(lengths_m[measured]))}


def floors_walls(site):
    """Quality of the walls of the lowest floor: a 2-D scanner maps one."""
    return wall_metrics(read_grid(site.folder_of("grid") / read_floors(site)[0]["yaml"]))


@dataclass
class Relations:
    """Known relations between pairs of poses. The metric of Kuemmerle et al., On measuring the accuracy of SLAM algorithms (Autonomous
    Robots 2009): an error far back does not count again in all that follows, and the frame of the map does not matter. A relation is
    one line, `time1 time2 x y z roll pitch yaw`: first_from_second at the two times, in seconds, metres and radians. `#` starts a comment."""

    times_ns: np.ndarray  # (n, 2) int64
    rotations: np.ndarray  # (n, 3, 3), first_from_second
    translations_m: np.ndarray  # (n, 3)

    def __len__(self):
        return len(self.times_ns)


def euler_rotations(roll_rad, pitch_rad, yaw_rad):
    """Rz(yaw) Ry(pitch) Rx(roll) (n, 3, 3)."""
    return Rotation.from_euler("ZYX", np.column_stack([yaw_rad, pitch_rad, roll_rad])).as_matrix()


def read_relations(path):
    """The Relations of a file, in its order. Raises DataError naming file and line, and when there is none."""
    rows = list(read_rows(path, REMEDY, "time1 time2 x y z roll pitch yaw", 2))
    if not rows:
        raise DataError(f"{path}: no relation; {REMEDY}")
    values = np.array([row[2] for row in rows])
    return Relations(np.array([row[1] for row in rows], dtype=np.int64), euler_rotations(*values[:, 3:].T), values[:, :3])


def relation_errors(relations, estimate, max_gap_ns=MAX_GAP_NS):
    """Translation (m) and rotation (degrees) error of each relation that the estimate has both poses of, and how many it has not.

    The error is relation^-1 * (first^-1 * second) of the estimate, whose poses are interpolated to the times of the relation."""
    rows, poses = zip(*(interpolated(estimate, relations.times_ns[:, end], max_gap_ns) for end in (0, 1)))
    _, in_first, in_second = np.intersect1d(*rows, return_indices=True)
    first, second = poses[0].select(in_first), poses[1].select(in_second)
    both = rows[0][in_first]
    inverse = np.transpose(first.rotations(), (0, 2, 1))
    step_m = np.einsum("nij,nj->ni", inverse, second.positions_m - first.positions_m)
    back = np.transpose(relations.rotations[both], (0, 2, 1))
    translation_m = np.linalg.norm(step_m - relations.translations_m[both], axis=1)
    return translation_m, angles_deg(back @ inverse @ second.rotations()), len(relations) - len(both)


def _mean_and_std(values, name, unit):
    """Mean, and standard deviation of the sample, of errors and of their squares, as the paper has them."""
    figures = {}
    for kind, numbers, suffix in (("", values, unit), ("squared_", np.square(values), f"{unit}2")):
        figures[f"{name}_{kind}mean_{suffix}"] = float(np.mean(numbers))
        figures[f"{name}_{kind}std_{suffix}"] = float(np.std(numbers, ddof=1)) if len(numbers) > 1 else None
    return figures


def relation_metrics(relations, estimate, max_gap_ns=MAX_GAP_NS):
    """Figures of the errors; relations without poses are counted as missing and in no mean."""
    translation_m, rotation_deg, num_missing = relation_errors(relations, estimate, max_gap_ns)
    figures = {"num_relations": len(relations), "num_missing": num_missing}
    if num_missing == len(relations):
        return figures
    figures |= _mean_and_std(translation_m, "translation", "m")
    figures |= _mean_and_std(rotation_deg, "rotation", "deg")
    return figures | {"translation_max_m": float(np.max(translation_m)), "rotation_max_deg": float(np.max(rotation_deg))}
