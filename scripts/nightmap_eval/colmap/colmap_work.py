# SPDX-License-Identifier: Apache-2.0
"""Shared code of the COLMAP steps: folders, databases, features, retrieval."""

import re
import shutil

from nightmap_eval.artifacts import Frames, read_csv
from nightmap_eval.colmap.colmap_files import camera_parameters, read_images, replace_cameras
from nightmap_eval.colmap.colmap_run import ColmapFailed, Step, require
from nightmap_eval.located_queries import refuse_mapped_queries
from nightmap_eval.pictures import SIZE, picture_camera
from nightmap_site.checked_reading import read_object
from nightmap_site.script_errors import DataError
from nightmap_site.site import Site

# vocab_tree_retriever prints a line per query, then a line per retrieved image, best first.
QUERYING, FOUND = re.compile(r"Querying for image "), re.compile(r"image_id=(\d+), image_name=")
CAMERAS = {"cameras": [{"color": dict, **SIZE}]}
INTRINSICS = ("focal_length", "principal_point", "extra_params")
FIXED_MAPPER = {f"Mapper__ba_refine_{name}": 0 for name in INTRINSICS}
FIXED_ADJUSTER = {f"BundleAdjustment__refine_{name}": 0 for name in INTRINSICS}


class Work:
    """The current step, and the folders of the other steps."""

    def __init__(self, arguments):
        self.site, self.data = Site(arguments.site_dir), arguments.data
        self.root = self.site.evaluate_colmap
        self.step = Step(self.root / arguments.step, arguments.threads)
        self.matching = {"SiftMatching__use_gpu": 0, "SiftMatching__num_threads": arguments.threads}
        self.mapping = {"Mapper__num_threads": arguments.threads, **FIXED_MAPPER}

    def copy_database(self, before):
        """Copies the previous step's database into this step's folder."""
        require(self.root / before)
        target = self.step.folder / "database.db"
        shutil.copyfile(self.root / before / "database.db", target)
        return target

    def calibrate(self, database):
        """Sets the cameras that belong to nightmap's poses: their focal lengths may differ from the configured ones."""
        configured, calibrated = (
            [picture_camera(camera) for camera in read_object(path, CAMERAS)["cameras"]]
            for path in (self.site.needed("frames", "cameras"), self.site.input("landmarks", "cameras"))
        )
        replace_cameras(database, configured, calibrated)

    def write_list(self, name, lines):
        path = self.step.folder / name
        path.write_text("".join(f"{line}\n" for line in lines), encoding="utf-8")
        return path

    def query_rows(self):
        rows = read_csv(self.site.needed("queries", "queries"), ("color_path", "camera_idx"))
        map_rows = Frames(self.site).rows
        refuse_mapped_queries(*([row["color_path"] for row in some] for some in (rows, map_rows)))
        return rows

    def extract(self, database, rows, cameras_path):
        """Extracts features of the pictures in rows of a list of frames, camera by camera."""
        for row in rows:
            if "#" in row["color_path"] or " " in row["color_path"]:
                raise DataError(
                    f"{row['color_path']}: COLMAP cannot read a frame of a video or a name with a space; "
                    "store the pictures one by one"
                )
        cameras = read_object(cameras_path, CAMERAS)["cameras"]
        for idx in sorted({int(row["camera_idx"]) for row in rows}):
            names = [row["color_path"] for row in rows if int(row["camera_idx"]) == idx]
            model, parameters = camera_parameters(picture_camera(cameras[idx]))
            self.step.colmap(
                "feature_extractor", database_path=database, image_path=self.data,
                image_list_path=self.write_list(f"images_{idx}.txt", names),
                ImageReader__single_camera=1, ImageReader__camera_model=model,
                ImageReader__camera_params=",".join(repr(float(value)) for value in parameters),
                SiftExtraction__use_gpu=0, SiftExtraction__num_threads=self.step.threads,
            )  # fmt: skip

    def retrieve(self, database, tree, names, map_names, num_images):
        """query -> the num_images mapping frames that are most similar to it by the vocabulary tree.

        vocab_tree_matcher would search all images of the database: a query would find itself and other
        queries, and therefore fewer mapping frames. Its defaults are the same."""
        printed = self.step.colmap(
            "vocab_tree_retriever", database_path=database, vocab_tree_path=tree, num_images=num_images,
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
            raise ColmapFailed(f"colmap vocab_tree_retriever: printed results of {len(found)} of {len(names)} queries")
        return dict(zip(names, found))
