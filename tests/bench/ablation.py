#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""ablation: locates the same queries in the same map with one option of localize changed at a time.

The maps must exist (`make localize SITE=<site>`); the script does not change them. Prints a Markdown
table per site with medians over --seeds seeds of RANSAC; a query that is not located counts as a
failure. Times are of searching alone, without features; compare only their ratios. With --page the tables go between
`<!-- ablation:begin -->` and `<!-- ablation:end -->` of that file.
Exit codes: 0 done; 1 a map is missing or a run failed; 2 wrong command line.
"""

import argparse
import itertools
import json
import statistics
import subprocess
import tempfile
from pathlib import Path

from checkout import CHECKOUT  # first: it makes the packages of scripts/ importable
from evaluate import evaluate_queries, match_with_truth
from nightmap_eval.figure_page import put_figure
from nightmap_eval.trajectory import read_truth, read_tum
from nightmap_site.checked_reading import read_object, read_text
from nightmap_site.job_results import RECEIPT
from nightmap_site.script_errors import DataError, run_main
from nightmap_site.toml_file import read_toml

SEARCHES = ("combined", "2d_to_3d", "3d_to_2d", "tree")
PUBLISHED = CHECKOUT / "configs/published_rgbd/localize.toml"


def variants():
    """Name, and the options that differ from the map's config, as TOML has their values."""
    published = {key: json.dumps(value) for key, value in read_toml(str(PUBLISHED)).items()}
    extensions = {key: value for key, value in published.items() if key != "solver"}
    return (
        ("as configured", {}),
        *((f"search {search}, {solver}", {"search": f'"{search}"', "solver": f'"{solver}"'})
          for search, solver in itertools.product(SEARCHES, ("p3p", "dlt6"))),
        ("as published (DLT6, no extensions)", published),
        ("as published, but P3P", extensions | {"solver": '"p3p"'}),
        *((f"without {name}", {name: value}) for name, value in extensions.items()),
    )  # fmt: skip


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("sites", nargs="+", help="sites that have a map")
    parser.add_argument("--maps", type=Path, required=True, help="results of make")
    parser.add_argument("--data", type=Path, required=True, help="recordings")
    parser.add_argument("--build", type=Path, required=True, help="programs")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--seeds", type=int, default=5, help="seeds of RANSAC")
    parser.add_argument("--page", type=Path, help="page that receives the tables")
    return parser.parse_args()


def with_options(config, options):
    """The lines of a stage's config (one option per line) with some values replaced."""
    lines, left = [], dict(options)
    for line in config.splitlines():
        name = line.split("=")[0].strip()
        lines.append(f"{name} = {left.pop(name)}" if name in left else line)
    if left:
        raise DataError(f"localize has no option {', '.join(left)}; make the map again")
    return "\n".join(lines) + "\n"


class Site:
    """A finished map, its queries, and the mapping frames with their truth."""

    def __init__(self, name, arguments):
        self.name, self.arguments = name, arguments
        self.folder = arguments.maps / name
        truth = self.folder / "frames" / "ground_truth.tum"
        if not truth.exists() or not (self.folder / "localize" / "queries.csv").exists():
            raise DataError(f"{self.folder}: no located queries with a truth; run make localize SITE={name}")
        estimate = read_tum(self.folder / "map_frame" / "trajectory.tum")
        self.map_pair = match_with_truth(estimate, read_truth(truth))
        self.config = read_text(self.folder / "config" / "localize.toml")

    def run(self, options, work):
        """Figures of the queries, and CPU seconds per query without feature extraction."""
        config = work / "localize.toml"
        config.write_text(with_options(self.config, options), encoding="utf-8")
        inputs = {"queries": "queries/queries.csv", "cameras": "queries/query_cameras.json",
                  "configured": "frames/cameras.json", "calibrated": "adjust/cameras.json",
                  "landmarks": "landmarks/landmarks.h5", "vocabulary": "vocabulary/vocabulary.h5"}  # fmt: skip
        outputs = {"queries": "queries.csv", "trajectory": "queries.tum", "receipt": "receipt.json"}
        command = [self.arguments.build / "run" / "localize", "--config", config,
                   "--threads", str(self.arguments.threads), "--log-level", "err",
                   "--in", f"data={self.arguments.data}"]  # fmt: skip
        for name, path in inputs.items():
            command += ["--in", f"{name}={self.folder / path}"]
        for name, path in outputs.items():
            command += ["--out", f"{name}={work / path}"]
        run = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        if run.returncode != 0:
            raise DataError(f"{' '.join(map(str, command))}\n{run.stdout}\nthe run failed, see above")
        truth = self.folder / "queries" / "query_ground_truth.tum"
        figures = evaluate_queries(work / "queries.csv", truth, self.map_pair)
        parts = {part["name"]: part["cpu_time_s"] for part in read_object(work / "receipt.json", RECEIPT)["parts"]}
        return figures, parts["locate"] / max(1, figures["num_queries"])


def row(site, name, options, num_seeds):
    with tempfile.TemporaryDirectory() as folder:
        runs = [site.run(options | {"seed": str(seed)}, Path(folder)) for seed in range(num_seeds)]

    def median(get, text):
        values = [get(figures) for figures, _ in runs]
        return "n/a" if any(value is None for value in values) else text.format(statistics.median(values))

    local = [median(lambda f, key=key: f["local"][key], text) for key, text in (
        ("median_translation_error_cm", "{:.2f}"), ("median_rotation_error_deg", "{:.2f}"),
        ("recall_2cm_2deg_percent", "{:.0f}"), ("recall_5cm_5deg_percent", "{:.0f}"))]  # fmt: skip
    counts = [median(lambda f, verdict=verdict: f["num_by_verdict"][verdict], "{:.0f}")
              for verdict in ("located", "ambiguous")]  # fmt: skip
    wrong = max(figures["num_wrong"] for figures, _ in runs)
    time_ms = 1e3 * statistics.median(seconds for _, seconds in runs)
    return [name, *counts, f"{wrong}", *local, f"{time_ms:.1f}"]


def table(site, rows):
    titles = ["localize", "located", "ambiguous", "wrong (worst seed)", "median (cm)", "median (deg)",
              "2 cm, 2 deg (%)", "5 cm, 5 deg (%)", "CPU ms per query"]  # fmt: skip
    lines = [titles, ["---"] + ["---:"] * (len(titles) - 1), *rows]
    return f"{site}:\n\n" + "\n".join("| " + " | ".join(line) + " |" for line in lines) + "\n"


def main():
    arguments = parse_arguments()
    tables = []
    for name in arguments.sites:
        site, rows = Site(name, arguments), []
        for title, options in variants():
            rows.append(row(site, title, options, arguments.seeds))
            print(" | ".join(rows[-1]), flush=True)
        tables.append(table(name, rows))
        print(tables[-1], flush=True)
    if arguments.page:
        put_figure(arguments.page, "ablation", "\n".join(tables))


if __name__ == "__main__":
    run_main(main)
