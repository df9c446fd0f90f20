# SPDX-License-Identifier: Apache-2.0
"""Writes the rules of a site for GNU Make: explicit, one block per rule, to be read and grepped by people.

`graph.mk` depends on the declaration and the site's lists alone. What depends on the state of the files, the jobs that
must run again whatever the times say, is in `again.mk` beside it. Inputs that a rule has one of per shard or tile go to
the program in a file below `lists/`, since a command line has an end.
"""

import os

from nightmap_make.graph import PathList
from nightmap_make.site_state import READERS

HEAD = """\
# The rules of site {site}. Written by scripts/make_site.py from configs/pipeline.toml and the site's lists of
# shards, tiles and floors; edit those. `make V=1 ...` prints whole commands, `make why` the reasons.
MAKEFLAGS += --no-builtin-rules --no-builtin-variables
SHELL := bash
.SHELLFLAGS := -euo pipefail -c
.SUFFIXES:
.PHONY: FORCE {goals}
# Goals say nothing of their own. (Under -q a recipe would be something to do.)
DONE := $(if $(findstring q,$(firstword -$(MAKEFLAGS))),,@:)
QUIET := $(if $(filter 1,$(V)),,@)
RUN := $(QUIET)scripts/run_job.sh {folder}
OPTIONS := --threads $(THREADS) --log-level $(LOG_LEVEL)
"""


def list_goal(job):
    """The goal of make that renews the list of units of a job."""
    return f"{job.lists}s"


class Times:
    """Modification times (ns) by path; None of what is not there. Each file is looked at once."""

    def __init__(self):
        self._known = {}

    def of(self, path):
        if path not in self._known:
            try:
                self._known[path] = os.stat(path).st_mtime_ns
            except OSError:
                self._known[path] = None
        return self._known[path]


class RulesFile:
    def __init__(self, graph, times):
        self.graph, self.site, self.times = graph, graph.site, times

    def text(self):
        head = HEAD.format(site=self.site.name, folder=self.site.folder, goals=" ".join(self.graph.pipeline.goals()))
        rules = [self._rule(rule) for rule in self.graph.rules]  # names the lists that they use
        goals = [self._goal(goal) for goal in self.graph.pipeline.goals()]
        goals += [f".PHONY: {list_goal(job)}\n{list_goal(job)}: {self.graph.path_of(job, next(iter(job.outputs)))}\n\t$(DONE)\n"
                  for job in self.graph.jobs.values() if job.lists]  # fmt: skip
        rules += self._listed_files()
        lists = [self._list(paths) for paths in self.graph.lists.values()]
        return "\n".join([head, *lists, *rules, *goals])

    def again(self):
        """Rules that must run again whatever the times say."""
        return "".join(f"{' '.join(rule.output_paths())}: FORCE\n" for rule in self.graph.rules if self.must_run(rule))

    def unmade(self):
        """Rules without a recipe for files that are not there and that no rule makes: programs that are not built
        yet and files of lists. Modes that only look need them."""
        made = {path for rule in self.graph.rules for path in rule.output_paths() + self._only_listed(rule)}
        read = {path for rule in self.graph.rules for path in self._prerequisites(rule) if not path.startswith("$(")}
        read |= {path for paths in self.graph.lists.values() for path in paths.paths}
        return "".join(f"{path}: ; @:\n" for path in sorted(read - made) if self.times.of(path) is None)

    def must_run(self, rule):
        """Not all of its files are there, its last run was killed while it committed, or its list is damaged."""
        times_ns = [self.times.of(path) for path in rule.output_paths()]
        if None in times_ns or rule.job.name in self.site.damaged:
            return True
        if any(self.times.of(path) is None for path in self.graph.listed_files(rule.job)):
            return True
        return not rule.job.script and self._is_interrupted(rule, max(times_ns))

    def _is_interrupted(self, rule, newest_ns):
        """The receipt is renamed last: an output newer than it is of a later run that was killed."""
        receipt = dict(rule.outputs)["receipt"]
        return newest_ns > self.times.of(receipt) or not _ends_well(receipt)

    def list_files(self):
        """(path, text) of the files that hold many paths."""
        for paths in self.graph.lists.values():
            yield self._list_path(paths), "".join(f"{path}\n" for path in paths.paths)

    def _list_path(self, paths):
        return f"{self.site.folder}/lists/{paths.name}.txt"

    def _list(self, paths):
        return f"{paths.name} := \\\n" + " \\\n".join(f"  {path}" for path in paths.paths) + "\n"

    def _goal(self, goal):
        rules = [rule for rule in self.graph.rules if rule.job.goal == goal and rule.job.unit == "site"]
        lists = [f"$({name})" for name in self._shared(goal)]
        return f"{goal}: {' '.join([*(rule.output_paths()[0] for rule in rules), *lists])}\n\t$(DONE)\n"

    def _shared(self, goal):
        """Lists of what the jobs per shard or tile of a goal make."""
        jobs = [job for job in self.graph.jobs.values() if job.goal == goal and job.unit != "site"]
        return [self.graph.all_of(job, next(iter(job.outputs))).name for job in jobs]

    def _rule(self, rule):
        targets = " ".join(rule.output_paths())
        # Programs commit all or nothing: one that fails leaves the last good outputs, and make must not delete them.
        lines = [f"# {rule.name}: {rule.job.purpose}", f".PRECIOUS: {targets}", f"{targets} &: \\"]
        lines.append(" \\\n".join(f"  {word}" for word in self._prerequisites(rule)))
        lines.append("\t" + " \\\n\t  ".join(self._command(rule)))
        return "\n".join(lines) + "\n"

    def _listed_files(self):
        """Files that are written with a list come after it. They keep their time when their bytes stay; what is gone of
        them then, the program that reads them says, not Make."""
        for rule in self.graph.rules:
            files = self._only_listed(rule)
            if files:
                yield " \\\n".join(files) + f": | {rule.output_paths()[0]} ;\n"

    def _only_listed(self, rule):
        outputs = rule.output_paths()
        return [path for path in self.graph.listed_files(rule.job) if path not in outputs]

    def tool(self, rule):
        """The program and its config, or the script."""
        job = rule.job
        if job.script:
            return [f"scripts/{job.script}"]
        return [f"{self.site.build}/run/{job.program}", f"{self.site.config}/{job.program}.toml"]

    def _prerequisites(self, rule):
        words = self.tool(rule)
        for port, value in rule.inputs:
            if isinstance(value, PathList):
                words.append(f"$({value.name})")
                words.append(self.names_path(rule.job, port))
            elif value != self.site.data:
                words.append(value)
        words += [f"$({need.name})" if isinstance(need, PathList) else need for need in rule.needs]
        return list(dict.fromkeys(words))

    def names_path(self, job, port):
        """The list of names whose change makes a job stale that reads all of them."""
        reference = next(reference for reference in job.inputs if reference.port == port)
        units = self.graph.jobs[reference.job].units_of(reference.output)
        return f"{self.site.folder}/lists/{units}s.txt"

    def name_files(self):
        """(path, text) of the names of the units, but for a list that is damaged: it comes back as it was."""
        for job in self.graph.jobs.values():
            if job.lists not in READERS or job.name in self.site.damaged:
                continue
            yield f"{self.site.folder}/lists/{list_goal(job)}.txt", "".join(f"{name}\n" for name in self.site.lists[job.lists])

    def _command(self, rule):
        job = rule.job
        if job.script:
            return [f"$(RUN) {rule.name} $(PYTHON) scripts/{job.script} --site-dir {self.site.folder}",
                    f"--data {self.site.data} --out {rule.output_paths()[0]}"]  # fmt: skip
        words = [f"$(RUN) {rule.name} $(LAUNCH) {self.site.build}/run/{job.program}",
                 f"--config {self.site.config}/{job.program}.toml"]  # fmt: skip
        for port, value in rule.inputs:
            many = isinstance(value, PathList)
            words.append(f"--in-list {port}={self._list_path(value)}" if many else f"--in {port}={value}")
        return [*words, *(f"--out {port}={path}" for port, path in rule.outputs), "$(OPTIONS)"]


def _ends_well(receipt):
    """Whether a receipt is whole as far as its last bytes tell; there may be ten thousands of them."""
    try:
        file = os.open(receipt, os.O_RDONLY | os.O_NONBLOCK)  # a pipe must not make us wait
    except OSError:
        return False
    try:
        os.lseek(file, -2, os.SEEK_END)
        return os.read(file, 2) == b"}\n"
    except OSError:
        return False
    finally:
        os.close(file)
