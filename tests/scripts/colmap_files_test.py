# SPDX-License-Identifier: Apache-2.0
"""COLMAP's models and databases: what is read, written and refused."""

import os
import sqlite3
import subprocess
import sys

import numpy as np

import fake_colmap
from fake_site import SCRIPTS, walk
from folder_case import FolderTest
from nightmap_eval.colmap.colmap_files import (
    camera_parameters,
    read_cameras,
    read_model,
    replace_cameras,
    write_posed_images,
)
from nightmap_eval.pictures import picture_camera
from nightmap_eval.trajectory import rotation_matrices
from nightmap_site.script_errors import DataError


class ColmapFilesTest(FolderTest):
    def test_reads_poses_names_and_counts_of_a_model(self):
        names = [f"a/{i}.png" for i in range(len(walk()))]
        fake_colmap.write_model(self.folder / "0", names, walk(), num_observations=17)
        model = read_model(self.folder / "0")
        self.assertEqual(model.names, names)
        np.testing.assert_allclose(model.positions, walk().positions_m, atol=1e-12)
        np.testing.assert_allclose(model.rotations, walk().rotations(), atol=1e-12)
        np.testing.assert_array_equal(model.num_observations, 17)
        self.assertEqual(model.num_points, 3)
        self.assertEqual(model.size_bytes, sum(p.stat().st_size for p in (self.folder / "0").iterdir()))

    def test_refuses_a_truncated_model(self):
        fake_colmap.write_model(self.folder / "0", ["a.png", "b.png"], walk(2))
        path = self.folder / "0" / "images.bin"
        whole = path.read_bytes()
        for size in (4, 30, 75, len(whole) - 1):
            path.write_bytes(whole[:size])
            with self.assertRaisesRegex(DataError, "images.bin: truncated"):
                read_model(self.folder / "0")

    def test_camera_models_and_the_half_pixel(self):
        camera = {"fx": 500, "fy": 501, "cx": 9.5, "cy": 7.5}
        camera |= dict.fromkeys(("k1", "k2", "p1", "p2", "k3"), 0)
        self.assertEqual(camera_parameters(camera), ("PINHOLE", [500, 501, 10, 8]))
        model, parameters = camera_parameters(camera | {"k3": 0.5})
        self.assertEqual((model, parameters[4:]), ("FULL_OPENCV", [0, 0, 0, 0, 0.5, 0, 0, 0]))
        camera |= {"k1": 1, "k2": 2, "k3": 3, "k4": 4, "k5": 5, "k6": 6, "lens": "pinhole"}
        model, parameters = camera_parameters(camera)
        self.assertEqual((model, parameters[4:]), ("FULL_OPENCV", [1, 2, 0, 0, 3, 4, 5, 6]))
        model, parameters = camera_parameters(camera | {"lens": "fisheye", "k5": 0, "k6": 0})
        self.assertEqual((model, parameters[4:]), ("OPENCV_FISHEYE", [1, 2, 3, 4]))

    def test_the_camera_of_a_picture_that_stages_see_smaller(self):
        color = {"width": 40, "height": 30, "fx": 50, "fy": 51, "cx": 19.5, "cy": 10, "k1": 0.1}
        self.assertEqual(picture_camera({"color": color}), color)
        stored = picture_camera({"color": color, "picture_width": 80, "picture_height": 90})
        self.assertEqual(stored, {"width": 80, "height": 90, "fx": 100, "fy": 153, "cx": 39.5, "cy": 31, "k1": 0.1})

    def test_posed_images_have_the_ids_of_the_database(self):
        database = self.folder / "database.db"
        fake_colmap.write_database(database, ["a.png", "b.png", "c.png"])
        poses = dict(zip(("c.png", "a.png"), zip(walk(5).rotations(), walk(5).positions_m)))
        self.assertEqual(write_posed_images(self.folder / "posed", database, poses), 2)
        lines = (self.folder / "posed" / "images.txt").read_text().splitlines()
        self.assertEqual(lines[1::2], ["", ""])
        words = lines[2].split()
        self.assertEqual((words[0], words[8:]), ("3", ["1", "c.png"]))
        w, x, y, z, *translation = map(float, words[1:8])
        camera_from_map = rotation_matrices([[x, y, z, w]])[0]
        np.testing.assert_allclose(-camera_from_map.T @ translation, walk(5).positions_m[0], atol=1e-12)
        cameras = (self.folder / "posed" / "cameras.txt").read_text()
        self.assertEqual(cameras, "1 PINHOLE 640 480 500.0 501.0 320.0 240.0\n")
        self.assertEqual((self.folder / "posed" / "points3D.txt").read_text(), "")

    def test_names_are_written_as_utf_8(self):
        database = self.folder / "database.db"
        fake_colmap.write_database(database, ["büro.png"])
        program = (
            "import sys; from pathlib import Path; from numpy import eye, zeros\n"
            "from nightmap_eval.colmap.colmap_files import write_posed_images\n"
            "root = Path(sys.argv[1])\n"
            "write_posed_images(root / 'posed', root / 'database.db', {'b\\xfcro.png': (eye(3), zeros(3))})\n"
        )
        plain = os.environ | {"LC_ALL": "C", "PYTHONCOERCECLOCALE": "0", "PYTHONPATH": str(SCRIPTS)}
        subprocess.run([sys.executable, "-X", "utf8=0", "-c", program, self.folder], env=plain, check=True)
        self.assertIn("büro.png".encode(), (self.folder / "posed" / "images.txt").read_bytes())

    def test_only_the_cameras_named_are_replaced(self):
        database = self.folder / "database.db"
        fake_colmap.write_database(database, ["a.png"])
        given = {"fx": 500, "fy": 501, "cx": 319.5, "cy": 239.5} | dict.fromkeys(("k1", "k2", "p1", "p2", "k3"), 0)
        others = {"fx": 400}, {"fx": 450}
        replace_cameras(database, [given | others[0]], [given | others[1]])
        self.assertEqual(read_cameras(database)[0][4].tolist(), [500, 501, 320, 240])
        replace_cameras(database, [given | others[0], given], [given | others[1], given | {"fx": 490, "fy": 491}])
        self.assertEqual(read_cameras(database)[0][4].tolist(), [490, 491, 320, 240])
        with self.assertRaisesRegex(DataError, "PINHOLE camera cannot become a FULL_OPENCV"):
            replace_cameras(database, [given], [given | {"k1": 0.1}])

    def test_refuses_cameras_we_did_not_give(self):
        database = self.folder / "database.db"
        fake_colmap.write_database(database, [])
        connection = sqlite3.connect(database)
        connection.execute("UPDATE cameras SET model = 2")
        connection.commit()
        connection.close()
        with self.assertRaisesRegex(DataError, "database.db: camera 1"):
            read_cameras(database)
