#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""bench_place_search: how long scan_localize takes to find a scan, against the area of the map.

Draws made-up office floors (made_up_floor.py), scans them at random free places, and looks for each scan in the whole map.
Prints a Markdown table and the power of the area by which the CPU time grows; with --page they go between
`<!-- place_search:begin -->` and `<!-- place_search:end -->`.
Exit codes: 0 done; 1 a run failed; 2 wrong command line.
"""

import tempfile
from pathlib import Path

from command_line import parser_of, put_into_page  # first: it makes the packages of scripts/ importable
import numpy as np
from laser.move_furniture import write_map
from made_up_floor import Laser, free_poses, make_floor, scan
from nightmap_eval.grid import OCCUPIED
from nightmap_eval.laser.scan_relocalization import figures, read_scans
from nightmap_eval.sealed_hdf5 import sealed
from nightmap_site.script_errors import run_main
from stage_run import Programs

MAP_YAML = ("image: map.pgm\nmode: trinary\nresolution: {}\norigin: [0, 0, 0]\nnegate: 0\n"
            "occupied_thresh: 0.65\nfree_thresh: 0.196\n")  # fmt: skip
LOCALIZED = {"queries": "queries.csv", "trajectory": "queries.tum", "candidates": "candidates.csv"}
COLUMNS = ("area (m2)", "cells", "occupied cells", "queries", "within 10 cm, 1 deg (%)", "ambiguous (%)", "wrong place (%)",
           "CPU s per query", "memory (MiB)")  # fmt: skip


def parse_arguments():
    parser = parser_of(__doc__, "build", "threads", "page")
    parser.add_argument("--areas", type=float, nargs="+", default=[500, 2000, 5000, 20000], help="m2")
    parser.add_argument("--queries", type=int, default=50, help="scans per map")
    parser.add_argument("--seed", type=int, default=1, help="of floors, places and noise")
    arguments = parser.parse_args()
    if arguments.queries < 1 or min(arguments.areas) < 500:
        parser.error("--queries must be positive, and --areas at least 500: smaller floors have no room for rooms")
    return arguments


def as_list(values, dtype):
    """A list as the programs write it: n x 1."""
    return np.asarray(values, dtype=dtype).reshape(-1, 1)


def write_queries(path, times_ns, scans, laser):
    """queries.h5 with a scan per query (pipeline/laser/scan_queries_io.h); its laser is the robot's middle."""
    names = [str(i).encode() for i in range(len(scans))]
    count = len(scans)
    with sealed(path) as file:
        file.attrs.update({"format": np.bytes_("nightmap scan queries"), "version": np.int32(1),
                           "config": np.bytes_("# made up\n"), "units": np.bytes_("m, rad")})  # fmt: skip
        file["name_offset"] = as_list(np.cumsum([0, *map(len, names)]), np.int64)
        file["name"] = as_list(list(b"".join(names)), np.uint8)
        file["time_ns"] = as_list(times_ns, np.int64)
        file["scan_offset"] = as_list(range(count + 1), np.int64)
        file["query_from_laser"] = np.zeros((count, 3))
        file["beams"] = np.tile([laser.first_rad, laser.step_rad, laser.limit_m], (count, 1)).astype(float)
        file["range_offset"] = as_list(np.cumsum([0, *map(len, scans)]), np.int64)
        file["range_m"] = as_list(np.concatenate(scans), np.float32)
        file["rough_position"] = np.zeros((count, 3))


def write_truth(path, times_ns, poses):
    lines = [f"{time_ns // 10**9}.{time_ns % 10**9:09d} {x:.9f} {y:.9f} 0 0 0 {np.sin(heading / 2):.12f} {np.cos(heading / 2):.12f}"
             for time_ns, (x, y, heading) in zip(times_ns, poses)]  # fmt: skip
    path.write_text("\n".join(lines) + "\n")


def make_question(area_m2, num_queries, seed, folder):
    """Writes map.yaml, queries.h5 and truth.tum; returns the grid."""
    folder.mkdir()
    grid, laser, random = make_floor(area_m2, seed), Laser(), np.random.default_rng(seed)
    poses = free_poses(grid, num_queries, random)
    times_ns = [(i + 1) * 10**9 for i in range(num_queries)]
    (folder / "template.yaml").write_text(MAP_YAML.format(grid.resolution_m))
    write_map(folder / "template.yaml", grid.cells, folder)
    write_queries(folder / "queries.h5", times_ns, [scan(grid, pose, laser, random) for pose in poses], laser)
    write_truth(folder / "truth.tum", times_ns, poses)
    return grid


def measure(arguments, programs, area_m2, folder):
    """Measures one floor: area in m2, CPU seconds per query, and the cells of the table's row."""
    grid = make_question(area_m2, arguments.queries, arguments.seed, folder)
    inputs = {"grid": folder / "map.yaml", "queries": folder / "queries.h5"}
    result = programs.run("scan_localize", inputs, LOCALIZED, folder / "located")
    found = figures(read_scans(folder / "located/queries.csv", folder / "truth.tum"))
    num, area_m2 = found["num_queries"], grid.cells.size * grid.resolution_m**2
    cpu_s = result.cpu_time_s() / num
    ambiguous = 100 * found["num_by_verdict"]["ambiguous"] / num
    row = [f"{area_m2:,.0f}", f"{grid.cells.size:,}", f"{np.count_nonzero(grid.cells == OCCUPIED):,}", f"{num}",
           f"{found['within_10cm_1deg_percent']:.0f}", f"{ambiguous:.0f}", f"{found['wrong_percent']:.0f}",
           f"{cpu_s:.3f}", f"{result.peak_memory_bytes() / 2**20:.0f}"]  # fmt: skip
    return area_m2, cpu_s, row


def growth_exponent(areas_m2, seconds):
    """The power p of seconds = c * area^p, by least squares of the logarithms."""
    return float(np.polyfit(np.log(areas_m2), np.log(seconds), 1)[0])


def table_text(lines, points):
    """`points`: (area in m2, CPU seconds per query) of each line."""
    lines = [f"| {' | '.join(COLUMNS)} |", "|" + "---:|" * len(COLUMNS), *lines]
    if len(points) > 1:
        lines += ["", f"CPU time per query grows as the area to the power of {growth_exponent(*zip(*points)):.2f}."]
    return "\n".join(lines) + "\n"


def table(arguments, folder):
    programs, lines, points = Programs(arguments.build, arguments.threads), [], []
    for i, asked_m2 in enumerate(arguments.areas):
        area_m2, cpu_s, row = measure(arguments, programs, asked_m2, folder / str(i))
        points.append((area_m2, cpu_s))
        lines.append(f"| {' | '.join(row)} |")
        print(lines[-1], flush=True)
    return table_text(lines, points)


def main():
    arguments = parse_arguments()
    with tempfile.TemporaryDirectory() as folder:
        text = table(arguments, Path(folder))
    print(text.splitlines()[-1])
    put_into_page(arguments, "place_search", text)


if __name__ == "__main__":
    run_main(main)
