# SPDX-License-Identifier: Apache-2.0
"""Removes the results of shards that the list of shards does not name any more: of a recording that became
shorter, or was cut into other shards. (What is of tiles that are no more the programs that join them remove.)

Only files that a job gives just such a name are touched.
"""

import os
import re

ANY_SHARD = r"(\d{4,9})"


def _patterns(job):
    """Of the names of a job's files for any shard."""
    files = [*job.outputs.values(), *job.run_files().values()]
    return re.compile("|".join(re.escape(name).replace(re.escape("{unit}"), ANY_SHARD) for name in files), re.ASCII)


def leftovers(folder, pattern, shards):
    """Paths of a folder's files that belong to a shard that is not in the set."""
    for name in sorted(os.listdir(folder)) if os.path.isdir(folder) else []:
        found = pattern.fullmatch(name)
        if found and found[found.lastindex] not in shards:
            yield os.path.join(folder, name)


def remove(site_dir, graph):
    """What the jobs per shard of the rules left of other shards, and the logs."""
    shards = set(graph.site.lists["shard"])
    jobs = [job for job in graph.pipeline.jobs.values() if job.unit == "shard"]
    logs = re.compile(rf"(?:{'|'.join(job.name for job in jobs)})_{ANY_SHARD}\.log", re.ASCII)
    for folder, pattern in [(graph.folder_of(job), _patterns(job)) for job in jobs] + [(f"{site_dir}/logs", logs)]:
        for path in list(leftovers(folder, pattern, shards)):
            os.remove(path)
