# SPDX-License-Identifier: Apache-2.0
"""The methods by which COLMAP locates the queries, and the steps of each."""

from dataclasses import dataclass

# COLMAP's mapper draws random samples, so its maps differ: the median run counts.
MAPPER_RUNS = ("mapper_1", "mapper_2", "mapper_3")
# Images that the vocabulary tree retrieves per query. `queries`: as many as per mapping frame (COLMAP's count
# includes the frame itself); `queries_default`: COLMAP's default number.
MATCHED_WITH = {"queries": 30, "queries_default": 100}


@dataclass(frozen=True)
class Run:
    """One map and the queries in it, named by the steps that make them."""

    method: str
    map_step: str
    queries_step: str
    register_step: str


def _runs(suffix):
    maps = [("mapper", step, step) for step in MAPPER_RUNS]
    maps += [("triangulate", "triangulate", "triangulate"), ("held", "triangulate", "held")]
    return [
        Run(f"colmap_{method}{suffix}", map_step, f"queries{suffix}", f"register_{name}{suffix}")
        for method, map_step, name in maps
    ]


RUNS = (*_runs(""), *_runs("_default"))
METHODS = tuple(dict.fromkeys(run.method for run in RUNS))
