# SPDX-License-Identifier: Apache-2.0
"""The ways in which COLMAP locates the queries, and the steps that each is made of."""

from dataclasses import dataclass

# COLMAP's mapper draws samples, and each of its maps is another one: the run in the middle counts.
MAPPER_RUNS = ("mapper_1", "mapper_2", "mapper_3")
# Images that the vocabulary tree retrieves for a query. `queries`: as many as for a mapping frame (as
# COLMAP counts, one of those is itself); `queries_default`: as many as COLMAP does unless told otherwise.
MATCHED_WITH = {"queries": 30, "queries_default": 100}


@dataclass(frozen=True)
class Run:
    """One map with the queries in it, by the steps that make each."""

    method: str
    map_step: str
    queries_step: str
    register_step: str

    @property
    def is_calibrated(self):
        """Whether the cameras are those that belong to nightmap's poses."""
        return self.map_step == "triangulate"

    @property
    def is_held(self):
        return self.method.startswith("colmap_held")


def _runs(suffix):
    maps = [("mapper", step, step) for step in MAPPER_RUNS]
    maps += [("triangulate", "triangulate", "triangulate"), ("held", "triangulate", "held")]
    return [
        Run(f"colmap_{method}{suffix}", map_step, f"queries{suffix}", f"register_{name}{suffix}")
        for method, map_step, name in maps
    ]


RUNS = (*_runs(""), *_runs("_default"))
METHODS = tuple(dict.fromkeys(run.method for run in RUNS))
