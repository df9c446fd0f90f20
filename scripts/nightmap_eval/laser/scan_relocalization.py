# SPDX-License-Identifier: Apache-2.0
"""Measures how well a robot that woke up somewhere is located by its scan: a section.evaluation of the job test_localize.

Its scans are of stretches of the way that are not in the test map. The reference is the way itself, as the job map_frame has
it: the grid was drawn by the same way, so no alignment is needed. A scan that is not located counts as a failure.

Its section.verdict: the map was drawn by the same way, so a scan that is found elsewhere tells of a place that is drawn twice, or of
another that looks like it.
"""

from dataclasses import dataclass

import numpy as np

from nightmap_eval.artifacts import read_csv
from nightmap_eval.query_errors import VERDICTS, WRONG_CM, query_summary, read_located, recall_percent
from nightmap_eval.trajectory import Similarity, read_tum
from nightmap_eval.trajectory_errors import absolute_errors
from nightmap_eval.verdict.verdict import check, unknown
from nightmap_site.checked_reading import REMEDY, read_object, using
from nightmap_site.script_errors import DataError

# Centimetres and degrees.
THRESHOLDS = ((5, 0.5), (10, 1), (50, 5))
SIGMA_COLUMNS = ("position_sigma_m", "rotation_sigma_deg")
# Counts of objects that the published method saw, in the report of scan_localize.
OBJECT_COUNTS = ("num_objects", "num_queries_near_objects", "num_object_poses", "num_queries_filtered_by_objects")
SAME = Similarity(1.0, np.eye(3), np.zeros(3))
MIN_LOCATED = 10  # fewer tell nothing
GOOD_WRONG, USABLE_WRONG = 3, 20  # percent; one scan is good, however few there are
MAX_SPREAD_CM = 10
LOOK_AT = "look at the loops, at the scale of the wheels, and at the angles and the pose of the scanner"


@dataclass
class LocatedScans:
    """rows: of queries.csv; truth: of each query; located: index of each located one; errors of these, and their sigmas."""

    rows: list
    truth: object
    located: np.ndarray
    translation_m: np.ndarray
    rotation_deg: np.ndarray
    position_sigma_m: np.ndarray
    rotation_sigma_deg: np.ndarray


def read_scans(queries, truth):
    """The results of one run of scan_localize against a TUM file with the true pose of each query."""
    rows, times_ns, poses = read_located(queries)
    reference = read_tum(truth) if len(rows) else None
    sigmas = read_csv(queries, SIGMA_COLUMNS)
    located = np.array([i for i, row in enumerate(rows) if row["status"] == "located"], dtype=int)
    if len(rows) == 0:
        return LocatedScans(rows, None, located, *(np.zeros(0) for _ in range(4)))
    if not np.array_equal(np.asarray(times_ns), reference.times_ns):
        raise DataError(f"{truth}: it is of other queries than {queries}; {REMEDY}")
    by_time = np.argsort(np.asarray(times_ns)[located], kind="stable")
    translation_m, rotation_deg = np.zeros(len(located)), np.zeros(len(located))
    if len(located):
        translation_m[by_time], rotation_deg[by_time] = absolute_errors(poses, reference.select(located[by_time]), SAME)
    with using(queries):
        of_located = [np.array([float(sigmas[i][name]) for i in located]) for name in SIGMA_COLUMNS]
    return LocatedScans(rows, reference, located, translation_m, rotation_deg, *of_located)


def evaluate(site):
    queries, truth = site.made("test_localize", "queries"), site.made("test_scans", "truth")
    if not (queries and truth):
        return {}
    path = site.made("test_localize", "report")
    counts = read_object(path, dict.fromkeys(OBJECT_COUNTS, int)) if path else {}
    return figures(read_scans(queries, truth)) | ({name: counts[name] for name in OBJECT_COUNTS} if counts.get("num_objects") else {})


def figures(scans):
    count = len(scans.rows)
    result = {"num_queries": count,
              "num_by_verdict": {verdict: sum(row["status"] == verdict for row in scans.rows) for verdict in VERDICTS}}  # fmt: skip
    if count == 0:
        return result
    errors = scans.translation_m, scans.rotation_deg
    summary = query_summary(*errors, count)
    names = ("num_wrong", *(f"{kind}_{error}" for kind in ("median", "p90") for error in ("translation_error_cm", "rotation_error_deg")))
    result |= {name: summary[name] for name in names}
    result["wrong_percent"] = 100 * summary["num_wrong"] / count
    for max_cm, max_deg in THRESHOLDS:
        result[f"within_{max_cm}cm_{max_deg}deg_percent"] = recall_percent(*errors, count, max_cm, max_deg)
    if len(scans.located):
        result["p90_translation_error_per_sigma"] = float(np.percentile(errors[0] / scans.position_sigma_m, 90))
        result["p90_rotation_error_per_sigma"] = float(np.percentile(errors[1] / scans.rotation_sigma_deg, 90))
    return result


def checks(site):
    queries, truth = site.made("test_localize", "queries"), site.made("test_scans", "truth")
    if queries and truth:
        yield from held_out_checks(read_scans(queries, truth))


def held_out_checks(scans):
    found = "scans kept out and found elsewhere"
    reason = f"of those located, more than {WRONG_CM} cm from where the robot's way says; one may be a look-alike"
    count = len(scans.located)
    if count < MIN_LOCATED:
        yield unknown(found, reason, f"{count} of {len(scans.rows)} scans that were kept out of a second map are located, too few to tell: the "
                      "robot came to few places twice, or they look alike")  # fmt: skip
        return
    figures, one_percent = query_summary(scans.translation_m, scans.rotation_deg, count), 100 / count
    yield check(found, one_percent * figures["num_wrong"], "%", (0, max(GOOD_WRONG, one_percent)), reason, "{value:.0f} % of the scans that "
                "were kept out are found elsewhere than the robot's way says: the map contradicts itself, places are drawn twice, apart: "
                f"{LOOK_AT}", usable=(0, max(USABLE_WRONG, one_percent)))  # fmt: skip
    yield check("spread of scans kept out", figures["located_median_translation_error_cm"], "cm", (0, MAX_SPREAD_CM), "median distance from "
                "the robot's way; a map that agrees with itself has 1 to 3 cm", "scans that were kept out are found {value:.0f} cm from where "
                f"the robot's way says: the map contradicts itself, the drawings of a place lie apart: {LOOK_AT}")  # fmt: skip
