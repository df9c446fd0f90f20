# SPDX-License-Identifier: Apache-2.0
"""The exported floor plan of a site of two floors: features, GeoJSON, the drawing's text, the archive for nav2."""

import io
import json
import unittest
import zipfile
from unittest import mock

import numpy as np
import yaml

import fake_site
from fake_site import rotation_about
from folder_case import FolderTest
from labels_site import UprightBox, thing_entry, write_configs, write_things
from nightmap_eval.dxf import dxf_text
from nightmap_eval.floor_plan import Feature, floor_at, floor_features, way_features
from nightmap_eval.grid import FREE, OCCUPIED, Grid
from nightmap_eval.polygons import Polygon

FLOORS = [{"number": 0, "height_m": 0.0, "yaml": "map.yaml"}, {"number": 1, "height_m": 3.0, "yaml": "floor_1.yaml"}]
SQUARE = Polygon(np.array([[0.0, 0], [2, 0], [2, 2], [0, 2]]), [np.array([[0.5, 0.5], [0.5, 1], [1, 1]])])


def groups(text):
    """(code, value) of the lines of a DXF file."""
    lines = text.split("\n")
    assert lines.pop() == "" and len(lines) % 2 == 0
    return [(int(code), value) for code, value in zip(lines[::2], lines[1::2])]


def entities(text):
    """Those of a DXF file: dictionaries of code -> all values."""
    pairs = groups(text)
    pairs = pairs[pairs.index((2, "ENTITIES")) + 1 :]
    found = []
    for code, value in pairs[: pairs.index((0, "ENDSEC"))]:
        found += [{}] if code == 0 else []
        found[-1].setdefault(code, []).append(value)
    return found


class FeaturesTest(unittest.TestCase):
    def test_floor_of_a_height(self):
        for z_m, number in ((-5, 0), (0, 0), (1.2, 0), (2.4, 0), (2.6, 1), (4.2, 1), (99, 1)):
            self.assertEqual(floor_at(FLOORS, z_m)["number"], number, z_m)

    def test_way_is_cut_at_the_stairs(self):
        points = np.arange(14.0).reshape(7, 2)
        floors = [FLOORS[i] for i in (0, 0, 0, 1, 1, 0, 1)]
        lines = list(way_features("trajectory", points, floors))
        self.assertEqual([(line.floor, line.height_m, len(line.shape)) for line in lines], [(0, 0, 3), (1, 3, 2)])
        np.testing.assert_array_equal(lines[1].shape, points[3:5])
        self.assertEqual(list(way_features("path", points[:0], [])), [])

    def test_floor_without_anything(self):
        self.assertEqual(list(floor_features(FLOORS[0], Grid(np.zeros((9, 9), np.uint8), 0.1))), [])

    def test_only_the_largest_part_of_a_room_has_the_text(self):
        cells = np.full((60, 60), OCCUPIED, np.uint8)
        cells[2:40, 2:40] = FREE
        cells[20, 20:22] = cells[21, 22] = OCCUPIED
        cells[19, 19:24] = cells[22, 19:24] = OCCUPIED
        cells[20:22, 19] = cells[20:22, 23] = OCCUPIED  # a box on the floor, with free cells in it
        rooms = [feature for feature in floor_features(FLOORS[1], Grid(cells, 0.1)) if feature.kind == "room"]
        self.assertGreater(len(rooms), 1)
        self.assertEqual([bool(room.label) for room in rooms], [True] + [False] * (len(rooms) - 1))
        self.assertEqual({room.figures["area_m2"] for room in rooms}, {rooms[0].figures["area_m2"]})
        self.assertEqual([room.figures["part"] for room in rooms], list(range(1, len(rooms) + 1)))
        self.assertEqual({(room.floor, room.height_m) for room in rooms}, {(1, 3.0)})


class DrawingTest(unittest.TestCase):
    def features(self, **changes):
        room = {"kind": "room", "floor": -1, "height_m": -3.2, "shape": SQUARE, "label": "1: 3.9 m2", "label_m": (1.5, 1.5)}
        return [Feature(**(room | changes)), Feature("path", 0, 0.0, np.array([[0, 0], [1, 1.00001], [5, -1e-9]]))]

    def test_layers_polylines_and_texts(self):
        text = dxf_text(self.features())
        found = entities(text)
        self.assertEqual([(e[0][0], e[8][0]) for e in found],
                         [("LWPOLYLINE", "ROOMS_-1"), ("LWPOLYLINE", "ROOMS_-1"), ("TEXT", "ROOM_TEXT_-1"), ("LWPOLYLINE", "PATH_0")])  # fmt: skip
        self.assertEqual([(e[90][0], e[70][0], e[38][0]) for e in found if 90 in e], [("4", "1", "-3.2000"), ("3", "1", "-3.2000"), ("3", "0", "0.0000")])
        self.assertEqual((found[0][10], found[0][20]), (["0.0000", "2.0000", "2.0000", "0.0000"], ["0.0000", "0.0000", "2.0000", "2.0000"]))
        self.assertEqual(found[3][20], ["0.0000", "1.0000", "0.0000"])  # no negative zero
        self.assertEqual(found[2][1], ["1: 3.9 m2"])
        layers = [pairs[1] for before, pairs in zip(groups(text), groups(text)[1:]) if before == (100, "AcDbLayerTableRecord")]
        self.assertEqual(layers, ["0", "ROOMS_-1", "ROOM_TEXT_-1", "PATH_0"])

    def test_handles_are_unique_and_below_the_seed(self):
        pairs = groups(dxf_text(self.features()))
        seed = pairs[pairs.index((9, "$HANDSEED")) + 1][1]
        handles = [int(value, 16) for code, value in pairs if code == 5 and value != seed]
        self.assertEqual(len(handles), len(set(handles)))
        self.assertLess(max(handles), int(seed, 16))
        owners = {int(value, 16) for code, value in pairs if code in (330, 350)} - {0}
        self.assertLessEqual(owners, set(handles))

    def test_names_cannot_break_the_file(self):
        label = "a\n  0\nEOF\u00e4\U0001f600\x7f"
        text = dxf_text(self.features(kind="thing", label=label))
        self.assertTrue(text.isascii())
        self.assertEqual(entities(text)[2][1], ["a   0 EOF\\U+00E4\\U+D83D\\U+DE00 "])

    def test_nothing_to_draw(self):
        self.assertEqual(entities(dxf_text([])), [])


class ExportTest(FolderTest):
    def setUp(self):
        super().setUp()
        self.site_dir = self.folder / "maps" / "hall"
        write_configs(self.folder / "configs")
        self.enterContext(mock.patch("nightmap_site.site.CONFIGS", self.folder / "configs"))
        fake_site.write_site(self.site_dir)
        self.profile("labels")
        fake_site.write_map(self.site_dir / "grid", "map", fake_site.room_pixels())
        fake_site.write_map(self.site_dir / "grid", "floor_1", fake_site.room_pixels()[:, :40])
        rows = [floor | {"png": "map.png", "distances": "floor_0"} for floor in FLOORS]
        content = {"format": "nightmap floors", "version": 2, "units": "", "floors": rows}
        (self.site_dir / "grid" / "floors.json").write_text(json.dumps(content))

    def profile(self, name):
        (self.site_dir / "config").mkdir(exist_ok=True)
        (self.site_dir / "config" / "profile.toml").write_text(f'profile = "{name}"\nimports = []\n')

    def export(self, code=0):
        out = self.site_dir / "floor_plan" / "plan.geojson"
        result = fake_site.run("export_plan.py", "--site-dir", self.site_dir, "--out", out)
        self.assertEqual(result.returncode, code, result.stderr)
        if code:
            return result.stderr
        self.said = result.stdout
        return json.loads(out.read_text())

    def write_path(self, floor):
        (self.site_dir / "plan").mkdir(exist_ok=True)
        (self.site_dir / "plan" / "path.csv").write_text("x_m,y_m\n0,0\n1,1\n")
        (self.site_dir / "plan" / "path.json").write_text(json.dumps({"floor": floor}))
        (self.site_dir / "plan" / "path.yaml").write_text("header: {}\nposes: []\n")

    def test_features_of_both_floors(self):
        write_things(self.site_dir, thing_entry("sofa_1", "sofa", UprightBox(np.array([1.0, 0, 3.4]), np.array([1, 0.5, 0.4]), 0.3)))
        self.write_path(1)
        plan = self.export()
        self.assertIn("metres in the map frame", plan["nightmap"]["frame"])
        found = [(f["properties"]["kind"], f["properties"]["floor"], f["properties"]["height_m"]) for f in plan["features"]]
        self.assertEqual(found, [("room", 0, 0), ("wall", 0, 0), ("room", 1, 3), ("wall", 1, 3), ("trajectory", 0, 0), ("path", 1, 3), ("thing", 1, 3)])
        room, thing = plan["features"][0], plan["features"][-1]
        self.assertEqual({name: room["properties"][name] for name in ("number", "name", "area_m2", "long_side_m", "short_side_m")},
                         {"number": 1, "name": "room 1", "area_m2": 21.8, "long_side_m": 5.8, "short_side_m": 3.8})  # fmt: skip
        self.assertEqual((thing["properties"]["name"], thing["properties"]["class"], thing["properties"]["area_m2"]), ("sofa_1", "sofa", 2.0))
        corners = np.array(thing["geometry"]["coordinates"][0][:4]) - (1, 0)
        expected = np.array([[-1, -0.5], [1, -0.5], [1, 0.5], [-1, 0.5]]) @ rotation_about([0, 0, 1], 0.3)[:2, :2].T
        np.testing.assert_allclose(corners, expected, atol=1e-4)
        self.assertIn("floor 0: rooms 1, free floor in them 21.8 m2, walls 1\nfloor 1: rooms 1, ", self.said)

    def test_rings_are_closed_and_turn_as_rfc_7946_says(self):
        for feature in self.export()["features"]:
            if feature["geometry"]["type"] == "Polygon":
                for number, ring in enumerate(np.array(ring) for ring in feature["geometry"]["coordinates"]):
                    np.testing.assert_array_equal(ring[0], ring[-1])
                    area = np.sum(ring[:-1, 0] * ring[1:, 1] - ring[1:, 0] * ring[:-1, 1])
                    self.assertEqual(area > 0, number == 0)

    def test_same_bytes_again(self):
        folder = self.site_dir / "floor_plan"
        self.export()
        first = {path.name: path.read_bytes() for path in folder.iterdir()}
        self.assertEqual(set(first), {"plan.geojson", "plan.dxf", "nav2.zip"})
        self.export()
        self.assertEqual({path.name: path.read_bytes() for path in folder.iterdir()}, first)

    def test_archive_has_every_floor(self):
        self.write_path(1)
        self.export()
        archive = zipfile.ZipFile(io.BytesIO((self.site_dir / "floor_plan" / "nav2.zip").read_bytes()))
        self.assertEqual(archive.namelist(), ["map.yaml", "map.pgm", "floor_1.yaml", "floor_1.pgm", "path.yaml", "README.txt"])
        for name in ("map", "floor_1"):
            self.assertEqual(yaml.safe_load(archive.read(f"{name}.yaml"))["image"], f"{name}.pgm")
            self.assertEqual(archive.read(f"{name}.pgm"), (self.site_dir / "grid" / f"{name}.pgm").read_bytes())
        readme = archive.read("README.txt").decode()
        for text in ("floor_1.yaml: floor 1 at 3.00 m, 40 x 40 cells of 0.1 m", "map_server", "{map_url: $PWD/FLOOR.yaml}", "on floor 1"):
            self.assertIn(text, readme)

    def test_path_on_a_floor_that_is_gone(self):
        self.write_path(7)
        self.assertNotIn("path", {f["properties"]["kind"] for f in self.export()["features"]})

    def test_site_without_a_grid(self):
        self.profile("ceiling")
        self.assertIn("makes no grid", self.export(code=1))

    def test_damaged_files_are_named(self):
        for name, text in (("grid/map.pgm", "P5\n9 9\n255\n"), ("grid/floor_1.yaml", "image: [\n"), ("map_frame/trajectory.tum", "1 nan\n")):
            path = self.site_dir / name
            whole = path.read_bytes()
            path.write_text(text)
            self.assertIn(name, self.export(code=1))
            self.assertFalse((self.site_dir / "floor_plan" / "plan.geojson").exists())
            path.write_bytes(whole)


if __name__ == "__main__":
    unittest.main()
