# SPDX-License-Identifier: Apache-2.0
"""The state of a site on disk: the places of its files, and the shards, tiles, floors and other units that its lists name."""

import collections
import os

from nightmap_site import unit_lists
from nightmap_site.script_errors import DataError
from nightmap_site.toml_file import read_toml


# Readers of lists, by what these list. The rules of a site follow from them and from whether there are queries.
READERS = {"shard": unit_lists.read_shards, "tile": unit_lists.read_tiles,
           "floor": lambda folder: [row["yaml"].removesuffix(".yaml") for row in unit_lists.read_floors(os.path.join(folder, "grid"))]}  # fmt: skip


class SiteState:
    """The places of a site's files and its units; with the declaration, they determine the rules."""

    def __init__(self, name, folder, data, build="build", config=None):
        self.name, self.folder, self.data, self.build = name, folder, data, build
        self.config = config or f"{folder}/config"
        self.lists = collections.defaultdict(list)
        self.damaged = set()
        self.is_synthetic = False
        self.tables, self.stamps = {}, {}  # tables: of the site's config

    @property
    def imports(self):
        return self.tables.get("import", {})

    def source(self, name):
        """Path of an input that no job makes: the recordings' folder, a copy of the site's config, or what QUERY asks."""
        return self.data if name == "data" else f"{self.config}/{name}/{self.name}.toml"

    def config_of(self, job):
        """Path of the effective config of a job with a program."""
        return f"{self.config}/{job.options}.toml"

    def has(self, condition):
        """Whether a job with this `when` runs: a word, or a key of the site's config."""
        if condition in (None, "synthetic", "queries"):
            return {None: True, "synthetic": self.is_synthetic, "queries": bool(self.lists["query"])}[condition]
        value = self.tables
        for key in condition.split("."):
            value = value.get(key) if isinstance(value, dict) else None
        return bool(value)

    def read_lists(self, pipeline, tell):
        """Reads the lists of units that exist. The job of a damaged list must run again; tell(message) says so."""
        for job in pipeline.jobs.values():
            path = f"{self.folder}/{job.folder}/{next(iter(job.outputs.values()))}"
            if not (pipeline.lists_units(job) or job.lists == "query") or not os.path.lexists(path):
                continue
            try:
                self.lists[job.lists] = self._read_list(job, path)
            except DataError as error:
                self.damaged.add(job.name)
                tell(f"nightmap: {error}: {job.name} makes it anew")

    def _read_list(self, job, path):
        if job.lists == "query":
            return unit_lists.read_queries(path)
        reader = READERS.get(job.lists)
        return reader(self.folder) if reader else unit_lists.read_units(path, f"{job.lists}s")

    def may_have_queries(self):
        """Whether the site's config or QUERY asks for some, whatever the list of queries says: one that is damaged says nothing."""
        asked = f"{self.config}/asked/{self.name}.toml"
        return bool(self.tables.get("query") or self.tables.get("hold_out_every") or os.path.exists(asked) and read_toml(asked).get("query"))
