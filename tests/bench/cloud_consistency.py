#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""cloud_consistency: what point_cloud.min_consistent_frames = 0, 1 and 2 do to the clouds of sites.

0 keeps every voxel, 1 drops what other keyframes see through, 2 asks for a second keyframe that measured the voxel. Runs
`make map` with each value and prints a Markdown table from the report and the receipts of the clouds; with --page it goes
between `<!-- cloud_consistency:begin -->` and `<!-- cloud_consistency:end -->`.
Exit codes: 0 done; 1 a run failed or a result is missing; 2 wrong command line.
"""

from pathlib import Path

from command_line import markdown, parser_of, put_into_page
from seeds import CHECKOUT, run_make

from nightmap_site.checked_reading import NUMBER, read_object
from nightmap_site.job_results import StageResult
from nightmap_site.script_errors import run_main

VALUES = (0, 1, 2)
REPORT = {"num_points": int, "held_out_rays_agreeing_percent": NUMBER, "held_out_rays_blocked_percent": NUMBER}
TITLES = ("site", "min_consistent_frames", "points (thousand)", "held-out rays that agree (%)", "that are blocked (%)",
          "thickness of flat places, median (mm)", "CPU time of point_cloud (s)")  # fmt: skip


def row(folder, site, value):
    """Cells of one cloud; `folder`: maps/<site>/point_cloud."""
    report = read_object(folder / "report.json", REPORT)
    tiles = StageResult(folder)
    thickness_m = [tile["plane_thickness_median_m"] for tile in tiles.reports if "plane_thickness_median_m" in tile]
    return [site, str(value), f"{report['num_points'] / 1000:.1f}", f"{report['held_out_rays_agreeing_percent']:.1f}",
            f"{report['held_out_rays_blocked_percent']:.1f}",
            f"{1000 * max(thickness_m):.1f}" if thickness_m else "n/a", f"{tiles.cpu_time_s():.1f}"]  # fmt: skip


def main():
    parser = parser_of(__doc__, "page")
    parser.add_argument("sites", nargs="+", help="names of configs/sites/<site>.toml")
    parser.add_argument("--maps", type=Path, default=CHECKOUT / "maps", help="results, in a folder per value")
    parser.add_argument("--data", default=str(CHECKOUT / "data"), help="recordings")
    arguments = parser.parse_args()
    rows = []
    for site in arguments.sites:
        for value in VALUES:
            maps = arguments.maps / f"consistent_{value}"
            run_make(site, 0, maps, arguments.data, [f"point_cloud.min_consistent_frames={value}"], "map")
            rows.append(row(maps / site / "point_cloud", site, value))
    table = markdown(TITLES, rows)
    print(table, end="")
    put_into_page(arguments, "cloud_consistency", table)


if __name__ == "__main__":
    run_main(main)
