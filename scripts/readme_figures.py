#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""readme_figures: draws docs/<site>.png from a site's artifacts: two frames, and the floor plan with the
trajectory, its loops and a planned path.

Exit codes: 0 written; 1 missing data, or a picture above 300 KiB; 2 wrong command line.
"""

import argparse
from pathlib import Path

from PIL import Image

from nightmap_eval.artifacts import Frames, write_atomic
from nightmap_eval.drawing import draw_grid, draw_path, draw_trajectory, plt, to_png
from nightmap_eval.grid import read_grid
from nightmap_eval.ways import loop_ends
from nightmap_eval.report_plan import read_path, read_path_figures
from nightmap_eval.trajectory import read_tum
from nightmap_site.script_errors import DataError, run_main
from nightmap_site.site import Site

CHECKOUT = Path(__file__).resolve().parent.parent
MAX_BYTES = 300 * 1024


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--site-dir", type=Path, default=CHECKOUT / "maps" / "demo")
    parser.add_argument("--data", type=Path, default=CHECKOUT / "data")
    parser.add_argument("--out", type=Path, help="default: docs/<site>.png")
    return parser.parse_args()


def show_frames(figure, cells, data, rows):
    for cell, row in zip(cells, rows):
        axes = figure.add_subplot(cell)
        with Image.open(data / row["color_path"]) as picture:
            small = picture.convert("RGB")
            small.thumbnail((320, 320))
        axes.imshow(small)
        axes.set_title(f"frame {row['frame_idx']}", fontsize=9)
        axes.axis("off")


def show_plan(axes, site):
    estimate = read_tum(site.needed("map_frame", "trajectory"))
    draw_grid(axes, read_grid(site.needed("grid", "yaml")))
    draw_trajectory(axes, estimate.positions_m, loop_ends(site, estimate)[0])
    path_m = read_path(site)
    if path_m is not None and len(path_m) and read_path_figures(site).get("floor", 0) == 0:
        draw_path(axes, path_m)
    axes.set_xlabel("x (m)")
    axes.set_ylabel("y (m)")
    axes.legend(fontsize=8, loc="upper left", bbox_to_anchor=(1.0, 1.0))


def draw(site, data):
    figure = plt.figure(figsize=(10, 4.6))
    layout = figure.add_gridspec(2, 2, width_ratios=(1, 2.6), wspace=0.12, hspace=0.15)
    rows = Frames(site).rows
    shown = (rows[len(rows) // 5], rows[3 * len(rows) // 5])
    show_frames(figure, (layout[0, 0], layout[1, 0]), data, shown)
    show_plan(figure.add_subplot(layout[:, 1]), site)
    return to_png(figure, dpi=95)


def main():
    arguments = parse_arguments()
    site = Site(arguments.site_dir)
    out = arguments.out or CHECKOUT / "docs" / f"{site.name}.png"
    png = draw(site, arguments.data)
    if len(png) > MAX_BYTES:
        raise DataError(f"{out}: would be {len(png)} bytes, above {MAX_BYTES}")
    write_atomic(out, png)
    print(f"{out}: {len(png) / 1024:.0f} KiB")


if __name__ == "__main__":
    run_main(main)
