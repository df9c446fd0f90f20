#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Says which stages a `make report` would rerun now, and for what reason.

Reads the Makefile's rules on stdin, one a line: NAME:OUTPUT,OUTPUT:INPUT,INPUT in any order. `make
-n` cannot answer this: through grouped targets it stops at the first stale stage.
"""
import argparse
import os
import sys
import tomllib

from nightmap_eval.errors import DataError, run_main
from nightmap_eval.reading import read_object, read_toml, using


def read_rules(lines):
    rules = []
    for line in lines:
        name, outputs, inputs = line.strip().split(":")
        rules.append((name, outputs.split(","), [path for path in inputs.split(",") if path]))
    return rules


def in_order(rules):
    """Rules sorted so that what makes an input comes before what reads it."""
    maker = {path: rule for rule in rules for path in rule[1]}
    done, order = set(), []

    def visit(rule):
        if rule[0] in done:
            return
        done.add(rule[0])
        for path in rule[2]:
            if path in maker:
                visit(maker[path])
        order.append(rule)

    for rule in rules:
        visit(rule)
    return order


def config_change(path, out):
    """What differs between a previewed or rewritten config and the one of the stage's report."""
    stage = os.path.basename(path)[:-5]
    reports = [os.path.join(out, stage, name) for name in sorted(os.listdir(os.path.join(out, stage)))
               if name.startswith("report")] if os.path.isdir(os.path.join(out, stage)) else []
    if not reports:
        return ""
    try:
        report = read_object(reports[0], {"?config": str})
        with using(reports[0]):
            old = tomllib.loads(report.get("config", ""))
    except (DataError, OSError):
        return " (what changed cannot be told: the stage's report is damaged)"
    new = read_toml(path)
    changes = [f"{key} {old.get(key)} -> {new[key]}" for key in sorted(new) if old.get(key) != new[key]]
    return f" ({', '.join(changes)})" if changes else ""


def reasons(rule, stale, out):
    _, outputs, inputs = rule
    lost = [path for path in outputs if not os.path.exists(path)]
    if lost:
        return [f"{path} does not exist" for path in lost]
    found = []
    oldest = min(outputs, key=lambda path: os.stat(path).st_mtime_ns)
    time_ns = os.stat(oldest).st_mtime_ns
    for path in inputs:
        if path == "FORCE":
            found.append("its last run was not finished, or a file of its list is lost or damaged")
        elif path in stale:
            found.append(f"{path} will be remade")
        elif not os.path.exists(path):
            found.append(f"{path} does not exist")
        elif os.stat(path).st_mtime_ns > time_ns:
            change = config_change(path, out) if path.endswith(".toml") else ""
            found.append(f"{path} is newer than {oldest}{change}")
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--out", required=True, help="the site's folder")
    arguments = parser.parse_args()
    rules = in_order(read_rules(line for word in sys.stdin for line in word.split()))
    stale = set()
    for rule in rules:
        because = reasons(rule, stale, arguments.out)
        if because:
            stale.update(rule[1])
            more = f" (and {len(because) - 1} more)" if len(because) > 1 else ""
            print(f"{rule[0]}: {because[0]}{more}")
    if not stale:
        print("everything is up to date")
    elif any(rule[0] == "programs" and rule[1][0] in stale for rule in rules):
        print("(after the build, stages whose program came out different rerun too)")
    if any(rule[0] == "frames" and rule[1][0] in stale for rule in rules):
        print("(after frames, shards whose list of frames is the same are left alone)")
    if any(rule[0] == "tiles" and rule[1][0] in stale for rule in rules):
        print("(after tiles, those whose list of keyframes is the same are left alone)")


if __name__ == "__main__":
    run_main(main)
