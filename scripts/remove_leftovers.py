# SPDX-License-Identifier: Apache-2.0
"""Removes the results of shards that the list of shards no longer names, after a recording became shorter or was cut
into other shards. (For tiles, the programs that join them do the same.)

Touches only files whose names a job declares.
"""

import os
import re

ANY_SHARD = r"(\d{4,9})"


def _patterns(job):
    """A pattern of the names of a job's files for any shard."""
    files = [*job.outputs.values(), *job.run_files().values()]
    return re.compile("|".join(re.escape(name).replace(re.escape("{unit}"), ANY_SHARD) for name in files), re.ASCII)


def leftovers(folder, pattern, shards):
    """Paths of the files in a folder whose shard is not in the set."""
    for name in sorted(os.listdir(folder)) if os.path.isdir(folder) else []:
        found = pattern.fullmatch(name)
        if found and found[found.lastindex] not in shards:
            yield os.path.join(folder, name)


def remove(site_dir, graph):
    """Paths of results and logs that belong to shards outside the rules."""
    shards = set(graph.site.lists["shard"])
    jobs = [job for job in graph.pipeline.jobs.values() if job.unit == "shard"]
    logs = re.compile(rf"(?:{'|'.join(job.name for job in jobs)})_{ANY_SHARD}\.log", re.ASCII)
    for folder, pattern in [(graph.folder_of(job), _patterns(job)) for job in jobs] + [(f"{site_dir}/logs", logs)]:
        for path in list(leftovers(folder, pattern, shards)):
            os.remove(path)
