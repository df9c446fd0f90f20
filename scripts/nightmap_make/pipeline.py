# SPDX-License-Identifier: Apache-2.0
"""The declared pipeline, configs/pipeline.toml, with the replacements of a profile. That file explains each key."""

import os
import re
import tomllib

UNITS = ("site", "shard", "tile")
LISTS = ("shard", "query", "tile", "floor")
CONDITIONS = ("synthetic", "queries", "asked")
KEYS = {"purpose", "program", "script", "unit", "goal", "when", "lists", "folder", "in", "out", "beside", "optional",
        "finds", "reads", "stamp", "kB_per_frame"}  # fmt: skip
REFERENCE = re.compile(r"(?P<job>\w+)\.(?P<output>[\w.]+)(?: of (?P<units>near|previous and this))?(?P<if_made> if made)?")
SOURCES = ("site", "queries", "data")
STAMPS = ("recordings", "pictures")


class PipelineError(Exception):
    """The declaration or a config is wrong: a usage error, exit code 2."""


class Input:
    """A port and its source: site, queries or data, or an output of a job."""

    def __init__(self, port, text, where):
        self.port, self.text, self.source = port, text, text if text in SOURCES else None
        self.job = self.output = self.units = None
        self.if_made = False
        if self.source:
            return
        found = REFERENCE.fullmatch(text)
        if not found:
            raise PipelineError(f"{where}: in.{port} = \"{text}\" is no reference like \"features.features of previous and this\"")
        self.job, self.output, self.units = found["job"], found["output"], found["units"]
        self.if_made = bool(found["if_made"])


class Job:
    def __init__(self, name, table, where):
        unknown = set(table) - KEYS
        if unknown:
            raise PipelineError(f"{where}: [{name}]: unknown key '{min(unknown)}'; known keys: {', '.join(sorted(KEYS))}")
        self.name, self.where = name, where
        self.purpose = table.get("purpose", "")
        self.script = table.get("script")
        self.program = None if self.script else table.get("program", name)
        self.unit = self._one_of(table, "unit", UNITS, "site")
        self.when = self._one_of(table, "when", CONDITIONS, None)
        self.lists = self._one_of(table, "lists", LISTS, None)
        self.goal = table.get("goal", "map")
        self.folder = table.get("folder", name)
        self.inputs = [Input(port, text, f"{where}: [{name}]") for port, text in table.get("in", {}).items()]
        self.outputs, self.beside = dict(table.get("out", {})), dict(table.get("beside", {}))
        self.optional = dict(table.get("optional", {}))
        self.finds = [tuple(text.split(".", 1)) for text in table.get("finds", [])]
        self.kB_per_frame = table.get("kB_per_frame", 0)
        self.stamp = self._one_of(table, "stamp", STAMPS, None)
        self.reads = list(table.get("reads", []))
        if not self.purpose or not self.outputs:
            raise PipelineError(f"{where}: [{name}] needs a purpose and an output")

    def _one_of(self, table, key, known, default):
        value = table.get(key, default)
        if value is not default and value not in known:
            raise PipelineError(f"{self.where}: [{self.name}]: {key} = \"{value}\" is none of {', '.join(known)}")
        return value

    @property
    def prefix(self):
        """Prefix of the names of report and receipt, needed in a recording's folder, which is not the job's own."""
        return f"{self.name}_" if self.folder == "RECORDING" else ""

    @property
    def first_output(self):
        """File name of the output that stands for all, or that lists the units."""
        return next(iter(self.outputs.values()))

    def file_of(self, output):
        """File name of an output, with {unit} in it; None when the job has no such output."""
        made = self.outputs | self.beside | self.optional | self.run_files()
        return made.get(output)

    def run_files(self):
        """Names of report and receipt, which every program writes."""
        if self.script:
            return {}
        unit = "" if self.unit == "site" else "_{unit}"
        return {kind: f"{self.prefix}{kind}{unit}.json" for kind in ("report", "receipt")}

    def units_of(self, output):
        """The kind of unit that {unit} in this output's name stands for; "site" when there is one file."""
        if "{unit}" not in (self.file_of(output) or ""):
            return "site"
        return self.lists or self.unit


class Pipeline:
    """jobs: name -> Job; a job that makes an input comes before the jobs that read it."""

    def __init__(self, jobs, clashes):
        self.jobs, self.clashes = jobs, clashes
        for job in jobs.values():
            self._check_inputs(job)

    def _check_inputs(self, job):
        before = list(self.jobs)[:list(self.jobs).index(job.name)]
        for reference in job.inputs:
            if reference.source or reference.job == "import":
                continue
            if reference.job not in self.jobs and reference.if_made:
                continue
            if reference.job not in before:
                raise PipelineError(f"{job.where}: [{job.name}]: in.{reference.port}: no job '{reference.job}' before it")
            if self.jobs[reference.job].file_of(reference.output) is None:
                raise PipelineError(f"{job.where}: [{job.name}]: in.{reference.port}: job '{reference.job}' has no "
                                    f"output '{reference.output}'")  # fmt: skip

    def programs(self):
        """Names of the programs, without repetition."""
        return list(dict.fromkeys(job.program for job in self.jobs.values() if job.program))

    def goals(self):
        return list(dict.fromkeys(job.goal for job in self.jobs.values()))


def read_toml(path):
    try:
        with open(path, "rb") as file:
            return tomllib.load(file)
    except FileNotFoundError:
        raise PipelineError(f"{path}: there is no such file") from None
    except (ValueError, RecursionError) as error:
        raise PipelineError(f"{path}: not valid TOML: {error}") from None


def read_pipeline(configs, profile="default", imports=()):
    """The pipeline of a profile, for a site whose [import] has the keys `imports`. Raises PipelineError."""
    path = os.path.join(configs, "pipeline.toml")
    tables = read_toml(path)
    clashes = tables.pop("clash", [])
    where = dict.fromkeys(tables, path)
    overlay = os.path.join(configs, profile, "pipeline.toml")
    if profile != "default" and os.path.exists(overlay):
        _replace(tables, read_toml(overlay), overlay, imports, where)
    return Pipeline({name: Job(name, table, where[name]) for name, table in tables.items()}, clashes)


def _replace(tables, changes, path, imports, where):
    for name, table in changes.items():
        if table.pop("given", None) not in (None, *imports):
            continue
        if table.pop("leave_out", False):
            tables.pop(name, None)
            continue
        tables[name] = tables.get(name, {}) | table
        where[name] = path
