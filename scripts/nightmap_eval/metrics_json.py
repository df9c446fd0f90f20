# SPDX-License-Identifier: Apache-2.0
"""evaluate/metrics.json as the report needs it: names of figures say what they are, whichever job they are of."""

import re

from nightmap_eval.query_errors import PROTOCOLS
from nightmap_site.checked_reading import NUMBER, REMEDY, check, read_object
from nightmap_site.script_errors import DataError

TABLES = ("coverage", "trajectory", "queries", "loops", "map", "cloud", "grid", "walls", "relations", "wheels", "nis", "nees", "landmarks",
          "start", "se3", "sim3", "rpe_per_frame", "rpe_per_metre", "relative_1m", "relative_10m", "num_by_verdict", *PROTOCOLS)  # fmt: skip
SHAPES = dict.fromkeys(TABLES, dict) | dict.fromkeys(("frames_without_pose", "frames_bridged", "frames_apart"), [int]) | {
    "rows": [dict], "floors": [dict], "truth_from_map_m_q": [NUMBER], "query_idx": int, "has_truth": bool, "found": bool, "color_path": str, "status": str,
    "reason": str}  # fmt: skip
UNITS = "m|m2|cm|deg|deg2|percent|cells|per_m|ratio_start|ratio_se3"
FIGURE = re.compile(rf".*_(?:{UNITS})|scale|mean|mean_per_degree_of_freedom|iou|iou_median|\w+_per_sigma")
MAY_BE_UNKNOWN = re.compile(r".*(?:percent|_cells|_std_\w+|error_cm|error_deg|width_error_m)|iou|iou_median")
UNKNOWN_OR_NUMBER = (*NUMBER, type(None))
LASER_STATISTICS = ("mean", "median", "p90")
WALL_KEYS = ("thickness_mean_cells", "thickness_median_cells", "thickness_p90_cells", "doubled_percent")


class Figures(dict):
    """A table of figures; one that is asked for and lacks is an error that names its place."""

    def __init__(self, table, where):
        super().__init__((name, _checked(value, name, f"{where}: {name}")) for name, value in table.items())
        self._where = where

    def __missing__(self, name):
        raise DataError(f"{self._where}: no {name!r}; {REMEDY}")


def _checked(value, name, where):
    if name == "confusion":  # its names are those of classes
        return value
    if name == "classes" and isinstance(value, dict):  # likewise, of tables
        check(value, dict.fromkeys(value, dict), where)
        return {of: Figures(table, f"{where}: {of}") for of, table in value.items()}
    if name in SHAPES:
        check(value, SHAPES[name], where)
    elif not isinstance(value, (dict, list)) and (name.startswith("num_") or FIGURE.fullmatch(name)):
        check(value, int if name.startswith("num_") else UNKNOWN_OR_NUMBER if MAY_BE_UNKNOWN.fullmatch(name) else NUMBER, where)
    if name == "truth_from_map_m_q" and len(value) != 7:
        raise DataError(f"{where} is not a pose; {REMEDY}")
    if name == "sections":
        check(value, dict.fromkeys(value, dict) if isinstance(value, dict) else dict, where)
    if isinstance(value, list):
        return [Figures(item, where) if isinstance(item, dict) else item for item in value]
    return Figures(value, where) if isinstance(value, dict) else value


def read_metrics(path):
    """The content; {} without a path. Raises DataError naming file and figure."""
    return {} if path is None else Figures(read_object(path, {}), str(path))


def section_figures(metrics):
    """The figures of each job with an evaluation of its own."""
    return list(metrics.get("sections", {}).values())


def lead_figures(metrics, name):
    """The `coverage` or `trajectory` of the map: that of evaluate.py, else that of the last job with an evaluation of its own; {} without any."""
    return next((figures[name] for figures in (metrics, *reversed(section_figures(metrics))) if name in figures), {})


def laser_figures(metrics):
    """The figures of laser_accuracy.py, whichever job they are of; {} without any."""
    return next((figures for figures in section_figures(metrics) if "num_scans" in figures), {})
