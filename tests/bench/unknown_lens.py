#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""unknown_lens: how well pictures of unknown lenses are located, and whether their standard deviations are honest.

Takes a site that `make localize` has made, locates its queries again as if less were known of their lens, and measures them
against the truth with the map aligned around each query (LOCAL of query_errors.py). Prints a Markdown table with a row per case.
Exit codes: 0 done; 1 a run failed; 2 wrong command line.
"""

import json
import math
import os
import tempfile
from dataclasses import dataclass
from pathlib import Path

from command_line import parser_of  # first: it makes the packages of scripts/ importable
import numpy as np
from nightmap_eval.artifacts import read_csv
from nightmap_eval.query_errors import PROTOCOLS, read_located
from nightmap_eval.trajectory import associate, read_tum
from nightmap_site.script_errors import run_main
from PIL import Image
from stage_run import LOCALIZE_OUTPUTS, Programs, localize_inputs

COLUMNS = ("case", "queries", "located (%)", "recall (%)", "median error (cm)", "90 % below (cm)", "wrong (> 50 cm)",
           "error / sigma: median", "90 % below")  # fmt: skip
EXIF, FOV, NOTHING = 0.05, 0.15, 0.35  # focal_sigma_ratio, the defaults of the queries stage
USUAL_FOV_DEG = 62


@dataclass
class Case:
    """guess: focal length over the true one, or None for that of a usual lens; kept: share of width and height that a
    centred crop keeps; sigma: focal_sigma_ratio, None for the cameras as they are."""

    name: str
    sigma: float | None
    guess: float | None = 1.0
    kept: float = 1.0


CASES = [Case("calibrated", None), Case("field of view right", FOV)] + [
    Case(f"field of view off: focal length {100 * (scale - 1):+.0f} %", FOV, scale) for scale in (0.8, 0.9, 0.95, 1.05, 1.1, 1.2)
] + [
    Case("EXIF, cropped to 70 %", EXIF, 0.7, 0.7),
    Case("nothing known", NOTHING, None),
    Case("nothing known, cropped to 70 %", NOTHING, None, 0.7),
]  # fmt: skip


def parse_arguments():
    parser = parser_of(__doc__, "data", "build", "threads")
    parser.add_argument("site", type=Path, help="folder of a site's results, MAPS/<site>")
    parser.add_argument("--max-cm", type=float, default=5, help="largest error of a recalled picture, cm")
    parser.add_argument("--max-deg", type=float, default=1, help="likewise of its rotation, degrees")
    parser.add_argument("--cases", nargs="+", type=int, default=range(len(CASES)), help="numbers of the cases, from 0")
    return parser.parse_args()


def cropped_size(width, height, kept):
    return round(kept * width), round(kept * height)


def as_known(camera, case):
    """A camera of query_cameras.json with what the case knows of it: no distortion, and the axis in the middle."""
    if case.sigma is None:
        return camera
    color = camera["color"]
    width, height = cropped_size(color["width"], color["height"], case.kept)
    usual = max(width, height) / 2 / math.tan(math.radians(USUAL_FOV_DEG / 2))
    focal = usual if case.guess is None else case.guess * color["fx"]
    middle = {"cx": (width - 1) / 2, "cy": (height - 1) / 2, "k1": 0, "k2": 0, "p1": 0, "p2": 0, "k3": 0}
    return camera | {"color": {"width": width, "height": height, "fx": focal, "fy": focal} | middle, "focal_sigma_ratio": case.sigma}


def write_cameras(source, path, case):
    listed = json.loads(source.read_text())
    version = listed["version"] if case.sigma is None else 2
    path.write_text(json.dumps(listed | {"version": version, "cameras": [as_known(c, case) for c in listed["cameras"]]}))


def crop_pictures(names, data, folder, kept):
    """Writes the middle of each picture to the same path in `folder`."""
    for name in names:
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        with Image.open(data / name) as picture:
            width, height = cropped_size(*picture.size, kept)
            left, top = (picture.width - width) // 2, (picture.height - height) // 2
            picture.crop((left, top, left + width, top + height)).save(folder / name)


def locate(arguments, case, folder):
    """Runs localize as the case knows the lenses; returns its queries.csv."""
    site, data = arguments.site, arguments.data
    folder.mkdir()
    write_cameras(site / "queries/query_cameras.json", folder / "cameras.json", case)
    if case.kept < 1:
        crop_pictures([row["color_path"] for row in read_csv(site / "queries/queries.csv", ("color_path",))], data, folder / "data", case.kept)
        data = folder / "data"
    inputs = localize_inputs(site, data) | {"cameras": folder / "cameras.json"}
    Programs(arguments.build, arguments.threads).run("localize", inputs, LOCALIZE_OUTPUTS, folder / "located")
    return folder / "located/queries.csv"


def map_with_truth(site, max_gap_ns=20_000_000):
    """Poses of the map's frames, and their true ones."""
    frames, truth = read_tum(site / "map_frame/trajectory.tum"), read_tum(site / "frames/ground_truth.tum")
    pairs = associate(frames.times_ns, truth.times_ns, max_gap_ns)
    return frames.select(pairs[:, 0]), truth.select(pairs[:, 1])


def measured(queries_csv, truth, map_pair):
    """Measures of located queries with truth: errors in m and degrees, and standard deviations of the position in m."""
    rows, _, located = read_located(queries_csv)
    sigma_of = {int(row["time_ns"]): float(row["position_sigma_m"]) for row in rows if row["status"] == "located"}
    row_of = {int(time_ns): i for i, time_ns in enumerate(truth.times_ns)}
    located = located.select([i for i, time_ns in enumerate(located.times_ns) if int(time_ns) in row_of])
    times_ns = [int(time_ns) for time_ns in located.times_ns]
    metres, degrees = PROTOCOLS["local"](located, truth.select([row_of[time_ns] for time_ns in times_ns]), *map_pair)
    return metres, degrees, np.array([sigma_of[time_ns] for time_ns in times_ns])


def row(name, metres, degrees, sigmas_m, num_queries, max_cm, max_deg):
    """Cells of the table. A picture that was not located has no error, and counts as not recalled."""
    if len(metres) == 0:
        return [name, f"{num_queries}", "0", "0", *["-"] * (len(COLUMNS) - 4)]
    ratios = metres / sigmas_m
    good = np.count_nonzero((100 * metres <= max_cm) & (degrees <= max_deg))
    return [name, f"{num_queries}", f"{100 * len(metres) / num_queries:.0f}", f"{100 * good / num_queries:.0f}",
            f"{100 * np.median(metres):.1f}", f"{100 * np.quantile(metres, 0.9):.1f}", f"{np.count_nonzero(metres > 0.5)}",
            f"{np.median(ratios):.2f}", f"{np.quantile(ratios, 0.9):.2f}"]  # fmt: skip


def line(cells):
    return f"| {' | '.join(cells)} |"


def main():
    arguments = parse_arguments()
    truth, map_pair = read_tum(arguments.site / "queries/query_ground_truth.tum"), map_with_truth(arguments.site)
    print(line(COLUMNS), "|---|" + "---:|" * (len(COLUMNS) - 1), sep="\n", flush=True)
    parts = []
    with tempfile.TemporaryDirectory(dir=os.environ.get("TMPDIR")) as folder:
        for number in arguments.cases:
            parts.append(measured(locate(arguments, CASES[number], Path(folder) / str(number)), truth, map_pair))
            print(line(row(CASES[number].name, *parts[-1], len(truth), arguments.max_cm, arguments.max_deg)), flush=True)
    together = [np.concatenate(values) for values in zip(*parts)]
    print(line(row("all", *together, len(truth) * len(parts), arguments.max_cm, arguments.max_deg)))


if __name__ == "__main__":
    run_main(main)
