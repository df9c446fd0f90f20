#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""compare_grids: how far two grids of one building agree, as those of a camera and of a laser.

A and B are folders maps/<site>, whose evaluation aligned them to their truth in the frame of one building, or files map.yaml,
whose frame is that of the building itself (truth/floor_plan.yaml). Each cell that one grid has seen is looked up at its
centre in the other; only cells that both have seen count, and both directions are added up. Prints the share of cells
that are equal, free or occupied, and the share that is equal within one cell: the other grid has that state at the
place or in one of the eight cells around it, as at the edge of a wall that falls on the border of two cells.
Exit codes: 0 done; 1 a grid or an alignment is missing; 2 wrong command line.
"""

import argparse
from pathlib import Path

import numpy as np

import checkout  # noqa: F401  first: it makes the packages of scripts/ importable
from nightmap_eval.grid import FREE, OCCUPIED, UNKNOWN, read_grid
from nightmap_eval.metrics_json import laser_figures, read_metrics
from nightmap_eval.trajectory import Similarity, rotation_matrices
from nightmap_eval.walls_and_doors import Sampler
from nightmap_site.script_errors import DataError, run_main
from nightmap_site.site import Site

AROUND = [(x, y) for y in (-1, 0, 1) for x in (-1, 0, 1)]


def read_sampler(path):
    """The grid of a site or of a file, seen from the building's frame."""
    if path.is_file():
        return Sampler(read_grid(path), Similarity(1.0, np.eye(3), np.zeros(3)), 0.0)
    if not path.is_dir():
        raise DataError(f"{path}: no such folder or file; give maps/<site> or a map.yaml")
    site = Site(path)
    yaml = site.made("grid", "yaml")
    if not yaml:
        raise DataError(f"{path}: no grid; run make map")
    metrics = read_metrics(site.made("evaluate", "metrics"))
    trajectory = metrics.get("trajectory") or laser_figures(metrics).get("trajectory")
    if not trajectory:
        raise DataError(f"{path}: its map is not aligned to a truth; run make evaluate with a site config that names one")
    values = np.array(trajectory["truth_from_map_m_q"])
    building_from_map = Similarity(1.0, rotation_matrices(values[None, 3:])[0], values[:3])
    # The floor of map.yaml is at z = 0 of the map.
    return Sampler(read_grid(yaml), building_from_map, float(values[2]))


def count(one, other):
    """Cells of one grid that the other has seen too: (state of one, equal, equal within a cell) -> number."""
    centres = one.grid.centres_m().reshape(-1, 2)
    states = one.grid.cells.ravel()
    seen = np.flatnonzero(states != UNKNOWN)
    points = np.column_stack([centres[seen], np.zeros(len(seen))])
    in_building = one.building_from_map.apply(points)[:, :2]
    states, there = states[seen], other.states(in_building)
    step_m = max(one.grid.resolution_m, other.grid.resolution_m)
    near = np.zeros(len(seen), dtype=bool)
    for x, y in AROUND:
        near |= other.states(in_building + step_m * np.array([x, y])) == states
    return {state: np.array([np.sum(chosen), np.sum(chosen & (there == states)), np.sum(chosen & near)])
            for state in (FREE, OCCUPIED) for chosen in [(there != UNKNOWN) & (states == state)]}  # fmt: skip


def compare(a, b):
    """Figures of two Samplers; shares are None where the grids have no cell in common."""
    both = [count(a, b), count(b, a)]
    figures = {}
    for name, states in (("", (FREE, OCCUPIED)), ("free_", (FREE,)), ("occupied_", (OCCUPIED,))):
        num, equal, near = sum(counts[state] for counts in both for state in states)
        figures[f"num_{name}cells"] = int(num)
        figures[f"{name}equal_percent"] = 100 * equal / num if num else None
        figures[f"{name}equal_within_a_cell_percent"] = 100 * near / num if num else None
    return figures


def table(figures):
    lines = ["| cells | compared | equal (%) | equal within a cell (%) |", "|---|---:|---:|---:|"]
    for title, name in (("all", ""), ("free", "free_"), ("occupied", "occupied_")):
        shares = [figures[f"{name}{kind}_percent"] for kind in ("equal", "equal_within_a_cell")]
        shown = ["n/a" if share is None else f"{share:.2f}" for share in shares]
        lines.append(f"| {title} | {figures[f'num_{name}cells']} | {' | '.join(shown)} |")
    return "\n".join(lines)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("grids", nargs=2, type=Path, metavar="GRID", help="maps/<site>, or map.yaml in the frame of the building")
    arguments = parser.parse_args()
    print(table(compare(*map(read_sampler, arguments.grids))))


if __name__ == "__main__":
    run_main(main)
