# SPDX-License-Identifier: Apache-2.0
"""Time and size of a map, and time to locate queries in it, from the receipts of the runs.

The parts of COLMAP's variants are its commands. The triangulated map needs nightmap's poses, so it includes
nightmap's stages up to the trajectory. Stages that only the cloud and the grid need (octree, ...) do not
count, nor does the export of nightmap's map as a COLMAP model: neither locates anything.
"""

from nightmap_eval.colmap.colmap_run import read_receipt
from nightmap_site.checked_reading import read_object
from nightmap_site.job_results import StageResult, folders_up_to

# Phases of a query, and COLMAP's commands for each. A phase that is part of another one names it.
PHASES = ("features", "search", "registration", "adjustment")
PHASE_OF_COMMAND = {
    "feature_extractor": "features", "vocab_tree_retriever": "search", "matches_importer": "search",
    "image_registrator": "registration", "bundle_adjuster": "adjustment", "mapper": "registration",
}  # fmt: skip
POSES = "map_frame"  # the job that makes the poses


def _costs(map_parts, query_parts, query_cpu_s, num_queries, phases_s):
    """`query_cpu_s` sums all cores; other jobs on the machine change it little; None if unknown."""
    query_s = sum(query_parts.values())
    return {
        "map_time_s": sum(map_parts.values()),
        "map_parts_s": map_parts,
        "query_time_s": query_s,
        "query_parts_s": query_parts,
        "query_phases_s": {
            phase: value if isinstance(value, str) else value / num_queries for phase, value in phases_s.items()
        },
        "time_per_query_s": query_s / num_queries,
        "cpu_time_per_query_s": None if query_cpu_s is None else query_cpu_s / num_queries,
    }


def _stage_times_s(site, folders):
    """Wall time of each stage that ran, without its part `export`."""
    results = {folder: StageResult(site.folder / folder) for folder in folders}
    return {
        folder: result.wall_time_s() - result.part_time_s("export")
        for folder, result in results.items() if result.wall_time_s() is not None
    }  # fmt: skip


def nightmap_costs(site, num_queries):
    map_parts = _stage_times_s(site, folders_up_to("landmarks"))
    files = [site.needed("landmarks", "landmarks"), site.needed("vocabulary", "vocabulary")]
    report = read_object(site.needed("landmarks", "report"), {"num_landmarks": int})
    size = sum(path.stat().st_size for path in files)
    localize = StageResult(site.folder_of("localize"))
    query_parts, query_cpu_s = _stage_times_s(site, ("localize",)), localize.cpu_time_s()
    phases_s = {"features": localize.part_time_s("extract"), "search": localize.part_time_s("locate"),
                "registration": "in search", "adjustment": "in search"}  # fmt: skip
    costs = _costs(map_parts, query_parts, query_cpu_s, num_queries, phases_s)
    return costs | {"map_size_bytes": size, "num_points": report["num_landmarks"]}


def _commands(root, steps):
    """The commands that ran in these steps, with names and times."""
    for step in steps:
        if (root / step / "receipt.json").exists():
            for part in read_receipt(root / step)["parts"]:
                yield f"{step}: {part['name']}", part


def _command_times_s(root, steps):
    """Time of each command; the same command in two steps gives two parts."""
    times = {}
    for name, part in _commands(root, steps):
        times[name] = times.get(name, 0.0) + part["wall_time_s"]
    return times


def _phases_s(root, steps):
    """Time of each phase over all queries; 0 for a phase without a command."""
    phases_s = dict.fromkeys(PHASES, 0.0)
    commands = [part for _, part in _commands(root, steps)]
    for part in commands:
        if part["name"] in PHASE_OF_COMMAND:
            phases_s[PHASE_OF_COMMAND[part["name"]]] += part["wall_time_s"]
    if any(part["name"] == "mapper" for part in commands):  # the mapper adjusts after each image
        phases_s["adjustment"] = "in registration"
    return phases_s


def colmap_costs(site, run, num_queries):
    """Map and points include all models of the run's map: locating a query tries each."""
    root = site.evaluate_colmap
    map_parts = _command_times_s(root, ("features", "matches", run.map_step))
    if run.map_step == "triangulate":
        map_parts = _stage_times_s(site, folders_up_to(POSES)) | map_parts
    steps = (run.queries_step, run.register_step)
    cpu_s = [part.get("cpu_time_s") for _, part in _commands(root, steps)]
    query_parts, query_cpu_s = _command_times_s(root, steps), sum(cpu_s) if cpu_s and None not in cpu_s else None
    files = [root / "matches" / name for name in ("database.db", "vocabulary.bin")]
    files += sorted((root / run.map_step).glob("models/*/*.bin"))
    size = sum(path.stat().st_size for path in files if path.exists())
    costs = _costs(map_parts, query_parts, query_cpu_s, num_queries, _phases_s(root, steps))
    return costs | {"map_size_bytes": size}
