# SPDX-License-Identifier: Apache-2.0
"""`make export`: the mesh with pictures of the small building, as independent readers open it, against pictures that are not on it."""

import csv
import io
import json
import re
import shutil
import struct
import subprocess

import numpy as np
from PIL import Image
from workspace import CAMERA, SITE, SiteTest, Workspace

from nightmap_eval.trajectory import read_tum

TYPES = {5126: "<f4", 5123: "<u2", 5125: "<u4"}
SIZES = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}


class Glb:
    """The primitives of a GLB, by its accessors: dicts of arrays by attribute, with corners and, where there is a page, its pixels."""

    def __init__(self, path):
        content = path.read_bytes()
        (size,) = struct.unpack("<I", content[12:16])
        self.json, self.body = json.loads(content[20 : 20 + size]), content[28 + size :]
        self.primitives = [self.primitive(each) for each in self.json["meshes"][0]["primitives"]]

    def array(self, index):
        accessor = self.json["accessors"][index]
        view = self.json["bufferViews"][accessor["bufferView"]]
        kind, size = np.dtype(TYPES[accessor["componentType"]]), SIZES[accessor["type"]]
        stride = view.get("byteStride", kind.itemsize * size)
        offset = view["byteOffset"] + accessor.get("byteOffset", 0)
        return np.ndarray((accessor["count"], size), kind, self.body, offset, (stride, kind.itemsize))

    def primitive(self, described):
        arrays = {name: self.array(index) for name, index in described["attributes"].items()}
        arrays["corners"] = self.array(described["indices"]).reshape(-1, 3)
        x, y, z = arrays["POSITION"].astype(float).T
        arrays["in_map"] = np.column_stack([x, -z, y])
        texture = self.json["materials"][described["material"]]["pbrMetallicRoughness"].get("baseColorTexture")
        if texture:
            view = self.json["bufferViews"][self.json["images"][self.json["textures"][texture["index"]]["source"]]["bufferView"]]
            arrays["page"] = np.asarray(Image.open(io.BytesIO(self.body[view["byteOffset"] : view["byteOffset"] + view["byteLength"]])))
        return arrays

    def textured(self):
        return [each for each in self.primitives if "page" in each]


def sample(picture, xy):
    """Colors between four pixels each."""
    low = np.clip(np.floor(xy).astype(int), 0, np.array(picture.shape[1::-1]) - 2)
    part = (xy - low)[:, :, None]
    at = lambda right, down: picture[low[:, 1] + down, low[:, 0] + right].astype(float)  # noqa: E731
    upper = at(0, 0) * (1 - part[:, 0]) + at(1, 0) * part[:, 0]
    lower = at(0, 1) * (1 - part[:, 0]) + at(1, 1) * part[:, 0]
    return upper * (1 - part[:, 1]) + lower * part[:, 1]


class ExportTextureTest(SiteTest):
    given = ("export",)

    @classmethod
    def setUpClass(cls):
        cls.work = Workspace.made("map").removed_after(cls)
        cls.work.output("export")
        cls.path = cls.work.path("mesh/mesh_textured.glb")
        cls.glb = Glb(cls.path)

    def test_assimp_finds_all_triangles_pages_and_materials(self):
        self.assertTrue(shutil.which("assimp"), "install assimp-utils: scripts/install_deps.sh")
        result = subprocess.run(["assimp", "info", self.path], text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        self.assertEqual(result.returncode, 0, result.stdout)
        found = {name: int(re.search(rf"(?m)^{re.escape(name)}:\s+(\d+)", result.stdout)[1])
                 for name in ("Meshes", "Faces", "Materials", "Textures (embed.)")}  # fmt: skip
        report = json.loads(self.work.path("mesh/report.json").read_text())
        self.assertEqual(found["Faces"], report["num_triangles"])
        self.assertEqual(found["Textures (embed.)"], report["num_pages"])
        self.assertEqual(found["Meshes"], len(self.glb.primitives))
        self.assertEqual(found["Materials"], len(self.glb.primitives))

    def test_most_triangles_have_a_picture(self):
        report = json.loads(self.work.path("mesh/report.json").read_text())
        num_textured = sum(len(each["corners"]) for each in self.glb.textured())
        self.assertEqual(report["num_textured_triangles"], num_textured)
        self.assertGreater(num_textured, 0.85 * report["num_triangles"])
        for each in self.glb.primitives:
            self.assertLess(each["corners"].max(), len(each["POSITION"]))

    def test_both_meshes_have_the_same_triangles(self):
        plain = Glb(self.work.path("mesh/mesh.glb")).primitives

        def triangles(primitives):
            corners = np.concatenate([np.sort(each["in_map"][each["corners"]], axis=1).reshape(-1, 9) for each in primitives])
            return corners[np.lexsort(corners.T)]

        np.testing.assert_array_equal(triangles(self.glb.primitives), triangles(plain))

    def views(self):
        """Picture, depth and pose of frames that are no keyframes."""
        keyframes = {each["frame_idx"] for tile in self.work.path("tiles").glob("tile_*.json")
                     for each in json.loads(tile.read_text())["keyframes"]}  # fmt: skip
        poses = read_tum(self.work.path("map_frame/trajectory.tum"))
        rotations = poses.rotations()
        at = {int(time_ns): i for i, time_ns in enumerate(poses.times_ns)}
        for shard in sorted(self.work.path("frames").glob("shard_*.csv")):
            for row in csv.DictReader(shard.read_text().splitlines()):
                i = at.get(int(row["time_ns"]))
                if i is None or int(row["frame_idx"]) in keyframes:
                    continue
                color = np.asarray(Image.open(self.work.data().parent / row["color_path"]).convert("RGB"))
                depth = np.asarray(Image.open(self.work.data().parent / row["depth_path"])) / 5000
                yield color, depth, rotations[i], poses.positions_m[i]

    def errors(self, points, rgb):
        """Differences between the colors of points and of the views that see them."""
        found = []
        for color, depth, rotation, position in self.views():
            in_camera = (points - position) @ rotation
            near = in_camera[:, 2] > 0.3
            pixels = in_camera[near, :2] / in_camera[near, 2:] * CAMERA["fx"] + (CAMERA["cx"], CAMERA["cy"])
            inside = np.all((pixels > 1) & (pixels < (CAMERA["width"] - 2, CAMERA["height"] - 2)), axis=1)
            pixels, z, rgb_near = pixels[inside], in_camera[near, 2][inside], rgb[near][inside]
            x, y = np.rint(pixels).astype(int).T
            seen = np.abs(depth[y, x] - z) < 0.02 * z
            found.append(np.abs(sample(color, pixels[seen]) - rgb_near[seen]))
        self.assertGreater(len(found), 4)
        return np.concatenate(found)

    def test_pages_are_nearer_to_other_pictures_than_colors_of_vertices(self):
        textured = self.glb.textured()
        points = np.concatenate([each["in_map"] for each in textured])
        rgb = [sample(each["page"], each["TEXCOORD_0"] * each["page"].shape[1::-1] - 0.5) for each in textured]
        from_pages = self.errors(points, np.concatenate(rgb))
        [plain] = Glb(self.work.path("mesh/mesh.glb")).primitives
        linear = plain["COLOR_0"][:, :3] / 65535
        srgb = 255 * np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
        from_vertices = self.errors(plain["in_map"], srgb)
        self.assertLess(np.mean(from_pages), 0.75 * np.mean(from_vertices))

    def test_bytes_do_not_depend_on_threads(self):
        again = self.work.copy().removed_after(self)
        for folder in ("mesh", "texture_mesh"):
            shutil.rmtree(again.path(folder))
        again.output("export", "THREADS=1")
        self.assertEqual(again.hashes(), self.work.hashes())

    def test_tiles_have_the_same_triangles(self):
        tiled = self.work.copy().removed_after(self)
        tiled.output("export", "SET=tiles.edge_m=6", "-j2")
        self.assertGreater(len(Glb(tiled.path("mesh/mesh_textured.glb")).textured()), 1)
        size = lambda work: len(list(work.path("texture_mesh").glob("tile_*.h5")))  # noqa: E731
        self.assertGreaterEqual(size(tiled), 4)
        tiled.output("export")  # one tile again
        self.assertEqual(size(tiled), size(self.work))
        self.assertEqual(tiled.path("mesh/mesh_textured.glb").read_bytes(), self.path.read_bytes())
