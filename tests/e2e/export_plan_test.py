# SPDX-License-Identifier: Apache-2.0
"""make export: the floor plan of the small building, opened by GDAL, zipfile, PyYAML and PIL."""
import io
import json
import re
import unittest
import zipfile

import numpy as np
import yaml
from PIL import Image

from workspace import CopiedSiteTest, read_csv, said_by

PLAN = ("START=picture:small/rgb/000006.jpg", "GOAL=picture:small/rgb/000055.jpg")
RESULTS = ("plan.geojson", "plan.dxf", "nav2.zip")


class ExportPlanTest(CopiedSiteTest):
    made = ("map",)

    def export(self, *arguments):
        said = self.make("export", *arguments)
        self.assertIn("floor_plan", said)
        return [(self.work.path(f"floor_plan/{name}")).read_bytes() for name in RESULTS]

    def gdal(self, name, sql):
        """Rows of a query of SpatiaLite's dialect on a file, as dictionaries of texts."""
        said = said_by(["ogrinfo", "-q", "-dialect", "sqlite", "-sql", sql, name], self.work.path("floor_plan"))
        rows = [dict(re.findall(r"^  (\S+) \([^)]*\) = (.*)$", row, re.M)) for row in said.split("OGRFeature(")[1:]]
        self.assertTrue(rows, said)
        return rows

    def extent(self, name):
        said = said_by(["ogrinfo", "-al", "-so", name], self.work.path("floor_plan"))
        numbers = re.search(r"Extent: \((\S+), (\S+)\) - \((\S+), (\S+)\)", said).groups()
        return np.array(numbers, dtype=float).reshape(2, 2)

    def test_gdal_reads_the_plan(self):
        self.make("plan", *PLAN)
        self.export()
        keys = yaml.safe_load(self.work.path("grid/map.yaml").read_text())
        cells = np.array(Image.open(self.work.path("grid/map.pgm")))
        low = np.array(keys["origin"][:2])
        high = low + np.array(cells.shape[::-1]) * keys["resolution"]
        self.assertEqual(keys["origin"][2], 0)
        for name in RESULTS[:2]:
            least, most = self.extent(name)
            self.assertTrue((least >= low - 1e-3).all() and (most <= high + 1e-3).all(), (name, least, most, low, high))
            self.assertTrue((most - least > 0.8 * (high - low)).all(), name)
        kinds = {row["kind"]: row for row in self.gdal("plan.geojson", "select kind, count(*) as num, sum(st_area(geometry)) as area, "
                 "sum(area_m2) as said, min(st_isvalid(geometry)) as valid, sum(st_length(geometry)) as length from plan group by kind")}  # fmt: skip
        self.assertEqual(set(kinds), {"room", "wall", "trajectory", "path"})
        self.assertEqual({row["valid"] for row in kinds.values()}, {"1"})
        cell_m2 = keys["resolution"] ** 2
        for kind, value in (("room", 254), ("wall", 0)):
            counted_m2 = np.count_nonzero(cells == value) * cell_m2
            self.assertAlmostEqual(float(kinds[kind]["area"]), counted_m2, delta=0.12 * counted_m2)
            self.assertAlmostEqual(float(kinds[kind]["area"]), float(kinds[kind]["said"]), delta=0.05 * counted_m2)
        path = json.loads(self.work.path("plan/path.json").read_text())
        self.assertAlmostEqual(float(kinds["path"]["length"]), path["length_m"], delta=0.01)
        self.check_drawing(kinds)

    def check_drawing(self, kinds):
        layers = {row["Layer"]: row for row in self.gdal("plan.dxf", "select Layer, count(*) as num, min(st_isclosed(geometry)) as closed "
                  "from entities group by Layer")}  # fmt: skip
        self.assertEqual(set(layers), {"WALLS_0", "ROOMS_0", "ROOM_TEXT_0", "TRAJECTORY_0", "PATH_0"})
        self.assertEqual((layers["WALLS_0"]["closed"], layers["ROOMS_0"]["closed"], layers["PATH_0"]["closed"]), ("1", "1", "0"))
        content = json.loads(self.work.path("floor_plan/plan.geojson").read_text())
        rings = sum(len(f["geometry"]["coordinates"]) for f in content["features"] if f["properties"]["kind"] == "wall")
        self.assertEqual(int(layers["WALLS_0"]["num"]), rings)
        self.assertEqual(len(content["features"]), sum(int(row["num"]) for row in kinds.values()))
        texts = {row["Text"] for row in self.gdal("plan.dxf", "select Text from entities where Layer = 'ROOM_TEXT_0'")}
        rooms = [f["properties"] for f in content["features"] if f["properties"]["kind"] == "room" and f["properties"]["part"] == 1]
        self.assertEqual(texts, {f"{room['number']}: {room['area_m2']:.1f} m2" for room in rooms})
        self.assertIn("$INSUNITS\n 70\n6\n", self.work.path("floor_plan/plan.dxf").read_text())

    def test_archive_for_nav2(self):
        archive = zipfile.ZipFile(io.BytesIO(self.export()[2]))
        self.assertIsNone(archive.testzip())
        self.assertEqual(archive.namelist(), ["map.yaml", "map.pgm", "README.txt"])
        self.assertEqual({entry.date_time for entry in archive.infolist()}, {(1980, 1, 1, 0, 0, 0)})
        keys = yaml.safe_load(archive.read("map.yaml"))
        picture, here = Image.open(archive.open(keys["image"])), Image.open(self.work.path("grid/map.pgm"))
        np.testing.assert_array_equal(np.array(picture), np.array(here))
        self.assertIn("map_server", archive.read("README.txt").decode())
        self.make("plan", *PLAN)
        archive = zipfile.ZipFile(io.BytesIO(self.export()[2]))
        path = yaml.safe_load(archive.read("path.yaml"))
        self.assertEqual(len(path["poses"]), len(read_csv(self.work.path("plan/path.csv"))))
        self.assertIn("path.yaml", archive.read("README.txt").decode())

    def test_written_when_something_changed_and_with_the_same_bytes(self):
        first = self.export()
        self.assertEqual(self.work.make("-q", "export").returncode, 0)
        before = self.work.runs()
        self.work.path("floor_plan/plan.dxf").unlink()
        self.assertEqual(self.work.make("-q", "export").returncode, 1)
        self.assertEqual(self.export(), first)
        self.assertEqual(self.work.runs(), before)  # no job of the map ran
        self.make("plan", *PLAN)
        self.assertEqual(self.work.make("-q", "export").returncode, 1)
        self.assertNotEqual(self.export(), first)
        self.assertEqual(self.work.make("-q", "map").returncode, 0)

    def test_damaged_grid_is_named(self):
        self.export()
        path = self.work.path("grid/map.pgm")
        path.write_bytes(path.read_bytes()[:-100])
        self.work.path("floor_plan/plan.geojson").unlink()
        said = said_by(["scripts/export_plan.py", "--site-dir", self.work.path(""), "--out", self.work.path("floor_plan/plan.geojson")],
                       self.work.folder, code=1)  # fmt: skip
        self.assertIn("grid/map.pgm", said)
        self.assertFalse(self.work.path("floor_plan/plan.geojson").exists())

    def test_profile_without_a_grid_says_so(self):
        said = self.make("export", "PROFILE=ceiling", code=2)
        self.assertIn("it needs an occupancy grid", said)


if __name__ == "__main__":
    unittest.main()
