# SPDX-License-Identifier: Apache-2.0
"""Lists of the shards, tiles and floors of a site: frames/shards.txt, tiles/tiles.txt and grid/floors.json.

The lists are data: this file checks each name before Make, a shell or a path uses it. Every start of make
reads them, so this file imports little.
"""

import json
import math
import os
import re
import stat

from nightmap_site.script_errors import DataError

MAX_BYTES = 1 << 24
HEADER = re.compile(r"nightmap (\w+), version 1, (0|[1-9]\d{0,8}) names")
SHARD = re.compile(r"\d{4,9}", re.ASCII)
TILE = re.compile(r"(0|-?[1-9]\d{0,8})_(0|-?[1-9]\d{0,8})", re.ASCII)
UNIT = re.compile(r"[A-Za-z0-9][\w-]{0,99}", re.ASCII)
FLOOR_YAML = re.compile(r"(map|floor_-?[1-9]\d{0,8})\.yaml", re.ASCII)
RUN_FILE = re.compile(r"(?:report|receipt)_(.+)\.json")


def list_path(site_dir, kind):
    return os.path.join(site_dir, {"shards": "frames", "tiles": "tiles"}[kind], f"{kind}.txt")


def read_data(path):
    """Text of a list. Raises DataError when it is not a plain, small text file."""
    status = os.stat(path)
    if not stat.S_ISREG(status.st_mode) or status.st_size > MAX_BYTES:
        raise DataError(f"{path}: not a list that nightmap wrote")
    with open(path, encoding="utf-8", newline="") as file:
        try:
            return file.read()
        except UnicodeDecodeError:
            raise DataError(f"{path}: not a text file") from None


def _read_names(path, kind):
    header, *names = read_data(path).split("\n")
    found = HEADER.fullmatch(header)
    if not found or found[1] != kind:
        raise DataError(f"{path}:1: not the first line of a list of {kind}")
    if not names or names.pop() or len(names) != int(found[2]):
        raise DataError(f"{path}: cut off: {found[2]} names and a line break at the end are announced")
    return names


def read_shards(site_dir):
    """Names of the shards: 0000, 0001 and so on. Raises DataError when the list is damaged."""
    path = list_path(site_dir, "shards")
    names = _read_names(path, "shards")
    if names != [f"{number:04}" for number in range(len(names))]:
        raise DataError(f"{path}: the names are not 0000, 0001 and so on")
    return names


def read_tiles(site_dir):
    """Names X_Y of the tiles, in order. Raises DataError when the list is damaged."""
    path = list_path(site_dir, "tiles")
    names = _read_names(path, "tiles")
    for number, name in enumerate(names, 2):
        if not TILE.fullmatch(name):
            raise DataError(f"{path}:{number}: not the name of a tile")
    places = [_place(name) for name in names]
    if any(place >= following for place, following in zip(places, places[1:])):
        raise DataError(f"{path}: the tiles are not in order, or one is there twice")
    return names


def read_units(path, kind):
    """Names of the units of any other kind, each once. Raises DataError when the list is damaged."""
    names = _read_names(path, kind)
    for number, name in enumerate(names, 2):
        if not UNIT.fullmatch(name) or names.index(name) != number - 2:
            raise DataError(f"{path}:{number}: not the name of a unit, or there twice")
    return names


def read_queries(path):
    """Names of the queries, which may be any text. Raises DataError when the list is damaged."""
    return _read_names(path, "queries")


def _place(tile):
    return tuple(map(int, tile.split("_")))


def near(tile, tiles):
    """The tile and those of its eight neighbours that are in the set `tiles`, in order."""
    x, y = _place(tile)
    around = (f"{x + dx}_{y + dy}" for dx in (-1, 0, 1) for dy in (-1, 0, 1))
    return [name for name in around if name in tiles]


def read_floors(grid_dir):
    """Rows of floors.json with number, height_m and yaml checked. Raises DataError."""
    path = os.path.join(grid_dir, "floors.json")
    try:
        content = json.loads(read_data(path))
        if (content["format"], content["version"]) != ("nightmap floors", 2):
            raise DataError(f"{path}: not a list of floors of this version")
        rows = list(content["floors"])
        whole = all(type(row["number"]) is int and type(row["height_m"]) in (int, float)
                    and math.isfinite(row["height_m"]) and FLOOR_YAML.fullmatch(row["yaml"]) for row in rows)
    except (ValueError, KeyError, TypeError, RecursionError, OverflowError):
        whole = False
    if not whole or len({row["yaml"] for row in rows}) != len(rows) or 0 not in [row["number"] for row in rows]:
        raise DataError(f"{path}: not a whole list of floors")
    return rows


def whole(reader, folder):
    """Calls a reader of lists; names the remedy for a missing or damaged list, which the caller cannot make again."""
    try:
        return reader(folder)
    except FileNotFoundError as error:
        raise DataError(f"{error.filename}: there is no such list; run make map") from None
    except DataError as error:
        raise DataError(f"{error}; delete the file and run make again") from None


class CurrentRuns:
    """Selects reports and receipts of existing shards and tiles. The others are left over from a longer recording
    or another cut, and do not describe the map. Without a list every file counts."""

    def __init__(self, site_dir):
        self._names = {SHARD: self._read(read_shards, site_dir), TILE: self._read(read_tiles, site_dir)}

    @staticmethod
    def _read(reader, site_dir):
        try:
            return set(reader(site_dir))
        except (DataError, OSError):
            return None

    def has(self, path):
        found = RUN_FILE.fullmatch(os.path.basename(path))
        for pattern, names in self._names.items():
            if found and names is not None and pattern.fullmatch(found[1]):
                return found[1] in names
        return True
