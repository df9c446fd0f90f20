# SPDX-License-Identifier: Apache-2.0
"""evaluate/metrics.json as the report needs it: checks the type of every figure that the report shows."""

from nightmap_eval.query_errors import PROTOCOLS, RECALL_THRESHOLDS
from nightmap_site.checked_reading import NUMBER, REMEDY, check, read_object
from nightmap_site.script_errors import DataError

UNKNOWN_OR_NUMBER = (*NUMBER, type(None))
COVERAGE = {
    "num_frames": int, "num_frames_with_pose": int, "path_length_m": NUMBER,
    "?frames_without_pose": [int], "?frames_bridged": [int], "?frames_apart": [int],
}  # fmt: skip
ATE = {"ate_rmse_m": NUMBER, "ate_median_m": NUMBER, "ate_max_m": NUMBER, "rotation_rmse_deg": NUMBER, "?scale": NUMBER}
TRAJECTORY = {
    "num_pairs": int, "truth_from_map_m_q": [NUMBER], "se3": ATE, "sim3": ATE,
    "rpe_per_frame": {"num_pairs": int}, "rpe_per_metre": {"num_pairs": int},
}  # fmt: skip
ROW = {
    "query_idx": int, "color_path": str, "status": str, "reason": str,
    "?translation_error_cm": NUMBER, "?rotation_error_deg": NUMBER,
}  # fmt: skip
QUERIES = {
    "num_queries": int, "num_located": int, "num_by_verdict": dict, "rows": [ROW],
    "?num_with_truth": int, "?recall_5cm_5deg_percent": UNKNOWN_OR_NUMBER,
}  # fmt: skip
FLOOR = {"?height_m": NUMBER, "?found": bool}
GRID = FLOOR | {"?floors": [FLOOR | {"height_m": NUMBER}]}
SECTION_TRAJECTORY = {"truth_from_map_m_q": [NUMBER], "se3": ATE}
METRICS = {
    "?coverage": COVERAGE, "?trajectory": TRAJECTORY, "?queries": QUERIES,
    "?loops": {"num_accepted": int, "num_rejected": int},
    "?map": {"?cloud": {"?surface_distance_median_m": NUMBER, "?surface_distance_p90_m": NUMBER},
             "?grid": GRID},
    "?sections": dict,
}  # fmt: skip
LASER_STATISTICS = ("mean", "median", "p90")
STRETCH = {f"{name}_{kind}_{unit}": NUMBER for name, unit in (("translation", "m"), ("rotation", "deg")) for kind in LASER_STATISTICS}
WALL_KEYS = ("thickness_mean_cells", "thickness_median_cells", "thickness_p90_cells", "doubled_percent")
LASER_TRAJECTORY = {
    "num_scans_with_truth": int, "missing_percent": NUMBER, "truth_from_map_m_q": [NUMBER], "se3": ATE, "sim3": ATE,
    "relative_1m": {"num_pairs": int, "num_missing": int}, "relative_10m": {"num_pairs": int, "num_missing": int},
}  # fmt: skip
LASER = {
    "num_scans": int, "num_scans_with_pose": int, "path_length_m": NUMBER, "?num_keyscans": int,
    "?trajectory": LASER_TRAJECTORY,
    "?relations": {"num_relations": int, "num_missing": int},
    "?walls": {f"?{key}": UNKNOWN_OR_NUMBER for key in WALL_KEYS},
    "?map": {"?grid": GRID},
}  # fmt: skip
RELATIONS = {f"{name}_{kind}_{unit}": UNKNOWN_OR_NUMBER if kind == "std" else NUMBER for kind in ("mean", "std") for name, unit in (
    ("translation", "m"), ("translation_squared", "m2"), ("rotation", "deg"), ("rotation_squared", "deg2"))}  # fmt: skip
MEDIANS = [f"{statistic}_{kind}" for statistic in ("median", "p90")
           for kind in ("translation_error_cm", "rotation_error_deg")]  # fmt: skip
RECALLS = [f"recall_{max_cm}cm_{max_deg}deg_percent" for max_cm, max_deg in RECALL_THRESHOLDS]
RELATIVE = [f"{name}_{kind}_{unit}" for name, unit in (("translation", "m"), ("rotation", "deg")) for kind in ("rmse", "median")]
PROTOCOL = dict.fromkeys(MEDIANS + RECALLS, UNKNOWN_OR_NUMBER) | {"num_wrong": int}


def read_metrics(path):
    """The content; {} without a path. Raises DataError naming file and figure."""
    if path is None:
        return {}
    metrics = read_object(path, METRICS)
    for name, suffix in (("rpe_per_frame", ""), ("rpe_per_metre", "_per_m")):
        motion = metrics.get("trajectory", {}).get(name, {})
        if motion.get("num_pairs"):
            check(motion, {f"{error}{suffix}": NUMBER for error in RELATIVE}, f"{path}: {name}")
    queries = metrics.get("queries", {})
    if "num_with_truth" in queries:
        check(queries, dict.fromkeys(PROTOCOLS, PROTOCOL), f"{path}: queries")
    laser = laser_figures(metrics)
    if laser:
        check(laser, LASER, f"{path}: sections")
    for name in ("relative_1m", "relative_10m"):
        stretch = laser.get("trajectory", {}).get(name, {})
        if stretch.get("num_pairs"):
            check(stretch, STRETCH, f"{path}: sections: {name}")
    relations = laser.get("relations", {})
    if relations.get("num_relations", 0) > relations.get("num_missing", 0):
        check(relations, RELATIONS, f"{path}: sections: relations")
    for figures in section_figures(metrics):
        check(figures, {"?coverage": COVERAGE, "?trajectory": SECTION_TRAJECTORY}, f"{path}: sections")
    for figures in (metrics, *section_figures(metrics)):
        if len(figures.get("trajectory", {}).get("truth_from_map_m_q", range(7))) != 7:
            raise DataError(f"{path}: truth_from_map_m_q is not a pose; {REMEDY}")
    return metrics


def section_figures(metrics):
    """The figures of each job with an evaluation of its own."""
    return [figures for figures in metrics.get("sections", {}).values() if isinstance(figures, dict)]


def lead_figures(metrics, name):
    """The `coverage` or `trajectory` of the map: that of evaluate.py, else that of a job's own evaluation; {} without any."""
    return next((figures[name] for figures in (metrics, *section_figures(metrics)) if name in figures), {})


def laser_figures(metrics):
    """The figures of laser_accuracy.py, whichever job they are of; {} without any."""
    return next((figures for figures in section_figures(metrics) if "num_scans" in figures), {})
