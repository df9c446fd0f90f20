#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Removes the results of shards that the list of shards does not name any more: of a recording that became
shorter, or was cut into other shards. (What is of tiles that are no more the stages remove themselves.)

Only files that a stage gives just such a name are touched. Without a whole list nothing is.
"""

import os
import re
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

from nightmap_eval.errors import run_main  # noqa: E402
from nightmap_eval.lists import read_shards  # noqa: E402

STAGES = ("features", "matches", "odometry")
RESULT = re.compile(r"(?:shard_(\d{4,9})\.(?:h5|tum)|(?:report|receipt)_(\d{4,9})\.json)", re.ASCII)
LOG = re.compile(rf"(?:{'|'.join(STAGES)})_(\d{{4,9}})\.log", re.ASCII)


def leftovers(folder, pattern, shards):
    """Paths of a folder's files that belong to a shard that is not in the set."""
    for name in sorted(os.listdir(folder)) if os.path.isdir(folder) else []:
        found = pattern.fullmatch(name)
        if found and found[found.lastindex] not in shards:
            yield os.path.join(folder, name)


def main():
    [site_dir] = sys.argv[1:]
    shards = set(read_shards(site_dir))
    for folder, pattern in [(stage, RESULT) for stage in STAGES] + [("logs", LOG)]:
        for path in list(leftovers(os.path.join(site_dir, folder), pattern, shards)):
            os.remove(path)


if __name__ == "__main__":
    run_main(main)
