# SPDX-License-Identifier: Apache-2.0
"""Finds the rules that would run now, and the reasons: the same comparison of modification times as Make's, in words."""

import json
import tomllib

from nightmap_make.graph import PathList
from nightmap_make.programs import reason_to_build
from nightmap_make.slots import change as slot_change
from nightmap_make.slots import slot_path

SHOWN = 4  # shards or tiles of a job that are listed one by one


class Staleness:
    """reasons: rule -> reasons, for the rules that make would run if all were goals. Those of `uncertain` run only if a file changes
    that keeps its time while its bytes stay."""

    def __init__(self, rules_file):
        self._file, self._times = rules_file, rules_file.times
        self._remade, self._uncertain, self._lists = set(), set(), {}
        self.reasons, self.uncertain = {}, set()
        for rule in rules_file.graph.rules:
            certain = self._reasons_of(rule)
            possible = [] if certain else [f"{path} may change" for path in self._inputs(rule) if path in self._uncertain]
            if certain or possible:
                self.reasons[rule] = certain or possible
                (self._remade if certain else self._uncertain).update(rule.output_paths())
                self._uncertain.update(rules_file.beside(rule))
            if possible:
                self.uncertain.add(rule)

    def _reasons_of(self, rule):
        """Why the rule runs whatever the bytes of others' results will be."""
        lost = [path for path in rule.output_paths() if self._times.of(path) is None]
        if lost:
            return [f"{path} does not exist" for path in lost]
        if self._file.must_run(rule):
            edited = self._file.newer_than_receipt(rule)
            return [f"{edited} is newer than its receipt: it was edited, or its job was killed" if edited else
                    "its last run was not finished, or a file that it wrote is lost or damaged"]  # fmt: skip
        oldest = min(rule.output_paths(), key=self._times.of)
        return [reason for path in self._inputs(rule) if (reason := self._reason(rule, path, oldest))]

    def _reason(self, rule, path, oldest):
        if path in self._remade:
            return f"{path} will be remade"
        time_ns = self._times.of(path)
        if time_ns is None:
            return f"{path} does not exist"
        if time_ns <= self._times.of(oldest):
            return None
        if path == self._file.site.config_of(rule.job):
            return config_change(self._file.site, self._file.graph, rule) or f"{path} is newer than {oldest}"
        if path == slot_path(self._file.site, rule.job):
            return slot_change(self._file.graph, rule) or f"{path} is newer than {oldest}"
        return f"{path} is newer than {oldest}"

    def _inputs(self, rule):
        """Paths that may make the rule stale. A shared list gives only some of them: missing, remade, uncertain, newest."""
        values = [*self._file.tool(rule), *(value for port, value in rule.watched()), *rule.needs]
        values += [self._file.names_path(value) for _, value in rule.inputs if isinstance(value, PathList)]
        for value in values:
            yield from self._worst_of(value) if isinstance(value, PathList) else [value]

    def _worst_of(self, paths):
        if paths.name not in self._lists:
            missing_or_remade = [path for path in paths.paths if path in self._remade or self._times.of(path) is None]
            uncertain = [path for path in paths.paths if path in self._uncertain]
            newest = max(paths.paths, key=lambda path: self._times.of(path) or 0, default=None)
            self._lists[paths.name] = list(dict.fromkeys(missing_or_remade[:SHOWN] + uncertain[:SHOWN] + ([newest] if newest else [])))
        return self._lists[paths.name]


def config_change(site, graph, rule):
    """Differences between the present config and the one in the rule's report."""
    report = dict(rule.outputs).get("report")
    try:
        with open(report, encoding="utf-8") as file:
            old = tomllib.loads(json.load(file)["config"])
        with open(site.config_of(rule.job), "rb") as file:
            new = tomllib.load(file)
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return None
    changes = [f"{key} {old.get(key)} -> {new[key]}" for key in sorted(new) if old.get(key) != new[key]]
    return f"options of {rule.job.options} changed: {', '.join(changes)}" if changes else None


def lines(staleness, build, programs):
    """The answer of `make why`: a line per rule; only the first shards or tiles of a job with many. programs: what the
    site's jobs run."""
    programs = reason_to_build(build, programs)
    if programs:
        yield f"programs: {programs}"
    by_job = {}
    for rule, because in staleness.reasons.items():
        by_job.setdefault(rule.job.name, []).append((rule, because))
    for name, stale in by_job.items():
        for rule, because in stale[:SHOWN]:
            more = f" (and {len(because) - 1} more)" if len(because) > 1 else ""
            yield f"{rule.name}: {because[0]}{more}"
        if len(stale) > SHOWN:
            yield f"{name}: and {len(stale) - SHOWN} more {stale[0][0].job.unit}s"
    if not by_job:
        if not programs:
            yield "everything is up to date"
        return
    if programs:
        yield "(after the build, jobs whose program changed rerun too)"
    if staleness.uncertain:
        yield "(a job of which it says 'may change' runs only if such a file changes)"
