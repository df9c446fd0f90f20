#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""measure_faults: damages recordings in known ways, maps them, and tells whether `make check` or the verdict noticed.

A row per recording and fault goes to --rows as a line of JSON; a row that is there is not measured again. The table follows
from the rows: the exit codes, the verdict, the checks that are not good, and the ATE against that of the clean recording.
A map without a verdict or with less than half of the frames counts as ruined. Recordings and maps are removed after each row.
With --page, tables for people go to `<!-- faults:begin -->` and `<!-- random_faults:begin -->` of a page.
Exit codes: 0 done; 1 something could not be measured; 2 wrong command line.
"""

import argparse
import collections
import json
import math
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

sys.path[:0] = [str(Path(__file__).parents[1])]
from checkout import CHECKOUT  # first: it makes the packages of scripts/ importable
from damage import FAULTS, damage
from nightmap_eval.figure_page import put_figure

# The checks (or words of a failed run's message) that name a fault with the right advice.
NAMED_BY = {
    "depth_x5": ("near surfaces", "far surfaces", "camera height"),
    "depth_by_5": ("near surfaces", "far surfaces", "camera height"),
    "color_depth_swapped": ("depth must be one channel of 16 bits",),
    "depth_shifted": ("depth against color, frames",),
    "scrambled_order": ("names against times", "frames unlike the one before", "speed"),
    "blurred_30": ("blurred frames",),
    "frozen": ("frozen pictures",),
    "exposure_jump": ("exposure jumps",),
    "unregistered_depth": ("depth against color, place", "color at edges of depth"),
    "intrinsics_10": ("focal length of camera 0",),
    "low_texture": ("frames without texture",),
    "gaps": ("gaps in time",),
    "people": ("held-out rays", "what moves", "moving share"),
    "duplicate_times": ("times must increase",),
    "counter_as_floor": ("camera height", "below the floor", "warnings of the floor"),
}


LEAST = (1.5, 5)
BANDS = ("below 1.5", "1.5 to 5", "over 5, or less than half of the frames in the map")


class Bench:
    def __init__(self, arguments):
        self.arguments, self.data, self.maps, self.sites = arguments, arguments.work / "data", arguments.work / "maps", arguments.work / "sites"

    def measure(self, site, fault, seed):
        name = f"{site}_{fault}_{seed}"
        said = damage(fault, seed, CHECKOUT / f"configs/sites/{site}.toml", self.arguments.data, self.arguments.work, name)
        check = self._make("check", name)
        made = check if self.arguments.check_only else self._make("evaluate", name)
        row = {"site": site, "fault": fault, "seed": seed, "said": said, "check_exit": check.returncode, "exit": made.returncode,
               "message": _errors(check.stdout) or _errors(made.stdout)}  # fmt: skip
        for job in ("check", "verdict"):
            verdict = _read(self.maps / name / job / "verdict.json")
            row[job] = verdict.get("verdict")
            row[f"{job}_checks"] = [[c["name"], c["value"], c["verdict"], c["advice"]] for c in verdict.get("checks", [])]
        metrics = _read(self.maps / name / "evaluate" / "metrics.json")
        row["ate_m"] = metrics.get("trajectory", {}).get("se3", {}).get("ate_rmse_m")
        coverage = metrics.get("coverage", {})
        row["mapped"] = coverage.get("num_frames_with_pose", 0) / max(1, coverage.get("num_frames", 1))
        if not self.arguments.keep:
            shutil.rmtree(self.data / name, ignore_errors=True)
            shutil.rmtree(self.maps / name, ignore_errors=True)
        return row

    def _make(self, goal, name):
        variables = [f"{key}={value}" for key, value in (("SITE", name), ("DATA", self.data), ("MAPS", self.maps), ("SITES", self.sites),
                                                         ("THREADS", self.arguments.threads))]  # fmt: skip
        return subprocess.run(["make", "-C", str(CHECKOUT), "--no-print-directory", goal, *variables], stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, text=True, check=False)  # fmt: skip


def _errors(text):
    found = re.findall(r"(?m)^.*\berror\b.*$|^nightmap: .*$", text)
    return "\n".join(line for line in found if "failed, exit code" not in line)[:2000]


def _read(path):
    return json.loads(path.read_text(encoding="utf-8")) if path.is_file() else {}


def not_good(row):
    return [item for item in row["verdict_checks"] or row["check_checks"] if item[2] != "good"]


def is_named(row):
    """Whether a check that is not good, or the message of a failed run, names the fault."""
    names = NAMED_BY.get(row["fault"], ())
    texts = [item[0] for item in not_good(row)] + ([row["message"]] if row["exit"] or row["check_exit"] else [])
    return any(name in text for name in names for text in texts)


def ratio(row, clean):
    """Ratio of the ATE to that of the clean recording; infinite where there is no map, or less than half of one."""
    if row["ate_m"] is None or row["mapped"] < 0.5:
        return math.inf
    return row["ate_m"] / clean[row["site"]]["ate_m"]


def table(rows):
    clean = {row["site"]: row for row in rows if row["fault"] == "clean"}
    for row in rows:
        names = ", ".join(f"{name} {value:.3g}" for name, value, _, _ in not_good(row)) or row["message"].split("\n")[0][-90:]
        of_clean = ratio(row, clean) if row["site"] in clean else math.nan
        named = "" if row["fault"] in ("clean", "random") else "named" if is_named(row) else "NOT NAMED"
        yield (f"{row['site'][:10]:10} {row['said'][:60]:60} {row['check_exit']}{row['exit']} {row['verdict'] or row['check']!s:12} "
               f"ATE x{of_clean:<7.2f} {row['mapped']:.2f} {named:9} {names}")  # fmt: skip
    yield from _counts(rows, clean)


def _counts(rows, clean):
    single = [row for row in rows if row["fault"] in FAULTS]
    yield f"{sum(map(is_named, single))} of {len(single)} faults named"
    yield f"{sum((row['verdict'] or row['check']) == 'good' for row in clean.values())} of {len(clean)} clean recordings good"
    drawn = [row for row in rows if row["fault"] == "random" and row["site"] in clean]
    missed = [row for row in drawn if ratio(row, clean) > 5 and row["verdict"] == "good"]
    bad = [row for row in drawn if ratio(row, clean) > 5]
    refused = [row for row in drawn if ratio(row, clean) < 1.5 and row["verdict"] == "do not use"]
    yield (f"{len(drawn)} random: {len(bad)} with ATE over 5 times, {len(missed)} of them good (must be 0), "
           f"{sum(row['verdict'] in (None, 'do not use') for row in bad)} not to be used; "
           f"{sum(ratio(row, clean) < 1.5 for row in drawn)} below 1.5 times, {len(refused)} of them not to be used (must be 0)")  # fmt: skip


def faults_markdown(rows, sites):
    """A row per fault, a column per site."""
    clean = {row["site"]: row for row in rows if row["fault"] == "clean"}
    cells = {(row["site"], row["fault"]): _cell(row, clean) for row in rows if row["fault"] in FAULTS}
    lines = ["| fault | " + " | ".join(f"`{site}`: verdict; ATE; advice" for site in sites) + " |", "|---" * (len(sites) + 1) + "|"]
    lines += [f"| {fault} | " + " | ".join(cells.get((site, fault), "") for site in sites) + " |" for fault in FAULTS]
    single = [row for row in rows if row["fault"] in FAULTS]
    counts = [f"{sum(is_named(row) for row in single if row['site'] == site)} of {sum(row['site'] == site for row in single)}"
              for site in sites]  # fmt: skip
    quiet = [clean[site]["verdict"] if site in clean else "" for site in sites]
    return "\n".join([*lines, "| named | " + " | ".join(counts) + " |", "| clean | " + " | ".join(quiet) + " |"])


def _cell(row, clean):
    times = ratio(row, clean)
    verdict = "error" if row["exit"] else row["verdict"]
    return f"{verdict}; {'none' if math.isinf(times) else f'{times:.1f}'}; {'named' if is_named(row) else '**not named**'}"


def random_markdown(rows):
    """Verdicts by how much worse the map is."""
    clean = {row["site"]: row for row in rows if row["fault"] == "clean"}
    counts = collections.Counter()
    for row in rows:
        if row["fault"] == "random":
            times = ratio(row, clean)
            counts[sum(times >= least for least in LEAST), "error" if row["exit"] else row["verdict"]] += 1
    verdicts = ("good", "look at this", "do not use", "error")
    lines = ["| ATE over that of the clean recording | " + " | ".join(verdicts) + " |", "|---" + "|---:" * len(verdicts) + "|"]
    for i, name in enumerate(BANDS):
        lines.append(f"| {name} | " + " | ".join(str(counts[i, verdict]) for verdict in verdicts) + " |")
    return "\n".join(lines)


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("sites", nargs="*", help="sites whose recordings have the layout tum")
    parser.add_argument("--faults", nargs="*", default=["clean", *FAULTS])
    parser.add_argument("--random", type=int, default=0, help="also this number of randomly damaged copies, in turn of each site")
    parser.add_argument("--seed", type=int, default=0, help="of the faults")
    parser.add_argument("--data", type=Path, required=True, help="folder of the recordings")
    parser.add_argument("--work", type=Path, required=True, help="folder for damaged copies and their maps")
    parser.add_argument("--rows", type=Path, required=True, help="file of the rows, a line of JSON each")
    parser.add_argument("--check-only", action="store_true", help="only make check: no map, no ATE")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--page", type=Path, help="page that receives the tables")
    parser.add_argument("--keep", action="store_true", help="keep copies and maps")
    return parser.parse_args()


def main():
    arguments = parse_arguments()
    rows = [json.loads(line) for line in arguments.rows.read_text().splitlines()] if arguments.rows.is_file() else []
    wanted = [(site, fault, arguments.seed) for site in arguments.sites for fault in arguments.faults]
    wanted += [(arguments.sites[i % len(arguments.sites)], "random", i) for i in range(arguments.random)]
    done = {(row["site"], row["fault"], row["seed"]) for row in rows}
    bench = Bench(arguments)
    for each in wanted:
        if each in done:
            continue
        rows.append(bench.measure(*each))
        with arguments.rows.open("a", encoding="utf-8") as file:
            file.write(json.dumps(rows[-1]) + "\n")
        os.sync()
    print("\n".join(table(rows)))
    if arguments.page:
        put_figure(arguments.page, "faults", faults_markdown(rows, arguments.sites))
        put_figure(arguments.page, "random_faults", random_markdown(rows))


if __name__ == "__main__":
    main()
