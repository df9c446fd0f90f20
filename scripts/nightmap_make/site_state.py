# SPDX-License-Identifier: Apache-2.0
"""The state of a site on disk: the places of its files, and the shards, tiles and floors that its lists name."""

import os

from nightmap_eval import unit_lists
from nightmap_eval.script_errors import DataError


def _floor_stems(site_dir):
    return [row["yaml"].removesuffix(".yaml") for row in unit_lists.read_floors(os.path.join(site_dir, "grid"))]


READERS = (("frames", "shard", "frames/shards.txt", unit_lists.read_shards),
           ("tiles", "tile", "tiles/tiles.txt", unit_lists.read_tiles),
           ("grid", "floor", "grid/floors.json", _floor_stems))  # fmt: skip


class SiteState:
    """The places of a site's files and its units; with the declaration, they determine the rules."""

    def __init__(self, name, folder, data, build="build", config=None):
        self.name, self.folder, self.data, self.build = name, folder, data, build
        self.config = config or f"{folder}/config"
        self.lists = {"shard": [], "query": [], "tile": [], "floor": []}
        self.damaged, self.interrupted = set(), set()
        self.is_synthetic = self.has_queries = False
        self.imports, self.stamps = {}, {}

    def source(self, name):
        """Path of an input that no job makes: the recordings' folder, or a part of the site's config."""
        return self.data if name == "data" else f"{self.config}/{name}/{self.name}.toml"

    def has(self, condition):
        return {None: True, "synthetic": self.is_synthetic, "queries": self.has_queries}[condition]

    def read_lists(self, tell):
        """Reads the lists of shards, tiles and floors that exist. The job of a damaged list must run again;
        tell(message) says so."""
        for job, kind, path, reader in READERS:
            if not os.path.lexists(f"{self.folder}/{path}"):
                continue
            try:
                self.lists[kind] = reader(self.folder)
            except DataError as error:
                self.damaged.add(job)
                tell(f"nightmap: {error}: {job} makes it anew")
        self.has_queries = unit_lists.has_queries(self.folder)
