# SPDX-License-Identifier: Apache-2.0
"""COLMAP's files: its database, and sparse models; reads binary models and writes text models.

Formats of version 3.8 (https://colmap.github.io/format.html). COLMAP's pixel (0, 0) is the corner of
the top left pixel, nightmap's is the centre.
"""

import contextlib
import re
import shutil
import sqlite3
import struct
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from nightmap_eval.artifacts import Frames, read_csv
from nightmap_eval.colmap.colmap_run import ColmapFailed, Step, require
from nightmap_eval.pictures import SIZE, picture_camera
from nightmap_eval.query_errors import refuse_mapped_queries
from nightmap_eval.trajectory import quaternion, rotation_matrices
from nightmap_site.checked_reading import read_object
from nightmap_site.script_errors import DataError
from nightmap_site.site import Site

MODELS = {1: ("PINHOLE", 4), 5: ("OPENCV_FISHEYE", 8), 6: ("FULL_OPENCV", 12)}  # that we use: number of parameters
# vocab_tree_retriever prints a line per query, then a line per retrieved image, best first.
QUERYING, FOUND = re.compile(r"Querying for image "), re.compile(r"image_id=(\d+), image_name=")
CAMERAS = {"cameras": [{"color": dict, **SIZE}]}
INTRINSICS = ("focal_length", "principal_point", "extra_params")
FIXED_MAPPER = {f"Mapper__ba_refine_{name}": 0 for name in INTRINSICS}
FIXED_ADJUSTER = {f"BundleAdjustment__refine_{name}": 0 for name in INTRINSICS}


@dataclass
class Model:
    """One sparse model; world is its own frame of reference, of unknown scale."""

    names: list  # of the n registered images
    positions: np.ndarray  # (n, 3) camera centres
    rotations: np.ndarray  # (n, 3, 3) world_from_camera
    num_observations: np.ndarray  # (n,) keypoints that show a point of the model
    num_points: int
    size_bytes: int


def camera_parameters(camera):
    """Name of COLMAP's camera model and its parameters, of a picture_camera."""
    pinhole = [camera["fx"], camera["fy"], camera["cx"] + 0.5, camera["cy"] + 0.5]
    if camera.get("lens") == "fisheye":
        return "OPENCV_FISHEYE", pinhole + [camera[name] for name in ("k1", "k2", "k3", "k4")]
    distortion = [camera.get(name, 0.0) for name in ("k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6")]
    if not any(distortion):
        return "PINHOLE", pinhole
    return "FULL_OPENCV", pinhole + distortion


class _Bytes:
    def __init__(self, path):
        self.path, self.bytes, self.at = path, Path(path).read_bytes(), 0

    def cut(self, size):
        self.at += size
        if self.at > len(self.bytes):
            raise DataError(f"{self.path}: truncated; delete its folder and run make again")
        return self.bytes[self.at - size : self.at]

    def take(self, layout):
        return struct.unpack("<" + layout, self.cut(struct.calcsize("<" + layout)))

    def take_text(self):
        end = self.bytes.find(b"\0", self.at)
        return self.cut((end if end >= 0 else len(self.bytes)) - self.at + 1)[:-1].decode()


KEYPOINT = np.dtype([("px", "<f8", 2), ("point_id", "<u8")])


def _read_image(data):
    """Name, camera_from_world (qw qx qy qz tx ty tz) and number of observations."""
    pose = data.take("I7dI")[1:8]
    name = data.take_text()
    keypoints = np.frombuffer(data.cut(data.take("Q")[0] * KEYPOINT.itemsize), KEYPOINT)
    no_point = np.iinfo(np.uint64).max
    return name, pose, int(np.count_nonzero(keypoints["point_id"] != no_point))


def read_model(folder):
    """The binary model in a folder. Raises DataError naming the file that is truncated."""
    data = _Bytes(folder / "images.bin")
    images = [_read_image(data) for _ in range(data.take("Q")[0])]
    poses = np.array([pose for _, pose, _ in images]).reshape(-1, 7)
    camera_from_world = rotation_matrices(poses[:, [1, 2, 3, 0]]).reshape(-1, 3, 3)
    rotations = np.transpose(camera_from_world, (0, 2, 1))
    return Model(
        names=[name for name, _, _ in images],
        positions=-np.einsum("nij,nj->ni", rotations, poses[:, 4:]),
        rotations=rotations,
        num_observations=np.array([count for _, _, count in images], dtype=int),
        num_points=_Bytes(folder / "points3D.bin").take("Q")[0],
        size_bytes=sum(path.stat().st_size for path in folder.glob("*.bin")),
    )


def write_posed_images(folder, database, pose_of_name):
    """Writes a text model without points: the database's cameras, and its images that have a pose
    (map_from_camera as rotation and position). Returns the number of images."""
    folder.mkdir(parents=True)
    cameras, images = read_cameras(database), read_images(database)
    lines = [
        f"{i} {MODELS[model][0]} {width} {height} {_numbers(parameters)}\n"
        for i, model, width, height, parameters in cameras
    ]
    (folder / "cameras.txt").write_text("".join(lines), encoding="utf-8")
    lines = []
    for image_id, name, camera_id in images:
        if name in pose_of_name:
            rotation, position = pose_of_name[name]
            x, y, z, w = quaternion(rotation.T)
            pose = _numbers([w, x, y, z, *(-rotation.T @ position)])
            lines.append(f"{image_id} {pose} {camera_id} {name}\n\n")
    (folder / "images.txt").write_text("".join(lines), encoding="utf-8")
    (folder / "points3D.txt").write_text("", encoding="utf-8")
    return len(lines)


def _numbers(values):
    return " ".join(repr(float(value)) for value in values)


def _select(database, sql):
    with contextlib.closing(sqlite3.connect(database)) as connection:
        return connection.execute(sql).fetchall()


def read_cameras(database):
    """Rows (camera_id, model, width, height, parameters)."""
    rows = _select(database, "SELECT camera_id, model, width, height, params FROM cameras")
    result = []
    for *head, blob in rows:
        if head[1] not in MODELS or MODELS[head[1]][1] != len(blob) / 8:
            raise DataError(f"{database}: camera {head[0]} has a model that we do not use")
        result.append((*head, np.frombuffer(blob, "<f8")))
    return result


def replace_cameras(database, before, after):
    """Replaces, in the database, the parameters of each camera in `before` by those at the same index in `after`.
    Both are lists of picture_camera. Other cameras stay unchanged."""
    with contextlib.closing(sqlite3.connect(database)) as connection:
        for old, new in zip(before, after, strict=True):
            (model, old_values), (new_model, new_values) = camera_parameters(old), camera_parameters(new)
            if model != new_model:
                raise DataError(f"{database}: a {model} camera cannot become a {new_model} one")
            blobs = [np.array(values, "<f8").tobytes() for values in (new_values, old_values)]
            connection.execute("UPDATE cameras SET params = ? WHERE params = ?", blobs)
        connection.commit()


def read_images(database):
    """Rows (image_id, name, camera_id)."""
    return _select(database, "SELECT image_id, name, camera_id FROM images ORDER BY image_id")


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
