#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""colmap_step: one step of the comparison with COLMAP; `make evaluate-colmap` runs them in turn.

  features      COLMAP's features of the mapping frames
  matches       their matches: exhaustive up to 100 frames, above that sequential and by a vocabulary
                tree that is built of the map's own features
  mapper        COLMAP's own map; it may come in several models
  triangulate   COLMAP's points at nightmap's poses, with the focal lengths that nightmap found for them
  queries       features of the queries, and the matches of each with mapping frames: all of them up to
                100, above that those that are most similar by the vocabulary tree
  register_mapper, register_triangulate
                queries put into these maps, then bundle adjustment, as COLMAP's documentation recommends
  register_held queries put into the map of `triangulate` by the mapper, which triangulates and adjusts
                as it goes on: what the documentation recommends for more accuracy. The map's images stay
                where nightmap has them

COLMAP's defaults, but on the CPU, with the intrinsics known and never refined by COLMAP, and fewer images
retrieved for a mapping frame.
COLMAP failing is a result, kept in the step's receipt; the variants that depend on it are reported as
failed.
Exit codes: 0 written; 1 COLMAP is not installed, or missing data; 2 wrong command line.
"""

import argparse
import re
import shutil
import signal
import sys
from pathlib import Path

from nightmap_eval.colmap_files import camera_parameters, read_images, read_model, replace_cameras, write_posed_images
from nightmap_eval.colmap_run import ColmapFailed, Step, require
from nightmap_eval.errors import DataError, run_main
from nightmap_eval.queries import refuse_mapped_queries
from nightmap_eval.reading import read_object
from nightmap_eval.site import Frames, read_csv
from nightmap_eval.trajectory import read_tum

MAX_EXHAUSTIVE = 100
# Images that the vocabulary tree retrieves for a query: COLMAP's default. For a mapping frame (as COLMAP
# counts, one of them is itself) that would make matching on a CPU take hours for a few hundred frames.
NUM_RETRIEVED_FOR_QUERY = 100
NUM_RETRIEVED = 30
# What vocab_tree_retriever prints: a line a query, then one for each image it found, best first.
QUERYING, FOUND = re.compile(r"Querying for image "), re.compile(r"image_id=(\d+), image_name=")
CAMERAS = {"cameras": [{"color": dict}]}
INTRINSICS = ("focal_length", "principal_point", "extra_params")
FIXED_MAPPER = {f"Mapper__ba_refine_{name}": 0 for name in INTRINSICS}
FIXED_ADJUSTER = {f"BundleAdjustment__refine_{name}": 0 for name in INTRINSICS}


class Work:
    """The step at hand and where the others left what they made."""

    def __init__(self, arguments):
        self.site_dir, self.data = arguments.site_dir, arguments.data
        self.root = self.site_dir / "evaluate_colmap"
        self.step = Step(self.root / arguments.step, arguments.threads)
        self.matching = {"SiftMatching__use_gpu": 0, "SiftMatching__num_threads": arguments.threads}
        self.mapping = {"Mapper__num_threads": arguments.threads, **FIXED_MAPPER}

    def copy_database(self, before):
        """The database of the step before, in this step's folder."""
        require(self.root / before)
        target = self.step.folder / "database.db"
        shutil.copyfile(self.root / before / "database.db", target)
        return target

    def calibrate(self, database):
        """Puts in the cameras that belong to nightmap's poses: its focal lengths may differ from the configured."""
        configured, calibrated = (
            [camera["color"] for camera in read_object(self.site_dir / stage / "cameras.json", CAMERAS)["cameras"]]
            for stage in ("frames", "pose_graph")
        )
        replace_cameras(database, configured, calibrated)

    def write_list(self, name, lines):
        path = self.step.folder / name
        path.write_text("".join(f"{line}\n" for line in lines), encoding="utf-8")
        return path

    def query_rows(self):
        rows = read_csv(self.site_dir / "queries" / "queries.csv", ("color_path", "camera_idx"))
        map_rows = Frames(self.site_dir).rows
        refuse_mapped_queries(*([row["color_path"] for row in some] for some in (rows, map_rows)))
        return rows

    def extract(self, database, rows, cameras):
        """Features of the pictures of rows of a list of frames, camera by camera."""
        for row in rows:
            if "#" in row["color_path"] or " " in row["color_path"]:
                raise DataError(
                    f"{row['color_path']}: COLMAP cannot read a frame of a video or a name with a space; "
                    "store the pictures one by one"
                )
        cameras = read_object(self.site_dir / cameras, CAMERAS)["cameras"]
        for idx in sorted({int(row["camera_idx"]) for row in rows}):
            names = [row["color_path"] for row in rows if int(row["camera_idx"]) == idx]
            model, parameters = camera_parameters(cameras[idx]["color"])
            self.step.colmap(
                "feature_extractor", database_path=database, image_path=self.data,
                image_list_path=self.write_list(f"images_{idx}.txt", names),
                ImageReader__single_camera=1, ImageReader__camera_model=model,
                ImageReader__camera_params=",".join(repr(float(value)) for value in parameters),
                SiftExtraction__use_gpu=0, SiftExtraction__num_threads=self.step.threads,
            )  # fmt: skip

    def retrieve(self, database, tree, names, map_names):
        """query -> the NUM_RETRIEVED_FOR_QUERY mapping frames that are most similar to it by the vocabulary tree.

        vocab_tree_matcher would search all images of the database: a query would find itself and other
        queries, and the fewer mapping frames for it. It has the same defaults."""
        printed = self.step.colmap(
            "vocab_tree_retriever", database_path=database, vocab_tree_path=tree, num_images=NUM_RETRIEVED_FOR_QUERY,
            query_image_list_path=self.write_list("queries.txt", names),
            database_image_list_path=self.write_list("map.txt", map_names),
        )  # fmt: skip
        name_of_id = {image_id: name for image_id, name, _ in read_images(database)}
        found = []
        for text in printed:
            if QUERYING.search(text):
                found.append([])
            elif found and (match := FOUND.search(text)):
                found[-1].append(name_of_id[int(match.group(1))])
        if len(found) != len(names):
            raise ColmapFailed(f"colmap vocab_tree_retriever: told of {len(found)} of {len(names)} queries")
        return dict(zip(names, found))


def features(work):
    work.query_rows()  # refused now rather than after the hours that the map takes
    frames = Frames(work.site_dir)
    work.extract(work.step.folder / "database.db", frames.rows, "frames/cameras.json")
    return {"num_images": len(frames)}


def matches(work):
    database = work.copy_database("features")
    if len(Frames(work.site_dir)) <= MAX_EXHAUSTIVE:
        work.step.colmap("exhaustive_matcher", database_path=database, **work.matching)
        return {"matching": "exhaustive"}
    tree = work.step.folder / "vocabulary.bin"
    work.step.colmap("sequential_matcher", database_path=database, **work.matching)
    work.step.colmap("vocab_tree_builder", database_path=database, vocab_tree_path=tree)
    work.step.colmap(
        "vocab_tree_matcher", database_path=database, VocabTreeMatching__vocab_tree_path=tree,
        VocabTreeMatching__num_images=NUM_RETRIEVED, **work.matching,
    )  # fmt: skip
    return {"matching": f"sequential and vocabulary tree of the map's features, {NUM_RETRIEVED} images retrieved"}


def mapper(work):
    require(work.root / "matches")
    models = work.step.folder / "models"
    models.mkdir()
    work.step.colmap(
        "mapper", database_path=work.root / "matches" / "database.db", image_path=work.data,
        output_path=models, **work.mapping,
    )  # fmt: skip
    if not any(models.iterdir()):
        raise ColmapFailed("colmap mapper: no model")


def triangulate(work):
    database = work.copy_database("matches")
    work.calibrate(database)
    trajectory = read_tum(work.site_dir / "map_frame" / "trajectory.tum")
    poses = zip(trajectory.rotations(), trajectory.positions_m)
    pose_of_time = dict(zip(trajectory.times_ns.tolist(), poses))
    pose_of_name = {
        row["color_path"]: pose_of_time[int(row["time_ns"])]
        for row in Frames(work.site_dir).rows if int(row["time_ns"]) in pose_of_time
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


def queries(work):
    database, rows = work.copy_database("matches"), work.query_rows()
    names = [row["color_path"] for row in rows]
    work.extract(database, rows, "queries/query_cameras.json")
    map_names = [row["color_path"] for row in Frames(work.site_dir).rows]
    tree = work.root / "matches" / "vocabulary.bin"
    if tree.exists():
        found = work.retrieve(database, tree, names, map_names)
        matching = f"with the {NUM_RETRIEVED_FOR_QUERY} mapping frames most similar by that vocabulary tree"
    else:
        found, matching = dict.fromkeys(names, map_names), "with all mapping frames"
    pairs = [f"{name} {other}" for name in names for other in found[name]]
    work.step.colmap(
        "matches_importer", database_path=database, match_type="pairs",
        match_list_path=work.write_list("pairs.txt", pairs), **work.matching,
    )  # fmt: skip
    return {"matching": matching}


def register(work, variant):
    require(work.root / variant)
    database = work.copy_database("queries")
    if variant == "triangulate":
        work.calibrate(database)
    for model in sorted((work.root / variant / "models").iterdir(), key=lambda path: int(path.name)):
        registered, adjusted = (work.step.folder / kind / model.name for kind in ("registered", "models"))
        registered.mkdir(parents=True)
        adjusted.mkdir(parents=True)
        work.step.colmap(
            "image_registrator", database_path=database, input_path=model,
            output_path=registered, **work.mapping,
        )  # fmt: skip
        work.step.colmap("bundle_adjuster", input_path=registered, output_path=adjusted, **FIXED_ADJUSTER)


def register_held(work):
    require(work.root / "triangulate")
    database, model = work.copy_database("queries"), work.step.folder / "models" / "0"
    work.calibrate(database)
    model.mkdir(parents=True)
    work.step.colmap(
        "mapper", database_path=database, image_path=work.data, input_path=work.root / "triangulate" / "models" / "0",
        output_path=model, Mapper__fix_existing_images=1, **work.mapping,
    )  # fmt: skip


STEPS = {
    "features": features,
    "matches": matches,
    "mapper": mapper,
    "triangulate": triangulate,
    "queries": queries,
    "register_mapper": lambda work: register(work, "mapper"),
    "register_triangulate": lambda work: register(work, "triangulate"),
    "register_held": register_held,
}


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("step", choices=STEPS)
    parser.add_argument("--site-dir", type=Path, required=True, help="maps/<site>")
    parser.add_argument("--data", type=Path, required=True, help="folder of the recordings")
    parser.add_argument("--threads", type=int, required=True)
    return parser.parse_args()


def main():
    arguments = parse_arguments()
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))  # through the clean-up that ends COLMAP
    work = Work(arguments)
    try:
        figures = STEPS[arguments.step](work) or {}
    except ColmapFailed as failure:
        work.step.finish(failed=str(failure))
    else:
        work.step.finish(**figures)


if __name__ == "__main__":
    run_main(main)
