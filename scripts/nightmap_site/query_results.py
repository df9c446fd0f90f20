# SPDX-License-Identifier: Apache-2.0
"""The queries of a site, pictures or laser scans: what localize found of each, and which of them QUERY named. Imports little."""

import math
import re

from nightmap_site import unit_lists
from nightmap_site.checked_reading import read_csv, read_toml, using

SCAN_NUMBER = re.compile(r"#[1-9]\d*$", re.ASCII)
MAX_BELOW_FLOOR_M = 0.1  # heading as the plan stage defines it


def asked_names(site):
    """The names of the queries of QUERY, as in the lists."""
    config, asked = site.config / "queries" / f"{site.name}.toml", site.config / "asked" / f"{site.name}.toml"
    of_scans = site.pipeline.asks == "scans"
    listed = site.made("queries", "list" if of_scans else "queries")
    if not (config.exists() and asked.exists() and listed and read_toml(asked)):
        return set()
    if of_scans:  # named after their log, with #1, #2 ... for several of one
        with using(asked):
            logs = {table["scans"] for table in read_toml(asked)["query"]}
        return {name for name in unit_lists.whole(unit_lists.read_queries, listed) if name in logs or SCAN_NUMBER.sub("", name) in logs}
    tables = read_toml(config)
    with using(config):  # sequences of pictures are numbered after those of the site's config
        first = len(tables.get("sequence", [])) + len(tables.get("query", []))
    rows = read_csv(listed, ("color_path", "sequence_idx"))
    with using(listed):
        return {row["color_path"] for row in rows if int(row["sequence_idx"]) >= first}


class Query:
    """A row of localize/queries.csv: place and heading in the map frame, counter-clockwise from x. They are those of the camera and
    its viewing direction, its z, or of a robot that scanned and its x. Both are None without a pose."""

    def __init__(self, row, asks):
        self.name, self.verdict, self.reason = row["color_path"], row["status"], row["reason"]
        self.place_m = self.heading_deg = self.sigma_m = self.sigma_deg = None
        if row["tx_m"]:
            self.place_m = [float(row[name]) for name in ("tx_m", "ty_m", "tz_m")]
            x, y, z, w = (float(row[name]) for name in ("qx", "qy", "qz", "qw"))
            ahead = ((1 - 2 * (y * y + z * z), 2 * (x * y + z * w)) if asks == "scans"
                     else (2 * (x * z + y * w), 2 * (y * z - x * w)))  # fmt: skip
            self.heading_deg = math.degrees(math.atan2(ahead[1], ahead[0]))
            self.sigma_m, self.sigma_deg = (float(row[name]) for name in ("position_sigma_m", "rotation_sigma_deg"))


def read_queries(site):
    path = site.needed("localize", "queries")
    pose = ("tx_m", "ty_m", "tz_m", "qx", "qy", "qz", "qw", "position_sigma_m", "rotation_sigma_deg")
    rows = read_csv(path, ("color_path", "status", "reason", *pose))
    with using(path):
        return [Query(row, site.pipeline.asks) for row in rows]


class Floors:
    """The floors of the grid if the map has several."""

    def __init__(self, site):
        listed = site.made("grid", "floors")
        rows = unit_lists.whole(unit_lists.read_floors, listed.parent) if listed else []
        self._floors = sorted((row["height_m"], row["number"]) for row in rows)
        self.are_several = len(rows) > 1

    def number_at(self, z_m):
        """Number of the floor below a height; the lowest floor's if none is below."""
        below = [number for height_m, number in self._floors if height_m <= z_m + MAX_BELOW_FLOOR_M]
        return below[-1] if below else self._floors[0][1]
