#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""detectors: evaluates sites with every feature detector and prints the medians over several seeds.

For each site, detector and seed it runs `make evaluate` with SET=features.detector="..." and
MAPS=<maps>/<detector>/seed_<n>; Make keeps the results that are up to date. Prints one row per site and
detector. With --page it puts the table between the markers `<!-- detectors:begin -->` and
`<!-- detectors:end -->` of that file.
Exit codes: 0 done; 1 a result is missing; 2 wrong command line. A run that fails counts as a missing
value: a detector that cannot map a site is a result.
"""

from pathlib import Path

from command_line import markdown, parser_of, put_into_page
from seeds import CHECKOUT, cell, run_make
from nightmap_site.checked_reading import read_json
from nightmap_site.script_errors import DataError, run_main

DETECTORS = ("sift", "orb", "brisk", "fast_orb", "fast_brisk")
COLUMNS = (
    ("frames mapped", "coverage.num_frames_with_pose", 1, "{:.0f}"),
    ("of", "coverage.num_frames", 1, "{:.0f}"),
    ("ATE RMSE, SE(3) (cm)", "trajectory.se3.ate_rmse_m", 100, "{:.2f}"),
    ("queries", "queries.num_with_truth", 1, "{:.0f}"),
    ("in a wrong place, worst seed", "queries.num_wrong", 1, "{:.0f}", max),
    ("local median (cm)", "queries.local.median_translation_error_cm", 1, "{:.1f}"),
    ("local 5 cm, 5 deg (%)", "queries.local.recall_5cm_5deg_percent", 1, "{:.0f}"),
)


def parse_arguments():
    parser = parser_of(__doc__, "page")
    parser.add_argument("sites", nargs="+", help="names of configs/sites/<site>.toml")
    parser.add_argument("--seeds", type=int, default=5, help="number of seeds, counted from 0 (default 5)")
    parser.add_argument("--maps", type=Path, default=CHECKOUT / "maps", help="results")
    parser.add_argument("--data", default=str(CHECKOUT / "data"), help="recordings")
    arguments = parser.parse_args()
    if arguments.seeds < 1:
        parser.error("--seeds must be at least 1")
    return arguments


def collect(arguments, site, detector):
    """metrics.json of every seed; empty for a run that failed."""
    metrics = []
    for seed in range(arguments.seeds):
        maps = arguments.maps / detector / f"seed_{seed}"
        try:
            run_make(site, seed, maps, arguments.data, [f'features.detector="{detector}"'])
            metrics.append(read_json(maps / site / "evaluate" / "metrics.json"))
        except DataError as error:
            print(error, flush=True)
            metrics.append({})
    return metrics


def make_table(metrics_of):
    """metrics_of: (site, detector) -> metrics per seed."""
    titles = ("site", "detector", *(title for title, *_ in COLUMNS))
    rows = [[*key, *(cell(metrics, *column) for _, *column in COLUMNS)] for key, metrics in metrics_of.items()]
    return markdown(titles, rows, 2)


def main():
    arguments = parse_arguments()
    pairs = [(site, detector) for site in arguments.sites for detector in DETECTORS]
    table = make_table({pair: collect(arguments, *pair) for pair in pairs})
    put_into_page(arguments, "detectors", f"Medians over {arguments.seeds} seeds.\n\n{table}")
    print(table, end="")


if __name__ == "__main__":
    run_main(main)
