# SPDX-License-Identifier: Apache-2.0
"""The tables of configs/pipeline.toml, changed by those of a profile, and the file and line of each."""

import functools
import os
import re
import tomllib

PORTS = ("in", "out", "beside", "section")  # a profile changes single keys of these


class PipelineError(Exception):
    """The declaration or a config is wrong: a usage error, exit code 2."""


def read_toml(path):
    """The tables of a file, to be left as they are; the dictionary of them is the caller's own."""
    try:
        with open(path, "rb") as file:
            return dict(_parsed(file.read()))
    except FileNotFoundError:
        raise PipelineError(f"{path}: there is no such file") from None
    except (ValueError, RecursionError) as error:
        raise PipelineError(f"{path}: not valid TOML: {error}") from None


@functools.cache  # the pipeline is read once per profile
def _parsed(data):
    return tomllib.loads(data.decode())


class Declaration:
    """jobs: name -> table; goals: name -> table; clashes: tables. As configs/pipeline.toml has them, or changed. why_without: goal
    -> why the profile leaves a job of it out."""

    def __init__(self, path):
        self.path, self._paths = path, [path]
        tables = read_toml(path)
        self.goals, self.clashes = tables.pop("goals", {"map": {"purpose": "the map"}}), tables.pop("clash", [])
        self.jobs, self._left_out, self.why_without = {}, set(), {}
        for name, table in tables.items():
            self.jobs[name] = self._as_table(name, table, path)

    def change(self, path, imports):
        """Applies the tables of a profile: ports and other keys replace or add those of a job, false takes a port away. Several
        tables of one job, [[job]], are applied one after the other."""
        self._paths.insert(0, path)
        tables = read_toml(path)
        tables.pop("include", None)
        self.goals |= tables.pop("goals", {})
        self.clashes = self.clashes + tables.pop("clash", [])
        for name, changes in tables.items():
            for table in changes if isinstance(changes, list) else [changes]:
                self._change_job(name, dict(self._as_table(name, table, path)), imports)

    def _change_job(self, name, table, imports):
        if table.pop("given", None) not in (None, *imports):
            return
        leave_out = table.pop("leave_out", False)
        if leave_out:
            goal = self.jobs.pop(name, {}).get("goal", "map")
            self._left_out.add(name)
            self.why_without |= {goal: leave_out} if isinstance(leave_out, str) else {}
        else:
            self.jobs[name] = _merged(self.jobs.get(name, {}), table)

    def known(self):
        """name -> whether the profile leaves the job out, of all jobs that are declared."""
        return {name: name not in self.jobs for name in [*self.jobs, *self._left_out]}

    def _as_table(self, name, table, path):
        if not isinstance(table, dict) or not all(isinstance(table.get(key, {}), dict) for key in PORTS):
            raise PipelineError(f"{path}: [{name}] must be a table of keys, with tables of ports in, out and beside")
        return table

    def places(self, job):
        """A function that gives the file and line of the job, or of a key of it; the last change first."""
        def place(key=None):
            for path in self._paths:
                line = _line_of(path, job, key)
                if line:
                    return f"{path}:{line}: [{job}]"
            return place() if key else f"{self.path}: [{job}]"
        return place


def overlays(configs, profile, imports=None):
    """Profile -> its pipeline.toml, of the profiles that one includes ([[include]]), in order, and of itself, the last. imports: the keys
    of [import]; None: all that an include may ask for. Raises PipelineError."""
    found = {}

    def add(name, includers):
        path = os.path.join(configs, name, "pipeline.toml")
        if name == "default" or not os.path.exists(path):
            return
        for piece in read_toml(path).get("include", []):
            included = piece.get("profile") if isinstance(piece, dict) and not set(piece) - {"profile", "given"} else None
            if not isinstance(included, str) or not os.path.exists(os.path.join(configs, included, "pipeline.toml")) \
                    or included in (name, *includers):  # fmt: skip
                raise PipelineError(f"{path}: [[include]] has the keys profile, another profile that does not include this one, and given, "
                                    "a key of [import]")  # fmt: skip
            if imports is None or piece.get("given") in (None, *imports):
                add(included, (name, *includers))
        found[name] = path

    add(profile, ())
    return found


def import_keys(configs, profile):
    """The keys of [import] that jobs of a profile read."""
    paths = {os.path.join(configs, "pipeline.toml"), *overlays(configs, profile).values()}
    texts = [text for path in paths if os.path.exists(path) for text in _texts(read_toml(path))]
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
