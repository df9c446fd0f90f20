# SPDX-License-Identifier: Apache-2.0
"""The declared pipeline of a profile. configs/pipeline.toml explains each key."""

import json
import os
import re

from nightmap_site.declaration import Declaration
from nightmap_site.needs import NEEDS
from nightmap_site.toml_file import PipelineError, read_toml

KEYS = {"purpose", "program", "options", "script", "unit", "goal", "when", "lists", "folder", "in", "out", "beside", "finds", "reads",
        "stamp", "kB_per_frame", "surveys_per_frame", "section", "needs", "asks", "results_of", "cores", "memory_MB"}  # fmt: skip
REFERENCE = re.compile(r"(?P<job>\w+)\.(?P<output>[\w.]+)(?: of (?P<units>near|previous and this|all))?(?P<by_hash> by hash)?"
                       r"(?P<if_made> if made)?(?P<if_any> if any)?")
OPTIONS = re.compile(r"[a-z]\w*", re.ASCII)
CONDITION = re.compile(r"\w+(\.\w+)*")
SOURCES = ("site", "queries", "asked", "data")
SECTIONS = ("report", "evaluation", "verdict")
STAMPS = ("recordings", "pictures")
ASKS = ("pictures", "scans")


class Input:
    """A port and its source: site, queries, asked or data, or an output of a job. units: whose files a run reads (None: its own
    unit's, "near", "previous and this", "all"). by_hash: whether lists that the job reads have hashes of what it takes of the
    files. declared: the whole text; text: what the jobs of the pipeline leave of it, perhaps nothing. place: see Job.where."""

    def __init__(self, port, declared, place, has):
        self.port, self.declared, self._place = port, declared, place
        self.text = text = self._chosen(has)
        self.source = text if text in SOURCES else None
        self.job = self.output = self.units = None
        self.if_made = self.by_hash = False
        if self.source or text is None:
            return
        found = self._reference(text)
        self.job, self.output, self.units = found["job"], found["output"], found["units"]
        self.if_made, self.by_hash = bool(found["if_made"]), bool(found["by_hash"])

    @property
    def where(self):
        """The file and line that declare it, for an error: looking for them takes longer than reading the pipeline."""
        return self._place(f"in.{self.port}")

    def _reference(self, text):
        found = REFERENCE.fullmatch(text) if isinstance(text, str) else None
        if not found:
            also = "" if text == self.declared else f": {text!r}"
            raise PipelineError(f"{self.where}: in.{self.port} = {self.declared!r}{also} is no reference like "
                                "\"features.features of previous and this\"")  # fmt: skip
        return found

    def _chosen(self, has):
        """The first of "A.x else B.y" that the pipeline has. "A.x if any" is nothing where it has no such job."""
        sources = self.declared.split(" else ") if isinstance(self.declared, str) else [self.declared]
        if len(sources) == 1 and not str(sources[0]).endswith(" if any"):
            return self.declared
        for source in sources:
            found = source in SOURCES or self._reference(source)
            had = found is True or has(found["job"], found["output"])
            if had is None:
                raise PipelineError(f"{self.where}: in.{self.port}: no job '{found['job']}'")
            if had:
                return source.removesuffix(" if any")
        return None if sources[-1].endswith(" if any") else sources[-1]


class Job:
    """where(key): the file and line that declare the job, or a key of it. has: see Declaration."""

    def __init__(self, name, table, where, has):
        unknown = set(table) - KEYS
        if unknown:
            raise PipelineError(f"{where(min(unknown))}: unknown key '{min(unknown)}'; known keys: {', '.join(sorted(KEYS))}")
        self.name, self.where = name, where
        self.purpose = table.get("purpose", "")
        self.script = table.get("script")
        self.program = None if self.script else table.get("program", name)
        self.options = None if self.script else table.get("options", self.program)
        self.unit, self.lists = table.get("unit", "site"), table.get("lists")
        self.when = table.get("when")
        self.goal = table.get("goal", "map")
        self.folder = table.get("folder", name)
        inputs = [Input(port, text, where, has) for port, texts in table.get("in", {}).items()
                  for text in (texts if isinstance(texts, list) else [texts])]  # fmt: skip
        self.inputs = [given for given in inputs if given.text is not None]
        self.outputs, self.beside = dict(table.get("out", {})), dict(table.get("beside", {}))
        self.finds = [tuple(text.split(".", 1)) for text in table.get("finds", [])]
        self.kB_per_frame, self.surveys_per_frame = table.get("kB_per_frame", 0), table.get("surveys_per_frame", 0)
        self.cores, self.memory_MB = table.get("cores", 0), table.get("memory_MB", 4000 if self.unit == "site" else 2000)
        self.needs = table.get("needs", [])
        self.stamp, self.asks = table.get("stamp"), table.get("asks")
        self.reads = list(table.get("reads", []))
        self.results_of = list(table.get("results_of", []))
        self.sections = dict(table.get("section", {}))
        if not set(self.sections) <= set(SECTIONS):
            raise PipelineError(f"{where('section')}: section has only {', '.join(SECTIONS)}")
        if not self.purpose or not self.outputs:
            raise PipelineError(f"{where()} needs a purpose and an output")
        if not isinstance(self.needs, list) or not all(need in list(NEEDS) for need in self.needs):
            raise PipelineError(f"{where('needs')}: needs = {self.needs!r} is no list of {', '.join(NEEDS)}")
        if not self.script and not OPTIONS.fullmatch(str(self.options)):
            raise PipelineError(f"{where('options')}: options = {self.options!r} is no name of a file like \"features\"")
        for key, value, known in (("stamp", self.stamp, STAMPS), ("asks", self.asks, ASKS)):
            if value not in (None, *known):
                raise PipelineError(f"{where(key)}: {key} = \"{value}\" is none of {', '.join(known)}")
        if self.when is not None and not CONDITION.fullmatch(self.when):
            raise PipelineError(f"{where('when')}: when = \"{self.when}\" is no key of a site's config, like \"import.map\"")

    @property
    def prefix(self):
        """Prefix of the names of report and receipt, needed in a recording's folder, which is not the job's own."""
        return f"{self.name}_" if self.folder == "RECORDING" else ""

    def file_of(self, output):
        """File name of an output, with {unit} in it; None when the job has no such output."""
        made = self.outputs | self.beside | self.run_files()
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

    def jobs_before(self):
        return [reference.job for reference in self.inputs if reference.job] + [name for name, _ in self.finds]


class Goal:
    """A command of make that runs jobs. made: what the end of a run says of it; needs: the goal whose jobs it needs beside
    its own; rules: a file of rules that belong to it; why_without: why the profile leaves it out, if it says so."""

    def __init__(self, name, table, where, why_without=None):
        unknown = set(table) - {"purpose", "made", "needs", "rules"}
        if unknown or not table.get("purpose"):
            raise PipelineError(f"{where}: [goals]: {name} needs a purpose, and may have made, needs and rules")
        self.name, self.purpose, self.made, self.why_without = name, table["purpose"], table.get("made"), why_without
        self.needs, self.rules = table.get("needs", name), table.get("rules")


class Pipeline:
    """jobs: name -> Job; a job that makes an input comes before the jobs that read it. goals: name -> Goal.
    options: name of each config -> the program that takes it."""

    def __init__(self, jobs, goals, clashes):
        self.clashes, self.goals = clashes, goals
        self.jobs = {name: jobs[name] for name in _in_order(jobs)}
        self.listed_by = {}
        for job in jobs.values():
            if job.lists and job.lists in self.listed_by:
                raise PipelineError(f"{job.where('lists')}: job '{self.listed_by[job.lists].name}' lists each {job.lists} already")
            self.listed_by |= {job.lists: job} if job.lists else {}
        for job in jobs.values():
            self._check(job)
        self.options = self._named_options()

    @property
    def asks(self):
        """The kind that QUERY and [[query]] of the site name: pictures or scans."""
        return next((job.asks for job in self.jobs.values() if job.asks), ASKS[0])

    def _check(self, job):
        units = ("site", *self.listed_by)
        if job.unit not in units:
            raise PipelineError(f"{job.where('unit')}: unit = \"{job.unit}\" is none of {', '.join(units)}")
        if job.goal not in self.goals:
            raise PipelineError(f"{job.where('goal')}: goal = \"{job.goal}\" is none of {', '.join(self.goals)}; declare it in [goals]")
        for reference in job.inputs:
            if reference.job in self.jobs:
                self._check_input(job, reference)

    def _check_input(self, job, reference):
        source = self.jobs[reference.job]
        if source.file_of(reference.output) is None:
            raise PipelineError(f"{reference.where}: in.{reference.port}: job '{reference.job}' has no output '{reference.output}'")
        kind = source.units_of(reference.output)
        if kind == "site" or job.unit == "site" or reference.units == "all":
            return
        if kind != job.unit:
            raise PipelineError(f"{reference.where}: in.{reference.port}: {reference.job}.{reference.output} has a file per {kind}, and "
                                f"{job.name} runs per {job.unit}: \"{reference.job}.{reference.output} of all\" reads all of them")  # fmt: skip
        if reference.units == "near" and kind != "tile":
            raise PipelineError(f"{reference.where}: in.{reference.port}: only tiles are near each other, and {kind}s are not")

    def programs(self):
        return list(dict.fromkeys(job.program for job in self.jobs.values() if job.program))

    def _named_options(self):
        """Name of each config -> the one program that takes it."""
        found = {}
        for job in self.jobs.values():
            program = found.setdefault(job.options, job.program)
            if program != job.program:
                raise PipelineError(f"{job.where('options')}: options \"{job.options}\" are those of {program}, and {job.name} runs "
                                    f"{job.program}: give it options of another name")  # fmt: skip
        found.pop(None, None)  # of scripts
        return found

    def lists_units(self, job):
        """Whether files of this job or whole jobs exist per unit that it lists."""
        names = [*job.outputs.values(), *job.beside.values()]
        return bool(job.lists) and (any("{unit}" in name for name in names) or self._runs_per(job.lists))

    def goes_first(self, job):
        """Whether the rules of the site depend on what this job lists, or others read files that it writes beside its first output:
        Make looks up their times before the job ran when it meets them before that output."""
        decides_rules = self._runs_per(job.lists) or job.lists == "query" and any(other.when == "queries" for other in self.jobs.values())
        return bool(job.lists) and decides_rules or any(self.is_read(job, output) for output in job.beside)

    def is_read(self, job, output):
        return any((reference.job, reference.output) == (job.name, output) for other in self.jobs.values() for reference in other.inputs)

    def _runs_per(self, unit):
        return any(job.unit == unit for job in self.jobs.values())


def _in_order(jobs):
    """Names of the jobs, each after those whose outputs it reads, else as declared; scripts read all results and come last."""
    order = []

    def place(name, readers):
        if name in readers:
            circle = [*readers[readers.index(name):], name]
            raise PipelineError(f"{jobs[name].where()}: each of these jobs reads the one before it: {' -> '.join(reversed(circle))}")
        if name in order:
            return
        for before in dict.fromkeys(jobs[name].jobs_before()):
            if before in jobs:
                place(before, [*readers, name])
        order.append(name)

    for reference in (reference for job in jobs.values() for reference in job.inputs):
        if reference.job not in (None, "import", *jobs) and not reference.if_made:
            raise PipelineError(f"{reference.where}: in.{reference.port}: no job '{reference.job}'")
    for name in sorted(jobs, key=lambda name: bool(jobs[name].script)):
        place(name, [])
    return order


def read_pipeline(configs, profile="default", imports=()):
    """The pipeline of a profile, for a site whose [import] has the keys `imports`. Raises PipelineError."""
    declaration = Declaration(configs, profile, imports)
    jobs = {name: Job(name, table, declaration.places(name), declaration.has) for name, table in declaration.jobs.items()}
    goals = {name: Goal(name, table, declaration.path, declaration.why_without.get(name)) for name, table in declaration.goals.items()}
    return Pipeline(jobs, goals, declaration.clashes)


def closure(pipeline, goals, folders=()):
    """Names of the jobs that goals, and files in some folders, need: the jobs that make them or their inputs."""
    names = {job.name for job in pipeline.jobs.values() if job.goal in goals or job.folder in folders}
    for job in reversed(pipeline.jobs.values()):
        if job.name in names:
            names |= {reference.job for reference in job.inputs if reference.job}
        if job.name in names and job.script:  # it reads results: of the goals that it declares those of programs, else all that none asks for
            names |= {other.name for other in pipeline.jobs.values() if other.when != "asked"
                      and (not job.results_of or other.goal in job.results_of and not other.script)}  # fmt: skip
    return names


# The sources of a site's pipeline, for scripts that get the folder of the site.
PROFILE_FILE = "config/profile.toml"


def profile_text(profile, imports):
    return f"profile = {json.dumps(profile)}\nimports = {json.dumps(sorted(imports))}\n"


def pipeline_of_site(configs, site_dir):
    """The pipeline that the last make of a site used; the default one where nothing is known."""
    try:
        made = read_toml(os.path.join(site_dir, PROFILE_FILE))
        return read_pipeline(configs, made["profile"], made["imports"])
    except (PipelineError, OSError, KeyError, TypeError, AttributeError):
        return read_pipeline(configs)
