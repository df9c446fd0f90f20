#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""move_furniture: changes a map as months in a building do, to see who still finds his place in it.

A share of the occupied cells goes, in pieces of the size of furniture, and each piece comes back turned at another place in
free space: so as many false cells are added as true ones went, and a query sees about that share of its view changed.
Furniture in the rectangles of --objects stays, because these places do not change. Writes map.pgm and map.yaml to --out.
Exit codes: 0 done; 1 the map cannot be read; 2 wrong command line.
"""

import argparse
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import checkout  # noqa: E402, F401  first: it makes the packages of scripts/ importable
import numpy as np  # noqa: E402
import yaml  # noqa: E402
from nightmap_eval.grid import FREE, OCCUPIED, UNKNOWN, read_grid  # noqa: E402
from nightmap_site.script_errors import run_main  # noqa: E402

PIECE_M = 0.6  # half the side of a piece
GRAY = {UNKNOWN: 205, FREE: 254, OCCUPIED: 0}
MAX_TRIES = 1000


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("map", type=Path, help="map.yaml of the grid to change")
    parser.add_argument("--out", type=Path, required=True, help="folder for map.pgm and map.yaml")
    parser.add_argument("--share", type=float, default=0.3, help="of the occupied cells that go (default 0.3)")
    parser.add_argument("--seed", type=int, default=1, help="of the choice (default 1)")
    parser.add_argument("--objects", type=Path, help="objects.yaml: rectangles in which nothing changes")
    return parser.parse_args()


def in_objects(grid, path):
    """Mask of the cells whose centres lie within a rectangle."""
    mask = np.zeros(grid.cells.shape, dtype=bool)
    centres_m = grid.centres_m()
    for item in yaml.safe_load(path.read_text())["objects"] or [] if path else []:
        angle = np.radians(item["angle_deg"])
        x, y = centres_m[..., 0] - item["x_m"], centres_m[..., 1] - item["y_m"]
        along, across = np.cos(angle) * x + np.sin(angle) * y, np.cos(angle) * y - np.sin(angle) * x
        mask |= (np.abs(along) <= item["size_x_m"] / 2) & (np.abs(across) <= item["size_y_m"] / 2)
    return mask


def move_furniture(grid, share, seed, fixed):
    """The cells after the change. fixed: mask of what does not change."""
    random = np.random.default_rng(seed)
    cells = grid.cells.copy()
    movable = np.argwhere((cells == OCCUPIED) & ~fixed)
    num_to_move = round(share * np.count_nonzero(cells == OCCUPIED))
    half = max(1, round(PIECE_M / grid.resolution_m))
    gone = np.zeros(cells.shape, dtype=bool)
    pieces = []
    for middle in random.permutation(movable):
        if np.count_nonzero(gone) >= num_to_move:
            break
        near = movable[np.all(np.abs(movable - middle) <= half, axis=1)]
        piece = near[~gone[tuple(near.T)]]
        gone[tuple(piece.T)] = True
        pieces.append(piece - middle)
    cells[gone] = FREE
    for piece in pieces:
        place(piece, cells, fixed, random)
    return cells


def place(piece, cells, fixed, random):
    """Puts a piece, turned, where all of it stands in free space; leaves it out where there is no room."""
    free = np.argwhere((cells == FREE) & ~fixed)
    for _ in range(MAX_TRIES if len(free) else 0):
        angle = random.uniform(0, 2 * np.pi)
        turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        put = np.round(piece @ turn.T).astype(int) + free[random.integers(len(free))]
        if np.any(put < 0) or np.any(put >= cells.shape):
            continue
        if np.all(cells[tuple(put.T)] == FREE) and not np.any(fixed[tuple(put.T)]):
            cells[tuple(put.T)] = OCCUPIED
            return


def write_map(source, cells, out):
    """map.pgm and map.yaml, which is that of the source but for the name of the image."""
    out.mkdir(parents=True, exist_ok=True)
    gray = np.select([cells == value for value in GRAY], list(GRAY.values())).astype(np.uint8)
    height, width = gray.shape
    (out / "map.pgm").write_bytes(b"P5\n%d %d\n255\n" % (width, height) + gray[::-1].tobytes())
    lines = ["image: map.pgm" if line.startswith("image:") else line for line in source.read_text().splitlines()]
    (out / "map.yaml").write_text("\n".join(lines) + "\n")


def main():
    arguments = parse_arguments()
    grid = read_grid(arguments.map)
    cells = move_furniture(grid, arguments.share, arguments.seed, in_objects(grid, arguments.objects))
    write_map(arguments.map, cells, arguments.out)
    count = np.count_nonzero
    went, came = count((grid.cells == OCCUPIED) & (cells != OCCUPIED)), count((grid.cells != OCCUPIED) & (cells == OCCUPIED))
    print(f"{went} of {count(grid.cells == OCCUPIED)} occupied cells went, {came} came")


if __name__ == "__main__":
    run_main(main)
