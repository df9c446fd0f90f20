# SPDX-License-Identifier: Apache-2.0
"""Removes results that describe the map no more: of shards that the list of shards no longer names, after a recording became
shorter or was cut into other shards (for tiles, the programs that join them do the same), and of jobs that the site no longer
has, after it lost its queries or its profile changed.

Touches only files below the site's folder whose names a job declares.
"""

import contextlib
import functools
import os
import re

from nightmap_make.changed_files import has_text, write_if_changed
from nightmap_site.declaration import import_keys, profiles
from nightmap_site.pipeline import read_pipeline
from nightmap_site.toml_file import PipelineError

JOBS_FILE = "config/jobs.txt"  # the jobs of the site and their files, when it was last looked for others'
ANY_UNIT = {"shard": r"\d{4,9}", "tile": r"-?\d{1,9}_-?\d{1,9}", "floor": r"(?:map|floor_-?\d{1,9})"}


def _any(unit):
    return ANY_UNIT.get(unit, r"[A-Za-z0-9][\w-]{0,99}")


def remove(site_dir, graph, kind):
    """Removes results and logs of units outside the rules."""
    if kind == "tile":
        return
    units = set(graph.site.lists[kind])
    jobs = [job for job in graph.pipeline.jobs.values() if job.unit == kind]
    if not jobs:
        return
    logs = re.compile(rf"(?:{'|'.join(job.name for job in jobs)})_({_any(kind)})\.log", re.ASCII)
    patterns = [(f"{site_dir}/logs", logs)]
    for job in jobs:
        files = [name for name in [*job.outputs.values(), *job.beside.values(), *job.run_files().values()] if "{unit}" in name]
        of_any = (re.escape(name).replace(re.escape("{unit}"), f"({_any(kind)})") for name in files)
        patterns.append((graph.folder_of(job), re.compile("|".join(of_any), re.ASCII)))
    for folder, pattern in patterns:
        for name in sorted(os.listdir(folder)) if os.path.isdir(folder) else []:
            found = pattern.fullmatch(name)
            if found and found[found.lastindex] not in units:
                os.remove(os.path.join(folder, name))


def remove_gone(site_dir, graph, configs="configs"):
    """Removes the results and logs of jobs that the site no longer has; returns the names of their folders. Looks for them
    when the jobs are others than the last time."""
    # Jobs that run when asked for keep their results, and so do those of queries while the config asks for some.
    here = [job for job in graph.pipeline.jobs.values()
            if job.name in graph.jobs or job.when == "asked" or job.when == "queries" and graph.site.may_have_queries()]  # fmt: skip
    jobs = "".join(f"{job.folder}/{name} of {job.name}\n" for job in here for name in [*job.outputs.values(), *job.beside.values()])
    if has_text(f"{site_dir}/{JOBS_FILE}", jobs):
        return []
    known = _files_of([*graph.pipeline.jobs.values(), *_jobs_of_profiles(configs)])
    folders = []
    for folder, gone in ((folder, names - _files_of(here).get(folder, set())) for folder, names in known.items()):
        paths = _matching(f"{site_dir}/{folder}", gone) if gone else []
        for path in paths:
            os.remove(path)
            with contextlib.suppress(OSError):  # unless something else is in it
                os.removedirs(os.path.dirname(path))
        folders += [folder] if paths and folder != "logs" else []
    write_if_changed(f"{site_dir}/{JOBS_FILE}", jobs)
    return folders


def _files_of(jobs):
    """Folder -> patterns of the files that jobs declare, and of their logs. The folder of a recording is the user's."""
    files = {}
    for job in jobs:
        if job.folder != "RECORDING":
            ports = job.outputs | job.beside | job.run_files()
            files.setdefault(job.folder, set()).update(_pattern(name, job.units_of(port)) for port, name in ports.items())
            files.setdefault("logs", set()).add(_pattern(job.name + ("" if job.unit == "site" else "_{unit}") + ".log", job.unit))
    return files


@functools.cache  # most jobs of the profiles are the same
def _pattern(name, unit):
    return re.escape(name).replace(re.escape("{unit}"), _any(unit))


def _jobs_of_profiles(configs):
    """The jobs of each profile, with nothing that a site may give to it and with all of it."""
    for profile in profiles(configs):
        with contextlib.suppress(PipelineError):  # a mistake in a profile matters to its sites
            for imports in {(), tuple(sorted(import_keys(configs, profile)))}:
                yield from read_pipeline(configs, profile, imports).jobs.values()


def _matching(folder, patterns):
    """Files below a folder whose path in it fits one of the patterns."""
    pattern = re.compile("|".join(sorted(patterns)), re.ASCII)
    found = [os.path.join(place, name) for place, _, names in os.walk(folder) for name in names]
    return [path for path in sorted(found) if pattern.fullmatch(os.path.relpath(path, folder)) and not os.path.islink(path)]
