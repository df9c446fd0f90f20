#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""colmap_step: one step of the comparison with COLMAP; `make evaluate-colmap` runs them in turn.

  features      COLMAP's features of the mapping frames
  matches       their matches: exhaustive up to 100 frames; above that, sequential plus 30 images
                retrieved per frame by a vocabulary tree built from the map's own features
  mapper_1, mapper_2, mapper_3
                COLMAP's own map, one run per seed; a map may consist of several models
  triangulate   COLMAP's points at nightmap's poses, with the focal lengths that nightmap found for them
  queries       features of the queries, and the matches of each with mapping frames: with all up to 100
                frames; above that, with the 30 most similar by the vocabulary tree
  queries_default
                the same with 100 retrieved frames, COLMAP's default; skipped where `queries` matches all
  register_<map>, register_<map>_default
                registers the queries in each of these maps, then adjusts the bundle, as COLMAP's
                documentation recommends
  register_held, register_held_default
                registers the queries in the map of `triangulate` with the mapper, which triangulates and
                adjusts after each image; COLMAP's documentation recommends this for more accuracy. The
                map's images stay at nightmap's poses

All steps use COLMAP's defaults with three exceptions: they run on the CPU, intrinsics are known and never
refined by COLMAP, and fewer images are retrieved (100 per mapping frame would take hours).
A failure of COLMAP is a result: the step's receipt keeps it, and the variants that depend on it are
reported as failed.
Exit codes: 0 written; 1 COLMAP is not installed, or missing data; 2 wrong command line.
"""

import functools
import signal
import sys

from nightmap_eval.artifacts import Frames
from nightmap_eval.colmap.colmap_files import FIXED_ADJUSTER, Work, read_model, write_posed_images
from nightmap_eval.colmap.colmap_run import MAPPER_RUNS, MATCHED_WITH, RUNS, ColmapFailed, ColmapSkipped, require
from nightmap_eval.trajectory import read_tum
from nightmap_site.script_errors import paths_parser, run_main

MAX_EXHAUSTIVE = 100


def features(work):
    work.query_rows()  # fail before the map is built, which takes hours
    frames = Frames(work.site)
    work.extract(work.step.folder / "database.db", frames.rows, work.site.needed("frames", "cameras"))
    return {"num_images": len(frames)}


def matches(work):
    database = work.copy_database("features")
    if len(Frames(work.site)) <= MAX_EXHAUSTIVE:
        work.step.colmap("exhaustive_matcher", database_path=database, **work.matching)
        return {"matching": "exhaustive"}
    tree = work.step.folder / "vocabulary.bin"
    work.step.colmap("sequential_matcher", database_path=database, **work.matching)
    work.step.colmap("vocab_tree_builder", database_path=database, vocab_tree_path=tree)
    work.step.colmap(
        "vocab_tree_matcher", database_path=database, VocabTreeMatching__vocab_tree_path=tree,
        VocabTreeMatching__num_images=MATCHED_WITH["queries"], **work.matching,
    )  # fmt: skip
    return {"matching": f"sequential and vocabulary tree of the map's features, {MATCHED_WITH['queries']} images retrieved"}


def mapper(work, seed):
    require(work.root / "matches")
    models = work.step.folder / "models"
    models.mkdir()
    work.step.colmap(
        "mapper", database_path=work.root / "matches" / "database.db", image_path=work.data,
        output_path=models, random_seed=seed, **work.mapping,
    )  # fmt: skip
    if not any(models.iterdir()):
        raise ColmapFailed("colmap mapper: no model")


def triangulate(work):
    database = work.copy_database("matches")
    work.calibrate(database)
    trajectory = read_tum(work.site.needed("map_frame", "trajectory"))
    poses = zip(trajectory.rotations(), trajectory.positions_m)
    pose_of_time = dict(zip(trajectory.times_ns.tolist(), poses))
    pose_of_name = {
        row["color_path"]: pose_of_time[int(row["time_ns"])]
        for row in Frames(work.site).rows if int(row["time_ns"]) in pose_of_time
    }  # fmt: skip
    posed, model = work.step.folder / "posed", work.step.folder / "models" / "0"
    write_posed_images(posed, database, pose_of_name)
    model.mkdir(parents=True)
    work.step.colmap(
        "point_triangulator", database_path=database, image_path=work.data, input_path=posed,
        output_path=model, **work.mapping,
    )  # fmt: skip
    if read_model(model).num_points == 0:
        raise ColmapFailed("colmap point_triangulator: no point")


def queries(work, step):
    tree = work.root / "matches" / "vocabulary.bin"
    require(tree.parent)
    if step != "queries" and not tree.exists():
        raise ColmapSkipped("queries are matched with all mapping frames")
    database, rows = work.copy_database("matches"), work.query_rows()
    names = [row["color_path"] for row in rows]
    work.extract(database, rows, work.site.needed("queries", "query_cameras"))
    map_names = [row["color_path"] for row in Frames(work.site).rows]
    if tree.exists():
        found = work.retrieve(database, tree, names, map_names, MATCHED_WITH[step])
        matching = f"with the {MATCHED_WITH[step]} mapping frames most similar by that vocabulary tree"
    else:
        found, matching = dict.fromkeys(names, map_names), "with all mapping frames"
    pairs = [f"{name} {other}" for name in names for other in found[name]]
    work.step.colmap(
        "matches_importer", database_path=database, match_type="pairs",
        match_list_path=work.write_list("pairs.txt", pairs), **work.matching,
    )  # fmt: skip
    return {"matching": matching}


def register(work, run):
    require(work.root / run.map_step)
    database = work.copy_database(run.queries_step)
    if run.map_step == "triangulate":  # with the cameras that belong to nightmap's poses
        work.calibrate(database)
    for model in sorted((work.root / run.map_step / "models").iterdir(), key=lambda path: int(path.name)):
        registered, adjusted = (work.step.folder / kind / model.name for kind in ("registered", "models"))
        registered.mkdir(parents=True)
        adjusted.mkdir(parents=True)
        work.step.colmap(
            "image_registrator", database_path=database, input_path=model,
            output_path=registered, **work.mapping,
        )  # fmt: skip
        work.step.colmap("bundle_adjuster", input_path=registered, output_path=adjusted, **FIXED_ADJUSTER)


def register_held(work, run):
    require(work.root / run.map_step)
    database, model = work.copy_database(run.queries_step), work.step.folder / "models" / "0"
    work.calibrate(database)
    model.mkdir(parents=True)
    work.step.colmap(
        "mapper", database_path=database, image_path=work.data, output_path=model,
        input_path=work.root / run.map_step / "models" / "0", Mapper__fix_existing_images=1, **work.mapping,
    )  # fmt: skip


STEPS = {
    "features": features,
    "matches": matches,
    **{step: functools.partial(mapper, seed=seed) for seed, step in enumerate(MAPPER_RUNS, 1)},
    "triangulate": triangulate,
    **{step: functools.partial(queries, step=step) for step in MATCHED_WITH},
    **{run.register_step: functools.partial(register_held if run.method.startswith("colmap_held") else register, run=run) for run in RUNS},
}


def main():
    parser = paths_parser(__doc__, site_dir="maps/<site>", data="folder of the recordings")
    parser.add_argument("step", choices=STEPS)
    parser.add_argument("--threads", type=int, required=True)
    arguments = parser.parse_args()
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))  # runs the clean-up that ends COLMAP
    work = Work(arguments)
    try:
        figures = STEPS[arguments.step](work) or {}
    except ColmapFailed as failure:
        work.step.finish(failed=str(failure))
    except ColmapSkipped as reason:
        work.step.finish(skipped=str(reason))
    else:
        work.step.finish(**figures)


if __name__ == "__main__":
    run_main(main)
