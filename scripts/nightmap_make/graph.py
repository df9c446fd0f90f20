# SPDX-License-Identifier: Apache-2.0
"""The rules of one site: one run of each declared job per shard or tile, with its files."""

import glob
import os

from nightmap_make.slots import slot_path
from nightmap_site.pipeline import closure
from nightmap_site.toml_file import PipelineError
from nightmap_site.unit_lists import near

SITES = "configs/sites"
# Files that evaluate and report import; a changed module makes their results stale.
MODULES = tuple(f"scripts/nightmap_eval/{files}" for files in ("*.py", "*/*.py", "*/*.js", "*/*.html")) + ("scripts/nightmap_site/*.py",)


class PathList:
    """The paths of one output for all units, in order. Rules that read all of them share one list."""

    def __init__(self, name, paths):
        self.name, self.paths = name, paths


class Rule:
    """One run of a job. inputs: (port, path or PathList) on the command line; needs: further files that make it stale,
    beside the program and its config; outputs: (port, path). Raw inputs (the recordings, the files of [import]) make nothing
    stale by their times: stamps and slots stand for them; for inputs by hash lists do."""

    def __init__(self, job, unit, inputs, needs, outputs):
        self.job, self.unit, self.inputs, self.needs, self.outputs = job, unit, inputs, needs, outputs
        self.by_hash = {reference.port for reference in job.inputs if reference.by_hash}
        self._raw = self.by_hash | {reference.port for reference in job.inputs if reference.source == "data" or reference.job == "import"}

    def watched(self):
        """(port, path or PathList) of the inputs whose times count."""
        return [(port, value) for port, value in self.inputs if port not in self._raw]

    @property
    def name(self):
        return self.job.name if self.unit is None else f"{self.job.name}_{self.unit}"

    def output_paths(self):
        return [path for _, path in self.outputs]


class Graph:
    """rules: every rule of the site, in the order of the pipeline; lists: the PathLists they share, by name.
    goals: the goals of make; jobs that run only on request have no rule unless a goal needs them."""

    def __init__(self, pipeline, site, goals=()):
        self.pipeline, self.site = pipeline, site
        self.lists = {}
        asked = closure(pipeline, goals)
        self.jobs = {name: job for name, job in pipeline.jobs.items()
                     if (name in asked if job.when == "asked" else site.has(job.when))}
        self._previous = {kind: dict(zip(names[1:], names)) for kind, names in site.lists.items()}
        self._tiles = set(site.lists["tile"])
        self.rules = [self._rule(job, unit) for job in self.jobs.values() for unit in self.units(job)]

    def units(self, job):
        return [None] if job.unit == "site" else self.site.lists[job.unit]

    def folder_of(self, job):
        return os.path.join(self.site.data, self.site.name) if job.folder == "RECORDING" else f"{self.site.folder}/{job.folder}"

    def path_of(self, job, output, unit=None):
        name = job.file_of(output)
        return f"{self.folder_of(job)}/{name if unit is None else name.replace('{unit}', unit)}"

    def all_of(self, job, output):
        """The PathList of an output with one file per unit."""
        name = f"{job.name}.{output}"
        if name not in self.lists:
            units = self.site.lists[job.units_of(output)]
            self.lists[name] = PathList(name, [self.path_of(job, output, unit) for unit in units])
        return self.lists[name]

    def files_beside(self, job):
        """The files that a job writes beside its first output, where that is a list of units or other jobs read them; before there
        is a list, those that no unit names."""
        is_listed = bool(job.beside) and os.path.exists(self.path_of(job, next(iter(job.outputs))))
        return [path for output in job.beside if job.lists or self.pipeline.is_read(job, output)
                if is_listed or job.units_of(output) == "site" for path in self._paths(job, output)]  # fmt: skip

    def _paths(self, job, output):
        return [self.path_of(job, output)] if job.units_of(output) == "site" else self.all_of(job, output).paths

    def _rule(self, job, unit):
        inputs, needs = [], [slot_path(self.site, job)]
        for reference in job.inputs:
            for value in self._values(job, reference, unit):
                inputs.append((reference.port, value))
        for name, output in job.finds:
            needs += self._paths(self.jobs[name], output) if name in self.jobs else []
        if job.script:
            needs += self._results_before(job)
        elif job.stamp in self.site.stamps:
            needs.append(self.site.stamps[job.stamp])
        needs += [path for path in (f"{self.site.folder}/{name}" for name in job.reads) if os.path.exists(path)]
        files = {**job.outputs, **job.run_files()}
        return Rule(job, unit, inputs, needs, [(port, self.path_of(job, port, unit)) for port in files])

    def _values(self, job, reference, unit):
        """Paths, or one PathList, that fill a port of a unit's run."""
        if reference.source:
            return [self.site.source(reference.source)]
        if reference.job == "import":
            return [self.imported(job, reference.output)]
        source = self.jobs.get(reference.job)
        if source is None:
            if reference.if_made:
                return []
            raise PipelineError(f"{reference.where}: job '{reference.job}' is left out for site {self.site.name}, "
                                f"and in.{reference.port} needs it")  # fmt: skip
        of = source.units_of(reference.output)
        if of == "site":
            return [self.path_of(source, reference.output)]
        if unit is None or reference.units == "all":
            return [self.all_of(source, reference.output)]
        before = self._previous[job.unit].get(unit) if reference.units else None
        units = near(unit, self._tiles) if reference.units == "near" else [unit] if before is None else [before, unit]
        return [self.path_of(source, reference.output, other) for other in units]

    def imported(self, job, key):
        """Path of a file that [import] names."""
        if key not in self.site.imports:
            raise PipelineError(f"{job.where()} needs a file of your own: name it in {SITES}/{self.site.name}.toml, as in\n"
                                f"[import]\n{key} = \"<path relative to DATA>\"")  # fmt: skip
        return os.path.join(self.site.data, self.site.imports[key])

    def _results_before(self, job):
        """Files that a script reads: of the whole folder of the site, or of some goals. It reads a path as is when no goal asks for it."""
        needs, read = [], closure(self.pipeline, goals=(), folders=(job.folder,))
        for other in self.pipeline.jobs.values():
            if other is job:
                break
            if job.results_of and other.name not in read:
                continue
            if other.name in self.jobs:
                needs += [self.path_of(other, port) if other.units_of(port) == "site" else self.all_of(other, port)
                          for port in (*other.outputs, *other.run_files())]  # fmt: skip
            elif other.when == "asked" and os.path.exists(self.path_of(other, "receipt")):
                needs.append(self.path_of(other, "receipt"))
        sections = [path for other in self.jobs.values() for path in other.sections.values()]
        modules = [path for pattern in MODULES for path in sorted(glob.glob(pattern))]
        return needs + modules + sections + [f"scripts/{job.script}"]
