# SPDX-License-Identifier: Apache-2.0
"""Maps of the same frames by nightmap and by COLMAP, with the queries located in each.

Each of COLMAP's models has its own frame of reference and scale: the similarity that fits their common map
frames best (Umeyama, PAMI 1991) aligns it with nightmap's metric map. A model that does not fit is wrong and
not used. Queries do not take part in the alignment.

Costs: the parts of COLMAP's variants are its commands. The triangulated map needs nightmap's poses, so it includes
nightmap's stages up to the trajectory. Stages that only the cloud and the grid need (octree, ...) do not
count, nor does the export of nightmap's map as a COLMAP model: neither locates anything.
"""

from dataclasses import dataclass, field

import numpy as np

from nightmap_eval.colmap.colmap_files import read_model
from nightmap_eval.colmap.colmap_run import read_receipt
from nightmap_eval.query_errors import PROTOCOLS, WRONG_CM, query_summary
from nightmap_eval.trajectory import Trajectory, associate, make_trajectory, quaternion, umeyama
from nightmap_eval.trajectory_errors import absolute_errors
from nightmap_site.checked_reading import read_object
from nightmap_site.job_results import StageResult, folders_up_to
from nightmap_site.script_errors import DataError

# A model fits when this share of its map cameras lies within these distances of the metric map's.
MIN_FIT_PERCENT = 90.0
MAX_FIT_CM, MAX_FIT_DEG = WRONG_CM, 10.0
# Phases of a query, and COLMAP's commands for each. A phase that is part of another one names it.
PHASES = ("features", "search", "registration", "adjustment")
PHASE_OF_COMMAND = {
    "feature_extractor": "features", "vocab_tree_retriever": "search", "matches_importer": "search",
    "image_registrator": "registration", "bundle_adjuster": "adjustment", "mapper": "registration",
}  # fmt: skip


@dataclass
class Part:
    """Map frames in one frame of reference, and the queries located among them."""

    map_frames: Trajectory
    queries: Trajectory


@dataclass
class Located:
    """The result of one method of mapping and locating."""

    name: str
    parts: list = field(default_factory=list)
    failed: str = ""  # the reason, when there is no result
    models: list = field(default_factory=list)  # COLMAP's models, including those not used

    def merged(self):
        """All parts joined; a frame in several parts counts in the first."""
        return Part(*(_merge([getattr(part, kind) for part in self.parts]) for kind in ("map_frames", "queries")))

    def num_located(self):
        return sum(len(part.queries) for part in self.parts)


def _merge(trajectories):
    poses = {}
    for trajectory in trajectories:
        for pose in zip(trajectory.times_ns.tolist(), trajectory.positions_m, trajectory.quaternions):
            poses.setdefault(pose[0], pose)
    return make_trajectory(list(poses.values()), "merged models")


def matched(estimate, reference):
    """The poses of both at common times, row by row."""
    pairs = associate(estimate.times_ns, reference.times_ns, 0)
    return estimate.select(pairs[:, 0]), reference.select(pairs[:, 1])


def moved(trajectory, similarity):
    rotations = similarity.rotation @ trajectory.rotations()
    quaternions = np.array([quaternion(rotation) for rotation in rotations]).reshape(-1, 4)
    return Trajectory(trajectory.times_ns, similarity.apply(trajectory.positions_m), quaternions)


def model_trajectory(model, time_of_name):
    """The images of a model that have a time, as world_from_camera."""
    rows = [i for i, name in enumerate(model.names) if name in time_of_name]
    poses = [(time_of_name[model.names[i]], model.positions[i], quaternion(model.rotations[i])) for i in rows]
    return make_trajectory(poses, "model")


def fit_to_map(model_frames, metric_map):
    """The similarity map_from_model, or None without one, and the quality of the fit."""
    frames, reference = matched(model_frames, metric_map)
    figures = {"num_map_frames": len(frames), "fits": False}
    try:
        similarity = umeyama(frames.positions_m, reference.positions_m, with_scale=True)
    except DataError as error:
        return None, figures | {"reason": str(error)}
    translation_m, rotation_deg = absolute_errors(frames, reference, similarity)
    near = (100 * translation_m <= MAX_FIT_CM) & (rotation_deg <= MAX_FIT_DEG)
    percent = 100.0 * np.count_nonzero(near) / len(frames)
    figures |= {
        "metres_per_unit": similarity.scale,
        "rmse_to_map_cm": 100 * float(np.sqrt(np.mean(translation_m**2))),
        "fitting_percent": percent,
        "fits": percent >= MIN_FIT_PERCENT,
    }
    if not figures["fits"]:
        figures["reason"] = (
            f"wrong: {percent:.0f} % of its map cameras are within {MAX_FIT_CM} cm and "
            f"{MAX_FIT_DEG:.0f} deg of the metric map's"
        )
    return similarity, figures


def locate_by_models(name, map_folder, folder, map_times, query_times, metric_map):
    """Queries that COLMAP registered in its models; map_times and query_times give the time of an image.

    map_folder holds the models as mapped, folder the same models with the queries. Registration also tries
    map images of other models: only images mapped in a model are its map frames. A query counts in the
    fitting model in which it sees most points."""
    located, best = Located(name), {}
    for path in sorted(folder.iterdir(), key=lambda path: int(path.name)):
        model, mapped = read_model(path), set(read_model(map_folder / path.name).names)
        times_of_mapped = {image: t for image, t in map_times.items() if image in mapped}
        frames, queries = (model_trajectory(model, times) for times in (times_of_mapped, query_times))
        similarity, fit = fit_to_map(frames, metric_map)
        located.models.append(fit | {"model": path.name, "num_queries": len(queries),
                                     "num_points": model.num_points, "size_bytes": model.size_bytes})  # fmt: skip
        if not fit["fits"]:
            continue
        seen = {query_times.get(n): count for n, count in zip(model.names, model.num_observations.tolist())}
        for time_ns in queries.times_ns.tolist():
            best[time_ns] = max(best.get(time_ns, (-1, 0)), (seen[time_ns], -len(located.parts)))
        located.parts.append(Part(moved(frames, similarity), moved(queries, similarity)))
    for i, part in enumerate(located.parts):
        times = part.queries.times_ns.tolist()
        part.queries = part.queries.select([row for row, t in enumerate(times) if best[t][1] == -i])
    if not located.parts:
        located.failed = "no model fits the metric map"
    return located


def errors_against(located, reference, protocol):
    """Times of the located queries that the reference contains, and their translation (m) and rotation
    (degrees) errors; each part's map is aligned separately. `reference` is a Part."""
    times, translation_m, rotation_deg = [], [], []
    for part in located.parts:
        queries, query_reference = matched(part.queries, reference.queries)
        if len(queries) == 0:
            continue
        map_pair = matched(part.map_frames, reference.map_frames)
        metres, degrees = PROTOCOLS[protocol](queries, query_reference, *map_pair)
        times += queries.times_ns.tolist()
        translation_m += metres.tolist()
        rotation_deg += degrees.tolist()
    return times, np.array(translation_m), np.array(rotation_deg)


def summaries(located, reference):
    """Figures per protocol: counts, quantiles and recall over the reference's queries; `failed` gives the
    reason when there are too few common frames to align."""
    figures = {}
    for protocol in PROTOCOLS:
        try:
            _, translation_m, rotation_deg = errors_against(located, reference, protocol)
        except DataError as error:
            figures[protocol] = {"failed": str(error)}
        else:
            figures[protocol] = query_summary(translation_m, rotation_deg, len(reference.queries))
    return figures


def _costs(map_parts, query_parts, query_cpu_s, num_queries, phases_s):
    """`query_cpu_s` sums all cores; other jobs on the machine change it little; None if unknown."""
    query_s = sum(query_parts.values())
    return {
        "map_time_s": sum(map_parts.values()),
        "map_parts_s": map_parts,
        "query_time_s": query_s,
        "query_parts_s": query_parts,
        "query_phases_s": {phase: value if isinstance(value, str) else value / num_queries for phase, value in phases_s.items()},
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
        map_parts = _stage_times_s(site, folders_up_to("map_frame")) | map_parts
    steps = (run.queries_step, run.register_step)
    cpu_s = [part.get("cpu_time_s") for _, part in _commands(root, steps)]
    query_parts, query_cpu_s = _command_times_s(root, steps), sum(cpu_s) if cpu_s and None not in cpu_s else None
    files = [root / "matches" / name for name in ("database.db", "vocabulary.bin")]
    files += sorted((root / run.map_step).glob("models/*/*.bin"))
    size = sum(path.stat().st_size for path in files if path.exists())
    costs = _costs(map_parts, query_parts, query_cpu_s, num_queries, _phases_s(root, steps))
    return costs | {"map_size_bytes": size}
