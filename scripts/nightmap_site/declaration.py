# SPDX-License-Identifier: Apache-2.0
"""The jobs of a profile as its pieces declare them, and the file and line of each."""

import functools
import os
import re

from nightmap_site.pieces import PORTS, DeclarationFile, Pieces
from nightmap_site.toml_file import read_toml


class Declaration:
    """jobs: name -> table; goals: name -> table; clashes: tables. why_without: goal -> why the profile has no job of it. imports: the
    keys of [import] of the site."""

    def __init__(self, configs, profile, imports):
        self.path = os.path.join(configs, "pipeline.toml")
        read_toml(self.path)  # it must exist
        self._configs, self._imports, self._pieces = configs, imports, Pieces(configs, profile, imports)
        files = self._pieces.files
        self.goals = {goal: table for file in files for goal, table in file.goals.items()} or {"map": {"purpose": "the map"}}
        self.clashes = [clash for file in files for clash in file.clashes]
        self.why_without = {goal: reason for file in files for goal, reason in file.without.items()}
        self.jobs = {}
        for slot, tables in self._pieces.tables.items():
            self._add(slot, tables)

    def _add(self, slot, tables):
        job = {}
        for table in tables:
            reason = table.keys.get("leave_out")
            if isinstance(reason, str):
                self.why_without[job.get("goal", "map")] = reason
            job = {} if reason else _merged(job, table.keys)
        if any(table.declares for table in tables) or slot not in self._declared_anywhere:  # else it adds to a job of other sites
            self.jobs |= {slot: job} if job else {}

    @functools.cached_property
    def _declared_anywhere(self):
        """The jobs of all profiles."""
        found = {table.slot for tables in self._pieces.tables.values() for table in tables if table.declares}
        for folder in sorted(os.listdir(self._configs)):
            found |= {table.slot for table in DeclarationFile(self._configs, folder).tables if table.declares}
        return found

    def has(self, job, output):
        """Whether the site has the job, or imports the file "import.output"; None when no profile has such a job."""
        if job == "import":
            return output in self._imports
        return job in self.jobs or (False if job in self._declared_anywhere else None)

    def places(self, job):
        """A function that gives the file and line of the job, or of a key of it; the last change first."""
        found = {(table.file.path, table.header): None for table in reversed(self._pieces.tables[job])}

        def place(key=None):
            for path, header in found:
                line = _line_of(path, header, key)
                if line:
                    return f"{path}:{line}: [{header}]"
            return place() if key else f"{self.path}: [{job}]"
        return place


def folders(configs, profile, imports):
    """The folders of configs that a profile is made of, its own the last."""
    return [file.folder for file in Pieces(configs, profile, imports).files if file.folder]


def profiles(configs):
    """Names of the profiles: of all folders but those of sites, and pieces of the default one."""
    of_default = folders(configs, "default", ())[:-1]
    return [name for name in sorted(os.listdir(configs)) if os.path.isdir(os.path.join(configs, name)) and name not in ("sites", *of_default)]


def import_keys(configs, profile):
    """The keys of [import] that jobs of a profile read."""
    texts = [text for tables in Pieces(configs, profile, None).tables.values() for table in tables for text in _texts(table.keys)]
    return {key for text in texts for key in re.findall(r"\bimport\.(\w+)", text)}


def _texts(value):
    if isinstance(value, str):
        return [value]
    values = value.values() if isinstance(value, dict) else value if isinstance(value, list) else ()
    return [text for inner in values for text in _texts(inner)]


def _merged(table, changes):
    merged = table | changes
    for key in PORTS:
        ports = table.get(key, {}) | changes.get(key, {})
        merged[key] = {port: value for port, value in ports.items() if value is not False}
    return merged


def _line_of(path, job, key):
    """Number of the line of [job], or of a key in its table (in.PORT may stand in an inline table)."""
    inside = False
    with open(path, encoding="utf-8") as file:
        for number, line in enumerate(file, 1):
            header = re.match(r"\s*\[\[?\s*([\w.-]+)\s*\]", line)
            if header:
                inside = header[1] == job
                if inside and key is None:
                    return number
            elif inside and key and _declares(line, key):
                return number
    return None


def _declares(line, key):
    table, _, port = key.partition(".")
    name = re.escape(port or key)
    own = rf"\s*{re.escape(table)}\s*\.\s*[\"']?{name}[\"']?\s*=" if port else rf"\s*{name}\s*="
    return re.match(own, line) or port and re.match(rf"\s*{re.escape(table)}\s*=.*[{{,]\s*{name}\s*=", line)
