# SPDX-License-Identifier: Apache-2.0
"""Runs the programs that map a composed site as a whole, one after the other, with the default configs."""

from checkout import CHECKOUT
from stage_run import LOCALIZE_OUTPUTS, localize_inputs

WINGS = {"vocabulary": "camera", "loops": "camera", "pose_graph": "graph", "adjust": "camera", "map_frame": "dense",
         "landmarks": "camera", "localize": "camera"}  # fmt: skip
MODEL = ("cameras.txt", "cameras.bin", "images.txt", "images.bin", "points3D.txt", "points3D.bin")
OUTPUTS = {
    "vocabulary": {"vocabulary": "vocabulary.h5"},
    "loops": {"loops": "loops.h5"},
    "pose_graph": {"graph": "graph.h5", "trajectory": "trajectory.tum", "keyframes": "keyframes.tum", "loops_csv": "loops.csv"},
    "adjust": {"g2o": "graph.g2o", "trajectory": "trajectory.tum", "keyframes": "keyframes.tum", "cameras": "cameras.json"},
    "map_frame": {"trajectory": "trajectory.tum", "keyframes": "keyframes.tum"},
    "landmarks": {"landmarks": "landmarks.h5", **{name: f"colmap/{name}" for name in MODEL}, "database": "colmap/database.db"},
    "localize": LOCALIZE_OUTPUTS,
}


def shards(folder, job, ending="h5"):
    return sorted((folder / job).glob(f"shard_*.{ending}"))


def first_visit(folder):
    """Odometry of the shards of the first visit; the second has as many."""
    odometry = shards(folder, "odometry")
    return odometry[: len(odometry) // 2]


def inputs_of(program, folder, source, data):
    """The files of a site that a program reads. `source`, `data`: the real site and its recordings, of which queries are."""
    if program == "localize":
        return localize_inputs(folder, data) | {"queries": source / "queries/queries.csv", "cameras": source / "queries/query_cameras.json"}
    frames, features, cameras = shards(folder, "frames", "csv"), shards(folder, "features"), folder / "frames/cameras.json"
    vocabulary, loops = folder / "vocabulary/vocabulary.h5", folder / "loops/loops.h5"
    way = {name: folder / f"map_frame/{name}.tum" for name in ("trajectory", "keyframes")}
    adjusted = {name: folder / f"adjust/{name}.tum" for name in way}
    return {
        "vocabulary": {"features": features},
        "loops": {"frames": frames, "cameras": cameras, "features": features, "vocabulary": vocabulary},
        "pose_graph": {"frames": frames, "odometry": shards(folder, "odometry"), "loops": loops},
        "adjust": {"frames": frames, "cameras": cameras, "features": features, "odometry": shards(folder, "odometry"),
                   "loops": loops, "graph": folder / "pose_graph/graph.h5"},
        "map_frame": {"frames": frames, "cameras": folder / "adjust/cameras.json", "data": folder / "data", **adjusted,
                      "acceleration": folder / "frames/acceleration.h5"},
        "landmarks": {"frames": frames, "cameras": folder / "adjust/cameras.json", "features": features,
                      "vocabulary": vocabulary, **way},
    }[program]  # fmt: skip


def run(program, programs, folder, source, data):
    """Runs a program on a site; returns its StageResult. Raises DataError when it fails."""
    if program == "landmarks":
        (folder / program / "colmap").mkdir(parents=True)
    config = CHECKOUT / "configs" / WINGS[program] / "default" / f"{program}.toml"
    return programs.run(program, inputs_of(program, folder, source, data), OUTPUTS[program], folder / program, config)
