# SPDX-License-Identifier: Apache-2.0
"""Writes the rules of a site for GNU Make: explicit, one block per rule, easy to read and grep.

`graph.mk` depends only on the declaration and the site's lists. `again.mk` beside it depends on the state of the files:
it names the jobs that must run again whatever the modification times say. Inputs with one file per shard or tile
reach the program in a file below `lists/`, since the length of a command line is limited.
"""

import json
import os

from nightmap_make.graph import PathList

HEAD = """\
# The rules of site {site}. Written by scripts/make_site.py from configs/pipeline.toml and the site's lists of
# shards, tiles and floors: edit those instead. `make V=1 ...` prints whole commands, `make why` the reasons.
MAKEFLAGS += --no-builtin-rules --no-builtin-variables
SHELL := bash
.SHELLFLAGS := -euo pipefail -c
.SUFFIXES:
.PHONY: FORCE {goals}
# Goals print nothing. (Under -q a recipe would count as work to do.)
DONE := $(if $(findstring q,$(firstword -$(MAKEFLAGS))),,@:)
QUIET := $(if $(filter 1,$(V)),,@)
RUN := $(QUIET)scripts/run_job.sh {folder}
OPTIONS := --threads $(THREADS) --log-level $(LOG_LEVEL)
"""


class Times:
    """Modification times (ns) by path; None for a missing file. Each file is examined once."""

    def __init__(self):
        self._known = {}

    def of(self, path):
        if path not in self._known:
            try:
                self._known[path] = os.stat(path).st_mtime_ns
            except OSError:
                self._known[path] = None
        return self._known[path]

    def known(self):
        """Path -> time of the examined files that exist."""
        return {path: time_ns for path, time_ns in self._known.items() if time_ns is not None}

    def pretend(self, times_ns):
        """From now on these files have other times."""
        self._known |= times_ns


class RulesFile:
    def __init__(self, graph, times):
        self.graph, self.site, self.times = graph, graph.site, times

    def text(self):
        head = HEAD.format(site=self.site.name, folder=self.site.folder, goals=" ".join(self._goals()))
        rules = [self._rule(rule) for rule in self.graph.rules]  # adds the names of the lists that the rules use
        goals = [self._goal(goal) for goal in self._goals()]
        rules += self._files_beside()
        lists = [f"{paths.name} := \\\n" + " \\\n".join(f"  {path}" for path in paths.paths) + "\n" for paths in self.graph.lists.values()]
        return "\n".join([head, *lists, *rules, *goals])

    def again(self):
        """Text of again.mk: rules that must run again whatever the modification times say."""
        return "".join(f"{' '.join(rule.output_paths())}: FORCE\n" for rule in self.graph.rules if self.must_run(rule))

    def unmade(self):
        """Rules without a recipe for missing files that no rule makes: programs not built yet and files of
        lists. The flags -n and -q and `why` need them."""
        made = {path for rule in self.graph.rules for path in rule.output_paths() + self.beside(rule)}
        read = {path for rule in self.graph.rules for path in self.prerequisites(rule) if not path.startswith("$(")}
        read |= {path for paths in self.graph.lists.values() for path in paths.paths}
        return "".join(f"{path}: ; @:\n" for path in sorted(read - made) if self.times.of(path) is None)

    def must_run(self, rule):
        """Whether a file of the rule or one beside it is missing, its last run was killed while it committed, or its list is damaged."""
        times_ns = [self.times.of(path) for path in rule.output_paths()]
        if None in times_ns or rule.job.name in self.site.damaged:
            return True
        if any(self.times.of(path) is None for path in [*self.graph.files_beside(rule.job), *self._written_of_queries(rule)]):
            return True
        return not rule.job.script and (bool(self.newer_than_receipt(rule)) or not _ends_well(dict(rule.outputs)["receipt"]))

    def _written_of_queries(self, rule):
        """Files of the last run of the list of queries: which ones follows from the queries (there may be no truth)."""
        if rule.job.lists != "query":
            return []
        receipt = dict(rule.outputs)["receipt"]
        try:
            with open(receipt, encoding="utf-8") as file:
                return [os.path.join(os.path.dirname(receipt), os.path.basename(entry["path"])) for entry in json.load(file)["outputs"]]
        except (OSError, ValueError, KeyError, TypeError):
            return []

    def newer_than_receipt(self, rule):
        """A file that was edited, or is of a run that was killed while it committed: the receipt is renamed last. Else None."""
        if rule.job.script or rule.job.name in self.site.damaged:
            return None
        newest = max(rule.output_paths(), key=lambda path: self.times.of(path) or 0)
        receipt_ns = self.times.of(dict(rule.outputs)["receipt"])
        return newest if receipt_ns is not None and self.times.of(newest) > receipt_ns else None

    def edited(self):
        """Says which files are made anew because they are newer than their receipts."""
        for rule in self.graph.rules:
            path = self.newer_than_receipt(rule)
            if path:
                yield f"nightmap: {path} was edited, or {rule.name} was killed while it wrote it: {rule.name} makes it anew"

    def list_files(self):
        """(path, text) of the files that list many paths for a program."""
        for paths in self.graph.lists.values():
            yield self._list_path(paths), "".join(f"{path}\n" for path in paths.paths)

    def _list_path(self, paths):
        return f"{self.site.folder}/lists/{paths.name}.txt"

    def _goals(self):
        return list(dict.fromkeys(job.goal for job in self.graph.pipeline.jobs.values()))

    def _goal(self, goal):
        rules = [rule for rule in self.graph.rules if rule.job.goal == goal and rule.job.unit == "site"]
        lists = [f"$({self.graph.all_of(job, next(iter(job.outputs))).name})" for job in self.graph.jobs.values()
                 if job.goal == goal and job.unit != "site"]  # fmt: skip
        return f"{goal}: {' '.join([*(rule.output_paths()[0] for rule in rules), *lists])}\n\t$(DONE)\n"

    def _rule(self, rule):
        targets = " ".join(rule.output_paths())
        # Programs commit all or nothing: a failed one leaves the last good outputs, and make must not delete them.
        lines = [f"# {rule.name}: {rule.job.purpose}", f".PRECIOUS: {targets}", f"{targets} &: \\"]
        # Inputs by hash must be there, and their times do not count.
        before = [f"$({value.name})" if isinstance(value, PathList) else value for port, value in rule.inputs if port in rule.by_hash]
        lines.append(" \\\n".join(f"  {word}" for word in [*self.prerequisites(rule), *(["|", *before] if before else [])]))
        lines.append("\t" + " \\\n\t  ".join(self._command(rule)))
        return "\n".join(lines) + "\n"

    def _files_beside(self):
        """Orders the files that a job writes beside its first output after that. They keep their modification time while their
        bytes stay the same. If one is missing, the program that reads it says so, not Make."""
        for rule in self.graph.rules:
            files = self.beside(rule)
            if files:
                yield " \\\n".join(files) + f": | {rule.output_paths()[0]} ;\n"

    def beside(self, rule):
        """The files that the rule's run writes and no target names."""
        outputs = rule.output_paths()
        return [path for path in self.graph.files_beside(rule.job) if path not in outputs]

    def tool(self, rule):
        """Paths of the program and its config, or of the script."""
        job = rule.job
        if job.script:
            return [f"scripts/{job.script}"]
        return [f"{self.site.build}/run/{job.program}", self.site.config_of(job)]

    def prerequisites(self, rule):
        words = self.tool(rule)
        for port, value in rule.watched():
            words += [f"$({value.name})", self.names_path(value)] if isinstance(value, PathList) else [value]
        words += [f"$({need.name})" if isinstance(need, PathList) else need for need in rule.needs]
        return list(dict.fromkeys(words))

    def names_path(self, paths):
        """The list of the units of a PathList; a job that reads all units is stale when it changes."""
        job, output = paths.name.split(".", 1)
        units = self.graph.jobs[job].units_of(output)
        return f"{self.site.folder}/lists/{units}s.txt"

    def name_files(self):
        """(path, text) of the lists of unit names, without damaged lists: their jobs write the same names again."""
        for job in self.graph.jobs.values():
            if not self.graph.pipeline.lists_units(job) or job.name in self.site.damaged:
                continue
            yield f"{self.site.folder}/lists/{job.lists}s.txt", "".join(f"{name}\n" for name in self.site.lists[job.lists])

    def _command(self, rule):
        job = rule.job
        if job.script:
            return [f"$(RUN) {rule.name} $(PYTHON) scripts/{job.script} --site-dir {self.site.folder}",
                    f"--data {self.site.data} --out {rule.output_paths()[0]}"]  # fmt: skip
        words = [f"$(RUN) {rule.name} $(LAUNCH) {self.site.build}/run/{job.program}",
                 f"--config {self.site.config_of(job)}"]  # fmt: skip
        for port, value in rule.inputs:
            many = isinstance(value, PathList)
            words.append(f"--in-list {port}={self._list_path(value)}" if many else f"--in {port}={value}")
        return [*words, *(f"--out {port}={path}" for port, path in rule.outputs), "$(OPTIONS)"]


def _ends_well(receipt):
    """Whether a receipt's last bytes are whole; reading more is too slow for tens of thousands of receipts."""
    try:
        file = os.open(receipt, os.O_RDONLY | os.O_NONBLOCK)  # opening a pipe must not block
    except OSError:
        return False
    try:
        os.lseek(file, -2, os.SEEK_END)
        return os.read(file, 2) == b"}\n"
    except OSError:
        return False
    finally:
        os.close(file)
