# SPDX-License-Identifier: Apache-2.0
"""Clouds and small layers of the 3-D view of the report: packed, bounded, the same bytes for the same files, damaged files refused."""

import base64
import json
import unittest
import zlib
from io import BytesIO
from unittest import mock

import numpy as np
from numpy.lib import recfunctions as rfn
from PIL import Image

from folder_case import FolderTest
from nightmap_eval.grid import FREE, OCCUPIED, UNKNOWN
from nightmap_eval.page import scene, scene_cloud, scene_layers
from nightmap_eval.page.scene_cloud import class_cloud, color_cloud, hashes, pack
from nightmap_site.script_errors import DataError

FLOATS, BYTES = ("x", "y", "z", "nx", "ny", "nz"), ("red", "green", "blue")
ROW = np.dtype([*((name, "<f4") for name in FLOATS), *((name, "u1") for name in BYTES), ("label", "<u2")])
KINDS = {"<f4": "float", "|u1": "uchar", "<u2": "ushort"}
POINT_M = 1e-4


def made_up(count, seed=1):
    """Points on the floor and a wall of a hall, with unlike colors."""
    random, rows = np.random.default_rng(seed), np.zeros(count, ROW)
    rows["x"], rows["y"] = random.uniform(-20, 30, count), random.uniform(-5, 5, count)
    on_wall = random.random(count) < 0.4
    rows["z"][on_wall], rows["y"][on_wall] = random.uniform(0, 3, on_wall.sum()), 5
    rows["ny"][on_wall], rows["nz"][~on_wall] = -1, 1
    for name in BYTES:
        rows[name] = random.integers(0, 256, count)
    rows["label"] = random.integers(0, 3, count) * 100
    return rows


def ply(rows):
    fields = "".join(f"property {KINDS[rows.dtype[name].str]} {name}\n" for name in rows.dtype.names)
    return f"ply\nformat binary_little_endian 1.0\nelement vertex {len(rows)}\n{fields}end_header\n".encode() + rows.tobytes()


def unpacked(cloud):
    """Places (n, 3) in metres and values (n, columns), block by block, as scene_data.js unpacks them."""
    data = zlib.decompress(base64.b64decode(cloud.text))
    places = np.frombuffer(data, "<u2", 3 * cloud.num_points).reshape(3, -1).T
    values = np.frombuffer(data, np.uint8, offset=6 * cloud.num_points).reshape(len(cloud.columns), -1).T
    corners = np.repeat([block[:3] for block in cloud.blocks], [block[3] for block in cloud.blocks], axis=0)
    return (corners + places / scene_cloud.PARTS) * cloud.block_m, values


def sorted_rows(array):
    return array[np.lexsort(np.asarray(array).T)]


class CloudTest(FolderTest):
    def file(self, rows, name="cloud.ply"):
        path = self.folder / name
        path.write_bytes(ply(rows))
        return path

    def test_all_points_come_back_where_they_were_with_color_and_side(self):
        rows = made_up(1500)
        cloud = color_cloud(self.file(rows))
        self.assertEqual((cloud.num_points, cloud.num_in_file, cloud.columns), (1500, 1500, ["red", "green", "blue", "facing"]))
        points_m, values = unpacked(cloud)
        truth_m = np.column_stack([rows[axis] for axis in "xyz"]).astype(float)
        nearest = np.linalg.norm(truth_m[:, None] - points_m, axis=2).argmin(axis=1)
        self.assertEqual(len(set(nearest)), 1500)
        self.assertLess(np.linalg.norm(truth_m - points_m[nearest], axis=1).max(), POINT_M)
        np.testing.assert_array_equal(values[nearest, :3], np.column_stack([rows[name] for name in BYTES]))
        np.testing.assert_array_equal(values[nearest, 3], np.where(rows["nz"] == 1, 36 * 6, 36 * 3 + 27))

    def test_classes_are_numbered_as_in_the_legend(self):
        rows = made_up(500)
        cloud = class_cloud(self.file(rows), {0: 0, 100: 1})  # no 200
        self.assertEqual(cloud.columns, ["label", "facing"])
        counts = np.bincount(unpacked(cloud)[1][:, 0], minlength=256)
        self.assertEqual(counts[[0, 1, 255]].tolist(), [np.count_nonzero(rows["label"] == label) for label in (0, 100, 200)])

    def test_the_same_file_gives_the_same_bytes_however_it_is_read(self):
        path = self.file(made_up(5000))
        whole = color_cloud(path)
        with mock.patch.object(scene_cloud, "CHUNK", 7):
            self.assertEqual(color_cloud(path).text, whole.text)
        self.assertEqual(color_cloud(path).head(), whole.head())

    def test_a_large_cloud_is_cut_to_a_uniform_sample(self):
        rows = made_up(40_000)
        path = self.file(rows)
        for most in (1, 1000, 39_999):
            with mock.patch.object(scene_cloud.read_sample, "__defaults__", (most,)):
                cloud = color_cloud(path)
            self.assertLessEqual(cloud.num_points, most)
            self.assertGreaterEqual(cloud.num_points, most - 5 * np.sqrt(most))
            self.assertEqual(cloud.num_in_file, 40_000)
        with mock.patch.object(scene_cloud.read_sample, "__defaults__", (4000,)):
            points_m, _ = unpacked(color_cloud(path))
        shares = [np.mean(points_m[:, 0] < x) for x in (-10, 0, 10, 20)]
        np.testing.assert_allclose(shares, [0.2, 0.4, 0.6, 0.8], atol=0.04)

    def test_the_first_points_of_a_block_are_a_sample_of_it(self):
        rows = made_up(20_000)
        rows["x"] = (rows["x"] + 20) / 50 * 3.9
        rows["y"] = rows["z"] = 0
        rows = rows[np.argsort(rows["x"])]  # as a scanner would write them
        cloud = color_cloud(self.file(rows))
        self.assertEqual(len(cloud.blocks), 1)
        first_m = unpacked(cloud)[0][:1000, 0]
        np.testing.assert_allclose(np.quantile(first_m, [0.25, 0.5, 0.75]), [0.98, 1.95, 2.93], atol=0.25)

    def test_blocks_grow_where_there_would_be_too_many(self):
        points_m = np.random.default_rng(3).uniform(-500, 500, (5000, 3))
        with mock.patch.object(scene_cloud, "MAX_BLOCKS", 100):
            cloud = pack(points_m, np.zeros((5000, 1)), hashes(np.arange(5000)), ("label",), 5000)
        self.assertLessEqual(len(cloud.blocks), 100)
        errors_m = np.abs(sorted_rows(unpacked(cloud)[0])[:, 2] - sorted_rows(points_m)[:, 2])
        self.assertLessEqual(errors_m.max(), cloud.block_m / (2 * scene_cloud.PARTS) * 1.001)

    def test_a_cloud_without_points_is_no_layer(self):
        self.assertIsNone(color_cloud(self.file(made_up(0))))
        self.assertIsNone(class_cloud(self.file(made_up(0)), {}))

    def test_a_cloud_without_normals_has_no_sides(self):
        path = self.file(rfn.repack_fields(made_up(50)[["x", "y", "z", *BYTES]]))
        self.assertEqual(set(unpacked(color_cloud(path))[1][:, 3]), {scene_cloud.NO_FACING})

    def test_damaged_files_are_refused_by_name(self):
        rows = made_up(20)
        good = ply(rows)
        header = good[:good.index(b"end_header")]
        path = self.folder / "cloud.ply"
        far, nan, side = rows.copy(), rows.copy(), rows.copy()
        far["x"][3], nan["y"][19], side["nz"][2] = 1e12, np.nan, np.inf
        for damaged in (b"", b"ply\n", good[:-1], good.replace(b"binary_little", b"binary_big"), good.replace(b" 20\n", b" 99999999999\n"),
                        header.replace(b" red", b" rod") + b"end_header\n" + rows.tobytes(), ply(far), ply(nan), ply(side)):  # fmt: skip
            path.write_bytes(damaged)
            with self.subTest(damaged[-20:]), self.assertRaisesRegex(DataError, "cloud.ply: damaged .*; delete the file and run make again"):
                color_cloud(path)


class LayersTest(FolderTest):
    class NoSite:
        """A site in which nothing was made."""

        def made(self, *_):
            return None

        def has_camera(self):
            return True

    def site_with(self, **files):
        site = self.NoSite()
        site.made = lambda job, output: files.get(f"{job}_{output}")
        return site

    def test_a_site_without_anything_has_no_section(self):
        self.assertIsNone(scene.scene_section(self.NoSite(), {}, None))

    def test_an_octree_that_is_too_large_has_a_sentence_instead(self):
        path = self.folder / "map.bt"
        path.write_bytes(np.random.default_rng(1).bytes(3000))
        texts = {}
        [layer] = scene_layers.octree_layers(self.site_with(join_octrees_bt=path), texts)
        self.assertEqual(zlib.decompress(base64.b64decode(texts[layer["text"]])), path.read_bytes())
        with mock.patch.object(scene_layers, "MAX_OCTREE_TEXT", 1000):
            [layer] = scene_layers.octree_layers(self.site_with(join_octrees_bt=path), {})
        self.assertEqual(layer["kind"], "absent")
        self.assertIn("too large", layer["title"])

    def test_a_page_stays_below_its_bound(self):
        """Two clouds, an octree, grids and numbers of lines grow with a site; zlib may save nothing."""
        clouds = (10 * scene_cloud.MAX_POINTS + 8 * scene_cloud.MAX_LABELLED) * 4 / 3
        grids = scene_layers.MAX_FLOORS * scene_layers.MAX_GRID_TEXT
        numbers = 10 * (3 * scene_layers.MAX_WAY + 6 * scene_layers.MAX_VIEWS + 2 * 6 * scene_layers.MAX_LOOPS + 9 * scene_layers.MAX_THINGS)
        self.assertLess(clouds + scene_layers.MAX_OCTREE_TEXT + grids + numbers, 42e6)

    def test_markup_in_names_cannot_end_the_script(self):
        text = scene.in_script({"name": "</script><!--<script>"})
        self.assertNotIn("<", text)
        self.assertEqual(json.loads(text), {"name": "</script><!--<script>"})

    def test_the_picture_of_a_grid_has_its_states_and_the_top_row_first(self):
        cells = np.full((3, 5), UNKNOWN, np.uint8)
        cells[0, 0], cells[2, 4] = FREE, OCCUPIED
        shown, covered = self.picture(cells)
        self.assertEqual((shown.size, covered), ((5, 3), (3, 5)))
        self.assertEqual([shown.getpixel(at) for at in ((0, 2), (4, 0), (1, 1))], [scene_layers.RGBA[state] for state in (FREE, OCCUPIED, UNKNOWN)])

    def picture(self, cells):
        text, covered = scene_layers.grid_picture(cells)
        return Image.open(BytesIO(base64.b64decode(text.partition(",")[2]))), covered

    def test_walls_stay_in_the_smaller_picture_of_a_large_grid(self):
        cells = np.full((300, 5000), FREE, np.uint8)
        cells[100, 1234] = OCCUPIED
        shown, covered = self.picture(cells)
        self.assertEqual((shown.size, covered), ((1667, 100), (300, 5001)))
        self.assertEqual(shown.getpixel((1234 // 3, 99 - 100 // 3)), scene_layers.RGBA[OCCUPIED])

    def test_the_picture_of_a_grid_without_order_is_coarser(self):
        cells = np.random.default_rng(1).integers(0, 3, (300, 300)).astype(np.uint8)
        with mock.patch.object(scene_layers, "MAX_GRID_TEXT", 10_000):
            shown, covered = self.picture(cells)
            self.assertLessEqual(len(scene_layers.grid_picture(cells)[0]), 10_000 + len("data:image/png;base64,"))
        self.assertIn(shown.width, (150, 75))
        self.assertEqual(covered, (300, 300))

    def test_without_three_the_section_tells_the_remedy(self):
        path = self.folder / "map.bt"
        path.write_bytes(b"x")
        with mock.patch.object(scene, "THREE", self.folder / "none"):
            section = scene.scene_section(self.site_with(join_octrees_bt=path), {}, None)
        self.assertRegex(section, "libjs-three: run make deps")
        self.assertNotIn("<script", section)


if __name__ == "__main__":
    unittest.main()
