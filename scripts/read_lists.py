#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Prints which shards, tiles and floors a site has, as words for the Makefile to ask for while it is parsed.

shard=NNNN tile=X_Y near=X_Y:A_B,C_D floor=NAME.yaml queries, as far as the lists are there, and
damaged=STAGE for each list that is not as its stage writes it: Make runs that stage again. Make gets
checked words only; the lists themselves it never reads.
Exit codes: 0 printed; 1 a list cannot be read at all.
"""

import os
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

from nightmap_eval import lists  # noqa: E402
from nightmap_eval.errors import DataError, run_main  # noqa: E402


def shard_words(site_dir):
    return [f"shard={name}" for name in lists.read_shards(site_dir)]


def tile_words(site_dir):
    tiles = lists.read_tiles(site_dir)
    known = set(tiles)
    return [word for tile in tiles for word in (f"tile={tile}", f"near={tile}:{','.join(lists.near(tile, known))}")]


def floor_words(site_dir):
    return [f"floor={row['yaml']}" for row in lists.read_floors(os.path.join(site_dir, "grid"))]


READERS = (
    ("frames", "frames/shards.txt", shard_words),
    ("tiles", "tiles/tiles.txt", tile_words),
    ("grid", "grid/floors.json", floor_words),
)


def words(site_dir, quiet):
    for stage, name, reader in READERS:
        if not os.path.lexists(os.path.join(site_dir, name)):
            continue
        try:
            yield from reader(site_dir)
        except DataError as error:
            yield f"damaged={stage}"
            if not quiet:
                print(f"nightmap: {error}: {stage} makes it anew", file=sys.stderr)
    if lists.has_queries(site_dir):
        yield "queries"


def main():
    site_dir, *quiet = sys.argv[1:]
    print(*words(site_dir, bool(quiet)))


if __name__ == "__main__":
    run_main(main)
