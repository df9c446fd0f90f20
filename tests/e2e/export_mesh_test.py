# SPDX-License-Identifier: Apache-2.0
"""`make export`: the mesh of the small building, as independent readers open it, against the exact surfaces; in tiles as in one."""

import json
import re
import shutil
import struct
import subprocess

import numpy as np
from workspace import SITE, SiteTest, Workspace

from nightmap_eval.dense.cloud_accuracy import cloud_metrics
from nightmap_eval.ply import read_ply  # noqa: E402
from nightmap_eval.trajectory import FRAME_GAP_NS, associate, read_truth, read_tum
from nightmap_eval.trajectory_errors import trajectory_metrics

VERTEX = np.dtype([("position", "<f4", 3), ("normal", "<f4", 3), ("rgb", "u1", 3)])
FACE = np.dtype([("size", "u1"), ("corners", "<i4", 3)])
GLB_VERTEX = np.dtype([("position", "<f4", 3), ("normal", "<f4", 3), ("color", "<u2", 4)])


def ply(path):
    """Vertices and faces by the counts of the header alone."""
    header, body = path.read_bytes().split(b"end_header\n", 1)
    num_vertices, num_faces = (int(re.search(rb"element %b (\d+)" % name, header)[1]) for name in (b"vertex", b"face"))
    vertices = np.frombuffer(body, VERTEX, num_vertices)
    faces = np.frombuffer(body, FACE, num_faces, num_vertices * VERTEX.itemsize)
    return vertices, faces


def glb(path):
    """The description, and the vertices and corners by its accessors."""
    content = path.read_bytes()
    (size,) = struct.unpack("<I", content[12:16])
    description, body = json.loads(content[20 : 20 + size]), content[28 + size :]
    positions, _, _, indices = description["accessors"]
    vertices = np.frombuffer(body, GLB_VERTEX, positions["count"])
    corners = np.frombuffer(body, "<u4", indices["count"], description["bufferViews"][1]["byteOffset"])
    return description, vertices, corners.reshape(-1, 3)


def triangles(path):
    """The positions of the corners of each triangle, in an order that depends on nothing else."""
    vertices, faces = ply(path)
    corners = vertices["position"][faces["corners"]]
    first = np.array([np.lexsort(each.T[::-1])[0] for each in corners])
    turned = np.take_along_axis(corners, ((first[:, None] + np.arange(3)) % 3)[:, :, None], axis=1).reshape(-1, 9)
    return turned[np.lexsort(turned.T)]


class ExportMeshTest(SiteTest):
    given = ("export",)

    @classmethod
    def setUpClass(cls):
        cls.work = Workspace.made("map").removed_after(cls)
        cls.said = cls.work.output("export")
        cls.mesh, cls.glb = cls.work.path("mesh/mesh.ply"), cls.work.path("mesh/mesh.glb")

    def assimp(self, path):
        """The counts that `assimp info` prints."""
        self.assertTrue(shutil.which("assimp"), "install assimp-utils: scripts/install_deps.sh")
        result = subprocess.run(["assimp", "info", path], text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        self.assertEqual(result.returncode, 0, result.stdout)
        return {name: int(re.search(rf"(?m)^{name}:\s+(\d+)", result.stdout)[1]) for name in ("Meshes", "Vertices", "Faces")}

    def test_make_says_where_the_files_are(self):
        self.assertIn(f"maps/{SITE}/mesh", self.said)
        self.assertNotIn("mesh", self.work.output("map"))  # no goal but this one makes it
        report = json.loads(self.work.path("mesh/report.json").read_text())
        vertices, faces = ply(self.mesh)
        self.assertEqual((report["num_vertices"], report["num_triangles"]), (len(vertices), len(faces)))
        self.assertGreater(len(faces), 10000)

    def test_assimp_opens_both(self):
        vertices, faces = ply(self.mesh)
        for path in (self.mesh, self.glb):
            found = self.assimp(path)
            self.assertEqual((found["Meshes"], found["Faces"]), (1, len(faces)))
            self.assertGreaterEqual(found["Vertices"], len(vertices))  # assimp may part vertices, and joins none

    def test_both_files_hold_the_same_mesh(self):
        vertices, faces = ply(self.mesh)
        description, glb_vertices, corners = glb(self.glb)
        np.testing.assert_array_equal(corners, faces["corners"])
        x, y, z = vertices["position"].T
        np.testing.assert_array_equal(glb_vertices["position"], np.column_stack([x, z, -y]))
        position = description["accessors"][0]
        np.testing.assert_array_equal(glb_vertices["position"].min(axis=0), np.float32(position["min"]))
        np.testing.assert_array_equal(glb_vertices["position"].max(axis=0), np.float32(position["max"]))
        self.assertEqual(description["asset"]["version"], "2.0")
        np.testing.assert_allclose(np.linalg.norm(vertices["normal"], axis=1), 1, atol=1e-5)
        self.assertEqual(set(np.unique(faces["size"])), {3})

    def test_faces_are_counterclockwise_from_the_seen_side(self):
        vertices, faces = ply(self.mesh)
        a, b, c = np.moveaxis(vertices["position"][faces["corners"]].astype(float), 1, 0)
        across = np.cross(b - a, c - a)
        self.assertTrue(np.all(np.einsum("ij,ij->i", across, vertices["normal"][faces["corners"]].sum(axis=1)) > 0))

    def test_vertices_lie_on_the_surfaces_of_the_building(self):
        found, truth = read_tum(self.work.path("map_frame/trajectory.tum")), read_truth(self.work.path("frames/ground_truth.tum"))
        pairs = associate(found.times_ns, truth.times_ns, FRAME_GAP_NS)
        rows = np.arange(len(pairs))
        _, building_from_map = trajectory_metrics(found.select(pairs[:, 0]), truth.select(pairs[:, 1]), rows, np.zeros(len(rows), int))
        surfaces = read_ply(self.work.data() / "truth/surfaces.ply")
        mesh = cloud_metrics(ply(self.mesh)[0]["position"].astype(float), building_from_map, *surfaces, max_points=3000)
        cloud = cloud_metrics(read_ply(self.work.path("point_cloud/cloud.ply"))[0], building_from_map, *surfaces, max_points=3000)
        self.assertLess(mesh["surface_distance_median_m"], 1.2 * cloud["surface_distance_median_m"] + 0.001)
        self.assertLess(mesh["surface_distance_p90_m"], 0.02)

    def test_tiles_do_not_show_in_the_mesh(self):
        tiled = self.work.copy().removed_after(self)
        tiled.output("export", "SET=tiles.edge_m=6", "-j2")
        self.assertGreaterEqual(len(list(tiled.path("mesh").glob("tile_*.ply"))), 4)
        np.testing.assert_array_equal(triangles(tiled.path("mesh/mesh.ply")), triangles(self.mesh))
        self.assertEqual(len(ply(tiled.path("mesh/mesh.ply"))[0]), len(ply(self.mesh)[0]))  # seams are welded

    def test_bytes_do_not_depend_on_threads(self):
        again = self.work.copy().removed_after(self)
        for path in (*again.path("mesh").iterdir(), *again.path("texture_mesh").iterdir()):
            path.unlink()
        again.output("export", "THREADS=1")
        self.assertEqual(again.hashes(), self.work.hashes())

    def test_a_damaged_tile_is_refused(self):
        again = self.work.copy().removed_after(self)
        tile = again.path("mesh/tile_0_0.ply")
        tile.write_bytes(tile.read_bytes()[:-1])
        result = again.run("join_meshes", "--in", f"tile=maps/{SITE}/tiles/tile_0_0.json", "--in", f"tile_mesh=maps/{SITE}/mesh/tile_0_0.ply",
                           "--in", f"tile_report=maps/{SITE}/mesh/report_0_0.json", "--in", f"tile_texture=maps/{SITE}/texture_mesh/tile_0_0.h5",
                           "--in", f"texture_report=maps/{SITE}/texture_mesh/report_0_0.json",
                           "--out", "mesh=new.ply", "--out", "glb=new.glb", "--out", "textured=new_textured.glb")  # fmt: skip
        self.assertEqual(result.returncode, 1, result.stdout)
        self.assertIn(f"maps/{SITE}/mesh/tile_0_0.ply: its elements need", result.stdout)
        self.assertFalse((again.folder / "new.ply").exists())
