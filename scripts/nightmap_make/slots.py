# SPDX-License-Identifier: Apache-2.0
"""Contents of each job's slot: its program, the name of its options, the sources of its inputs and the files of [import].

A profile and [import] change these, and none of the files that they name is newer for it. So config/slots/<job> holds them, and
each rule of the job depends on it. It is written only when it changed. When the receipts say that the results were made by the
same program with the same options from the same imported files, its time is before that run: going back to an earlier value costs
nothing, and neither does a touch of an imported file.
"""

import os
import re
import tomllib
from functools import partial

from nightmap_make import changed_files
from nightmap_make.imports import files_of
from nightmap_make.input_files import file_state
from nightmap_make.run_receipts import DAMAGED, earliest_run_ns, read_receipt
from nightmap_site.pipeline import closure
from nightmap_site.script_errors import DataError


def slot_path(site, job):
    return f"{site.config}/slots/{job.name}"


def settle(graph):
    site, hashes = graph.site, LazyHashes()
    for job in graph.jobs.values():
        text, current, target = _text(graph, job), f"{site.folder}/config/slots/{job.name}", slot_path(site, job)
        changed_files.settle(current, target, text, changed_ns=partial(_start_of_runs_ns, graph, job, hashes))


def change(graph, rule):
    """In words: how the slot differs from what the rule's last run was; None when it does not, or nothing is known."""
    if rule.job.script:
        return "the site has other jobs than before"
    try:
        receipt, _, _ = read_receipt(dict(rule.outputs)["receipt"])
        return _difference(graph, rule.job, receipt, LazyHashes())
    except DAMAGED:
        return None


class LazyHashes:
    """Hashes of files; the library of hashes is loaded for the first one."""

    def __init__(self):
        self._hashes = None

    def is_same(self, entry):
        """Whether the file of a receipt's entry has the bytes it had."""
        from nightmap_site.receipts import Hashes
        try:
            self._hashes = self._hashes or Hashes()
        except DataError:
            return False
        return self._hashes.of(entry["path"]) == entry["xxh3"]


def _text(graph, job):
    if job.script:
        read = closure(graph.pipeline, goals=(), folders=(job.folder,)) if job.results_of else graph.jobs
        return "".join(f"job {name}\n" for name, other in graph.jobs.items() if name in read and other.when != "asked" and not other.script)
    lines = [f"program {job.program}", f"options {job.options}"]
    for reference in _references(graph, job):
        lines.append(f"in.{reference.port} {reference.text}")
        if reference.job == "import":
            path = graph.imported(job, reference.output)
            lines += [f"  {state}" for state in map(file_state, files_of(path))]
    return "\n".join(lines) + "\n"


def _references(graph, job):
    """The inputs that the site has."""
    return [reference for reference in job.inputs if not reference.if_made or reference.job in graph.jobs]


def _start_of_runs_ns(graph, job, hashes):
    """Start of the earliest run when the receipts of all runs fit the slot; None when one does not, or there is none."""
    paths = [graph.path_of(job, "receipt", unit) for unit in ([] if job.script else graph.units(job))]
    return earliest_run_ns(filter(os.path.exists, paths), lambda receipt: not _difference(graph, job, receipt, hashes))


def _difference(graph, job, receipt, hashes):
    if receipt["stage"] != job.program:
        return f"program {receipt['stage']} -> {job.program}"
    with open(graph.site.config_of(job), "rb") as file:
        if tomllib.loads(receipt["config"]) != tomllib.load(file):  # whose time tells nothing when it is another file than before
            return f"options are not those of {job.options}"
    references = _references(graph, job)
    to_come = {}  # of each port, in the order of its list
    for reference in references:
        to_come.setdefault(reference.port, []).append(reference)
    # A file that an input names, as the image of a ROS map, stands in the receipt by its own name.
    named = [entry for entry in receipt["inputs"] if entry["name"] not in to_come and entry["name"] == os.path.basename(entry["path"])]
    come = {}  # of each port the reference whose files have come last
    for entry in receipt["inputs"]:
        port = entry["name"]
        if entry in named:
            continue
        if port not in to_come:
            return f"in.{port} is no longer given"
        because = _other_source(graph, job, come[port], entry, hashes) if port in come else "the first file"
        if because and to_come[port]:
            come[port] = to_come[port].pop(0)
            because = _other_source(graph, job, come[port], entry, hashes)
        if because:
            return because
    imports = any(reference.job == "import" for reference in references)
    other = next((entry["path"] for entry in named if imports and not hashes.is_same(entry)), None)
    missing = next((port for port, left in to_come.items() if not all(reference.source for reference in left)), None)
    return f"{other} changed" if other else missing and f"in.{missing} was not given"


def _other_source(graph, job, reference, entry, hashes):
    """How the file of a receipt's entry differs from what the reference stands for."""
    if reference.source:
        return None
    if reference.job == "import":
        path = graph.imported(job, reference.output)
        if entry["path"] != path:
            return f"[import] {reference.output}: {entry['path']} -> {path}"
        return None if hashes.is_same(entry) else f"[import] {reference.output}: {path} changed"
    source = graph.jobs[reference.job]
    name = re.escape(source.file_of(reference.output)).replace(re.escape("{unit}"), "[^/]+")
    fits = re.search(rf"(?:^|/){re.escape(source.folder)}/{name}$", entry["path"])
    return None if fits else f"in.{reference.port}: {entry['path']} -> {reference.text}"
