#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""seeds: evaluates sites with several seeds and prints the medians as a Markdown table.

Each COLUMN is SITE[:PROFILE][+KEY=VALUE]...: a site of configs/sites, or a path as tests/bench/laser/NAME, with another
profile than its own and values over it, as make's SET takes them. For each column and seed it runs `make evaluate` with
MAPS=<maps>/<profile and values>/seed_<n>; Make keeps the results that are up to date. Figures where one bad seed matters
show the worst seed. A seed does not change a recording. To render another made-up building per seed, give each its own
folder, as in --data 'data/{seed}'. Another option of a made-up recording than synthesize.seed takes the number of the seed,
counted from 1, with --vary.
With --page it puts the table between the markers `<!-- NAME:begin -->` and `<!-- NAME:end -->` of that page.
Exit codes: 0 done; 1 a run failed or a result is missing; 2 wrong command line.
"""

import argparse
import math
import re
import statistics
import subprocess
from dataclasses import dataclass
from pathlib import Path

from checkout import CHECKOUT
from nightmap_eval.figure_page import put_figure
from nightmap_eval.metrics_json import UNKNOWN_OR_NUMBER
from nightmap_site.checked_reading import check, read_json
from nightmap_site.script_errors import DataError, run_main

THRESHOLDS = ((2, 2), (5, 5))  # cm and degrees; those of metrics.json are more


def _query_rows(protocol):
    """Rows of the errors after one alignment of the whole map, or of the frames around each query."""
    rows = [(f"{protocol} median (cm)", f"queries.{protocol}.median_translation_error_cm", 1, "{:.1f}"),
            (f"{protocol} median (deg)", f"queries.{protocol}.median_rotation_error_deg", 1, "{:.2f}"),
            (f"{protocol} 90 % (cm)", f"queries.{protocol}.p90_translation_error_cm", 1, "{:.1f}")]  # fmt: skip
    for max_cm, max_deg in THRESHOLDS:
        recall = f"queries.{protocol}.recall_{max_cm}cm_{max_deg}deg_percent"
        rows.append((f"{protocol} {max_cm} cm, {max_deg} deg (%)", recall, 1, "{:.0f}"))
    return rows


def _laser_rows():
    """Rows of a map of laser scans."""
    trajectory = "sections.grid.trajectory"
    rows = [("scans with a pose", "sections.grid.num_scans_with_pose", 1, "{:.0f}"), ("of", "sections.grid.num_scans", 1, "{:.0f}"),
            ("path (m)", "sections.grid.path_length_m", 1, "{:.0f}"),
            ("ATE RMSE, SE(3) (cm)", f"{trajectory}.se3.ate_rmse_m", 100, "{:.2f}"),
            ("ATE RMSE, Sim(3) (cm)", f"{trajectory}.sim3.ate_rmse_m", 100, "{:.2f}"),
            ("ATE RMSE, SE(3), worst seed (cm)", f"{trajectory}.se3.ate_rmse_m", 100, "{:.2f}", max)]  # fmt: skip
    for metres in (1, 10):
        rows += [(f"motion over {metres} m, mean (cm)", f"{trajectory}.relative_{metres}m.translation_mean_m", 100, "{:.2f}"),
                 (f"motion over {metres} m, mean (deg)", f"{trajectory}.relative_{metres}m.rotation_mean_deg", 1, "{:.2f}")]  # fmt: skip
    return [*rows,
            ("loops accepted", "sections.grid.loops.num_accepted", 1, "{:.0f}"),
            ("false loops accepted, worst seed", "sections.grid.loops.num_false_accepted", 1, "{:.0f}", max),
            ("revisits closed, worst seed (%)", "sections.grid.loops.revisits_closed_percent", 1, "{:.0f}", min),
            ("held-out scans", "sections.test_localize.num_queries", 1, "{:.0f}"),
            ("held-out scans located", "sections.test_localize.num_by_verdict.located", 1, "{:.0f}"),
            ("held-out scans in a wrong place, worst seed", "sections.test_localize.num_wrong", 1, "{:.0f}", max),
            ("held-out scans, median (cm)", "sections.test_localize.median_translation_error_cm", 1, "{:.1f}"),
            ("held-out scans, median (deg)", "sections.test_localize.median_rotation_error_deg", 1, "{:.2f}"),
            ("wall thickness, median (cells)", "sections.grid.walls.thickness_median_cells", 1, "{:.2f}"),
            ("wall thickness, 90 % (cells)", "sections.grid.walls.thickness_p90_cells", 1, "{:.2f}"),
            ("wall drawn twice (%)", "sections.grid.walls.doubled_percent", 1, "{:.1f}"),
            ("seen cells right (%)", "sections.grid.map.grid.seen_right_percent", 1, "{:.1f}"),
            ("free cells right (%)", "sections.grid.map.grid.free_right_percent", 1, "{:.1f}"),
            ("occupied cells right (%)", "sections.grid.map.grid.occupied_right_percent", 1, "{:.1f}")]  # fmt: skip


def _ceiling_rows():
    """Rows of a robot with an upward camera; the pose at the start is that of the truth."""
    odometry = "sections.odometry"
    ours, wheels = f"{odometry}.trajectory.start", f"{odometry}.wheels"
    return [("pictures", f"{odometry}.coverage.num_frames", 1, "{:.0f}"),
            ("without a pose, worst seed", f"{odometry}.coverage.num_frames_without_pose", 1, "{:.0f}", max),
            ("position RMSE (cm)", f"{ours}.ate_rmse_m", 100, "{:.2f}"),
            ("position RMSE, worst seed (cm)", f"{ours}.ate_rmse_m", 100, "{:.2f}", max),
            ("largest position error, worst seed (cm)", f"{ours}.ate_max_m", 100, "{:.1f}", max),
            ("heading RMSE (deg)", f"{ours}.rotation_rmse_deg", 1, "{:.2f}"),
            ("heading RMSE, worst seed (deg)", f"{ours}.rotation_rmse_deg", 1, "{:.2f}", max),
            ("position RMSE, SE(2) (cm)", f"{odometry}.trajectory.se3.ate_rmse_m", 100, "{:.2f}"),
            ("position RMSE, Sim(2) (cm)", f"{odometry}.trajectory.sim3.ate_rmse_m", 100, "{:.2f}"),
            ("largest position error, Sim(2), worst seed (cm)", f"{odometry}.trajectory.sim3.ate_max_m", 100, "{:.1f}", max),
            ("position RMSE of wheels alone (cm)", f"{wheels}.start.ate_rmse_m", 100, "{:.0f}"),
            ("heading RMSE of wheels alone (deg)", f"{wheels}.start.rotation_rmse_deg", 1, "{:.1f}"),
            ("times better than wheels alone", f"{wheels}.position_ratio_start", 1, "{:.0f}"),
            ("likewise, worst seed", f"{wheels}.position_ratio_start", 1, "{:.0f}", min),
            ("NEES within its 95 % bounds (%)", f"{odometry}.nees.within_percent", 1, "{:.0f}"),
            ("NEES, mean (3 is right)", f"{odometry}.nees.mean", 1, "{:.1f}"),
            ("NIS per degree of freedom (1 is right)", f"{odometry}.nis.mean_per_degree_of_freedom", 1, "{:.2f}"),
            ("landmarks", f"{odometry}.num_landmarks", 1, "{:.0f}"),
            ("landmark error, median (cm)", f"{odometry}.landmarks.start.error_median_m", 100, "{:.2f}"),
            ("landmark error, 90 % (cm)", f"{odometry}.landmarks.start.error_p90_m", 100, "{:.2f}"),
            ("loops", f"{odometry}.num_loops", 1, "{:.0f}")]  # fmt: skip


# Title, place in metrics.json, factor, format; the statistic over seeds is the median unless named.
ROWS = (
    ("frames mapped", "coverage.num_frames_with_pose", 1, "{:.0f}"),
    ("of", "coverage.num_frames", 1, "{:.0f}"),
    ("path (m)", "trajectory.truth_path_length_m", 1, "{:.1f}"),
    ("ATE RMSE, SE(3) (cm)", "trajectory.se3.ate_rmse_m", 100, "{:.2f}"),
    ("ATE RMSE, Sim(3) (cm)", "trajectory.sim3.ate_rmse_m", 100, "{:.2f}"),
    ("scale", "trajectory.sim3.scale", 1, "{:.4f}"),
    ("RPE (cm/m)", "trajectory.rpe_per_metre.translation_rmse_m_per_m", 100, "{:.2f}"),
    ("RPE (deg/m)", "trajectory.rpe_per_metre.rotation_rmse_deg_per_m", 1, "{:.2f}"),
    ("ATE RMSE, SE(3), worst seed (cm)", "trajectory.se3.ate_rmse_m", 100, "{:.2f}", max),
    ("recall of masks (%)", "sections.features.recall_percent", 1, "{:.1f}"),
    ("precision of masks (%)", "sections.features.precision_percent", 1, "{:.1f}"),
    ("masked of people who move (%)", "sections.moving.masked_of_moving_percent", 1, "{:.1f}"),
    ("masked of people who pause (%)", "sections.moving.masked_of_pausing_percent", 1, "{:.1f}"),
    ("false loops accepted, worst seed", "loops.num_false_accepted", 1, "{:.0f}", max),
    ("revisits closed, worst seed (%)", "loops.revisits_closed_percent", 1, "{:.0f}", min),
    ("queries", "queries.num_with_truth", 1, "{:.0f}"),
    ("queries located", "queries.num_by_verdict.located", 1, "{:.0f}"),
    ("queries in a wrong place, worst seed", "queries.num_wrong", 1, "{:.0f}", max),
    *(row for name in ("global", "local") for row in _query_rows(name)),
    ("cloud to surface, median (cm)", "map.cloud.surface_distance_median_m", 100, "{:.2f}"),
    ("90 % (cm)", "map.cloud.surface_distance_p90_m", 100, "{:.2f}"),
    ("seen cells right (%)", "map.grid.seen_right_percent", 1, "{:.1f}"),
    ("free cells right (%)", "map.grid.free_right_percent", 1, "{:.1f}"),
    ("occupied cells right (%)", "map.grid.occupied_right_percent", 1, "{:.1f}"),
    ("furniture voxels of the nearest class (%)", "sections.join_labels.furniture_right_percent", 1, "{:.1f}"),
    ("furniture voxels of a class in them (%)", "sections.join_labels.furniture_right_percent_with_borders", 1, "{:.1f}"),
    ("furniture voxels off borders right (%)", "sections.join_labels.furniture_right_percent_off_borders", 1, "{:.1f}"),
    ("things", "sections.things.num_true", 1, "{:.0f}"),
    ("things found (%)", "sections.things.found_percent", 1, "{:.1f}"),
    ("false things (%)", "sections.things.false_percent", 1, "{:.1f}"),
    ("overlap of things, median", "sections.things.iou_median", 1, "{:.2f}"),
    *_laser_rows(),
    *_ceiling_rows(),
)


@dataclass(frozen=True)
class Column:
    """A site with a profile and values over it; `text` is its title."""

    text: str
    site: str  # path of its config without ".toml"
    profile: str
    settings: tuple

    @classmethod
    def of(cls, text):
        """The column that SITE[:PROFILE][+KEY=VALUE]... names."""
        site, *settings = text.split("+")
        site, _, profile = site.partition(":")
        return cls(text.rpartition("/")[2], site if "/" in site else f"configs/sites/{site}", profile, tuple(settings))

    @property
    def name(self):
        return Path(self.site).name

    def maps(self, maps, seed):
        """The folder of a seed; values have one of their own, since Make compares a site with its last config."""
        return Path(maps) / re.sub(r"[^\w.-]", "_", "+".join([self.profile, *self.settings]).strip("+")) / f"seed_{seed}"


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("columns", nargs="+", type=Column.of, metavar="SITE[:PROFILE][+KEY=VALUE]", help="columns of the table")
    parser.add_argument("--seeds", type=int, default=5, help="number of seeds, counted from 0 (default 5)")
    parser.add_argument("--maps", type=Path, default=CHECKOUT / "maps", help="results")
    parser.add_argument("--data", default=str(CHECKOUT / "data"), help="folder of the recordings; {seed} in it: one per seed")
    parser.add_argument("--vary", metavar="KEY", help="option of the recording that takes the number of the seed, from 1")
    parser.add_argument("--name", default="accuracy", help="name of the table in that page")
    parser.add_argument("--page", type=Path, help="page that receives the table")
    parser.add_argument("--no-run", action="store_true", help="only collect existing results")
    arguments = parser.parse_args()
    if arguments.seeds < 1:
        parser.error("--seeds must be at least 1")
    return arguments


def run_make(column, seed, maps, data, vary=None):
    """Evaluates one seed; raises DataError when make fails."""
    command = ["make", "-C", str(CHECKOUT), "evaluate", f"SITE={column.name}", f"SEED={seed}",
               f"SITES={(CHECKOUT / column.site).parent}", f"MAPS={maps.resolve()}", f"DATA={Path(data.format(seed=seed)).resolve()}"]  # fmt: skip
    settings = list(column.settings)
    if "{seed}" in data:
        settings.append(f"{vary}={seed + 1}" if vary else f"synthesize.seed={seed}")
    if settings:
        command.append("SET=" + " ".join(settings))
    if column.profile:
        command.append(f"PROFILE={column.profile}")
    if subprocess.run(command, check=False).returncode != 0:
        raise DataError(f"{' '.join(command)} failed, see above")


def collect(arguments, column):
    """metrics.json of every seed of a column."""
    metrics = []
    for seed in range(arguments.seeds):
        maps = column.maps(arguments.maps, seed)
        if not arguments.no_run:
            run_make(column, seed, maps, arguments.data, arguments.vary)
        path = maps / column.name / "evaluate" / "metrics.json"
        metrics.append(read_json(path))
        for _, dotted, *_ in ROWS:
            check(look_up(metrics[-1], dotted), UNKNOWN_OR_NUMBER, f"{path}: {dotted}")
    return metrics


def look_up(metrics, dotted):
    """Value at a path of keys; None where a part is missing."""
    for key in dotted.split("."):
        metrics = metrics.get(key) if isinstance(metrics, dict) else None
    return metrics


def cell(all_metrics, dotted, factor, text_format, choose=statistics.median):
    """One value for all seeds. Only errors can be missing (for example when nothing was located), so a missing
    value counts as infinite; an infinite result prints as n/a."""
    values = [look_up(metrics, dotted) for metrics in all_metrics]
    chosen = choose(math.inf if value is None else factor * value for value in values)
    if math.isinf(chosen):
        return "n/a"
    num_known = sum(value is not None for value in values)
    text = text_format.format(chosen)
    return text if num_known == len(values) else f"{text} ({num_known} of {len(values)} seeds)"


def make_table(metrics_of_column):
    """One column per title; rows without any value are left out."""
    lines = ["| | " + " | ".join(metrics_of_column) + " |", "|---|" + "---:|" * len(metrics_of_column)]
    for title, *row in ROWS:
        cells = [cell(metrics, *row) for metrics in metrics_of_column.values()]
        if any(text != "n/a" for text in cells):
            lines.append(f"| {title} | " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


def main():
    arguments = parse_arguments()
    table = make_table({column.text: collect(arguments, column) for column in arguments.columns})
    caption = f"Medians over {arguments.seeds} seeds.\n\n" if arguments.seeds > 1 else ""
    if arguments.page:
        put_figure(arguments.page, arguments.name, caption + table)
    print(table, end="")


if __name__ == "__main__":
    run_main(main)
