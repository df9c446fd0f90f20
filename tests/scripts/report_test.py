# SPDX-License-Identifier: Apache-2.0
"""report.py on site folders with more and fewer of their parts."""

import base64
import json
import re
import unittest
from html.parser import HTMLParser

import numpy as np
from PIL import Image

import fake_site
from folder_case import FolderTest, SiteFolderTest
from nightmap_eval import html
from nightmap_eval.page.layers import plan_parts
from nightmap_eval.report_map import building_rows, cloud_section, truth_in_map
from nightmap_eval.report_plan import narrow_lines, no_path_parts, notes
from nightmap_eval.shown_queries import choose
from nightmap_site.receipts import Hashes
from nightmap_site.script_errors import DataError
from nightmap_site.site import Site

VOID_TAGS = ("meta", "img", "input")


class Checker(HTMLParser):
    """Fails on tags that do not nest."""

    def __init__(self):
        super().__init__()
        self.open, self.sources = [], []

    def handle_starttag(self, tag, attributes):
        self.sources += [value for name, value in attributes if name in ("src", "href")]
        if tag not in VOID_TAGS:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open and self.open.pop() == tag, f"</{tag}> does not close its tag"


class StaleTest(SiteFolderTest):
    """Notes on a path that is not the one asked for last."""

    def setUp(self):
        for name in ("plan", "grid", "logs", "config"):
            (self.site_dir / name).mkdir(parents=True)
        self.grid = self.site_dir / "grid" / "map.pgm"
        self.grid.write_bytes(b"cells")
        self.log, self.config = self.site_dir / "logs" / "plan.log", self.site_dir / "config" / "plan.toml"
        self.log.write_text("10:00:00 info plan: done in 0.1 s\n")
        self.write_receipt('start = "1,1"\ngoal = ""\n')

    def write_receipt(self, config):
        # A receipt of a run in a folder that was moved since.
        receipt = {"inputs": [{"name": "map.pgm", "path": "was/office/grid/map.pgm", "xxh3": Hashes().of(self.grid)}],
                   "outputs": [{"name": "report.json", "path": "was/office/plan/report.json", "xxh3": "0"}],
                   "config": config}  # fmt: skip
        (self.site_dir / "plan" / "receipt.json").write_text(json.dumps(receipt))

    def notes(self):
        return notes(Site(self.site_dir), "plan", "path")

    def test_nothing_is_said_of_a_path_that_is_up_to_date(self):
        self.config.write_text('start = "1,1"\ngoal = ""\n')
        self.assertEqual(self.notes(), [])
        self.config.write_text('start = ""\n')  # a report without START does not ask for another path
        self.assertEqual(self.notes(), [])

    def test_a_run_that_failed_is_told_with_its_reason(self):
        self.log.write_text("10:00:00 info plan: nightmap\n10:00:01 error plan: goal is in a wall\n"
                            "nightmap: plan failed, exit code 3\n")
        [note] = self.notes()
        self.assertIn("failed, the path shown here is of an earlier run: goal is in a wall", note)
        (self.site_dir / "plan" / "receipt.json").unlink()
        [note] = self.notes()
        self.assertIn("there is no path: goal is in a wall", note)
        self.log.write_bytes(b"\xff\nnightmap: plan failed, exit code 137\n")
        self.assertIn("exit code 137, see plan.log", self.notes()[0])

    def test_a_grid_that_changed_since_is_told(self):
        self.grid.write_bytes(b"other cells")
        [note] = self.notes()
        self.assertIn("grid/map.pgm changed since. Run make plan", note)

    def test_other_ends_in_the_configs_are_told(self):
        self.config.write_text('start = "2,2"\ngoal = ""\n')
        [note] = self.notes()
        self.assertIn("(start = 2,2). Run make plan", note)

    def test_a_damaged_receipt_is_named(self):
        for text in ("[]", "{}", "", '{"inputs": 5, "outputs": []}', '{"inputs": [], "outputs": []}', "[" * 100000):
            (self.site_dir / "plan" / "receipt.json").write_text(text)
            with self.assertRaisesRegex(DataError, "plan/receipt.json.*delete the file and run make"):
                self.notes()


class FloorsTest(FolderTest):
    def floor_of_path(self, floor):
        """The floor that the path of a site with two floors is drawn on."""
        for name in ("map", "floor_1"):
            fake_site.write_map(self.folder / "grid", name, fake_site.room_pixels())
        floors = [{"number": 0, "height_m": 0.0, "yaml": "map.yaml"},
                  {"number": 1, "height_m": 2.9, "yaml": "floor_1.yaml"}]  # fmt: skip
        self.write("grid/floors.json", json.dumps({"format": "nightmap floors", "version": 2, "floors": floors}))
        self.write("plan/path.csv", "x_m,y_m\n0,0\n1,1\n")
        self.write("plan/path.json", json.dumps(floor))
        drawn, *_ = plan_parts(Site(self.folder), None)
        self.assertEqual(re.findall(r'data-layer="grid" data-floor="(\d)"', drawn), ["0", "1"])
        return re.findall(r'data-layer="planned path" data-floor="(\d)"', drawn)

    def test_the_path_is_on_its_floor(self):
        self.assertEqual(self.floor_of_path({"floor": 1}), ["1"])
        self.assertEqual(self.floor_of_path({"floor": 0}), ["0"])
        self.assertEqual(self.floor_of_path({}), ["0"])  # of an earlier version
        with self.assertRaisesRegex(DataError, "path.json: floor: 'top' is not of type int"):
            self.floor_of_path({"floor": "top"})


class PathNotesTest(FolderTest):
    def test_narrow_places_are_told_and_a_failed_plan_is_shown(self):
        place = {"first_point": 3, "last_point": 8, "length_m": 0.25, "x_m": 1.5, "y_m": -2.0, "room_m": -1e-12}
        line, = narrow_lines({"narrow_places": [place]})
        self.assertRegex(line, r"narrow for 0.25 m: at \(1.50, -2.00\) only 0.0 cm")
        self.assertEqual(list(narrow_lines({})), [])
        (self.folder / "plan").mkdir()
        self.assertEqual(no_path_parts(Site(self.folder)), [])
        (self.folder / "plan" / "no_path.png").write_bytes(b"picture")
        text, picture = map(str, no_path_parts(Site(self.folder)))
        self.assertIn("found no path", text)
        self.assertIn(base64.b64encode(b"picture").decode(), picture)


class CloudSectionTest(FolderTest):
    def test_has_the_range_of_tiles_and_the_shares_of_the_site(self):
        self.assertIsNone(cloud_section(Site(self.folder)))
        for tile, thickness_m in (("0_0", 0.004), ("0_1", 0.0065)):
            report = {"plane_thickness_median_m": thickness_m, "num_held_out_rays": 10}
            self.write(f"point_cloud/report_{tile}.json", json.dumps(report))
        self.write("point_cloud/report.json", json.dumps({"held_out_rays_agreeing_percent": 97.5}))
        section = str(cloud_section(Site(self.folder)))
        self.assertIn("0.4 to 0.65", section)
        self.assertIn("97.5", section)
        self.assertNotIn("blocks", section)


class ReportTest(SiteFolderTest):
    def report(self):
        page = super().report()
        checker = Checker()
        checker.feed(page)
        self.assertEqual(checker.open, [])
        for source in checker.sources:
            self.assertRegex(source, r"^(data:|#|\.\./)", "the page must not load anything, and leads to its own folder")
        return page

    def write_everything(self):
        estimate = fake_site.write_site(self.site_dir)
        for stage in ("frames", "pose_graph", "map_frame"):
            fake_site.write_receipt(self.site_dir, stage)
        fake_site.write_receipt(self.site_dir, "features", "receipt_0000.json")
        fake_site.write_receipt(self.site_dir, "features", "receipt_0001.json")
        for name, count in (("0000", 3), ("0001", 4)):
            report = {"stage": "features", "num_features": count, "num_skipped": 1, "skipped": [f"rgb/<{name}>.png is truncated"]}
            self.write(f"features/report_{name}.json", json.dumps(report))
        self.write("pose_graph/loops.csv", "frame_a,frame_b,status,reason\n0,39,accepted,\n3,20,rejected,inconsistent\n")
        fake_site.write_map(self.site_dir / "grid", "map", fake_site.room_pixels())
        self.write("plan/path.csv", "x_m,y_m\n0,0\n1,1\n")
        fake_site.write_queries(self.site_dir, estimate.select(range(3)), 2)
        (self.folder / "queries").mkdir()
        Image.new("RGB", (64, 48), "red").save(self.folder / "queries" / "0.png")
        self.write("config/grid.toml", "resolution_m = 0.05\n")

    def test_whole_site(self):
        self.write_everything()
        self.metrics()
        page = self.report()
        for text in ("<dd>40 of 40 over", "<dt>loops</dt><dd>1 accepted, 1 rejected", "<dt>items skipped</dt><dd>2<", "<dd>3 of 5",
                     "<dd>62.5 s of all jobs, 512 MiB at most", "num_features 7", "inconsistent", "rgb/&lt;0000&gt;.png is truncated",
                     "resolution_m = 0.05", "data:image/jpeg", "no picture", "made 2000-01-01 00:00:00 UTC", "map_frame/trajectory.tum</a>"):  # fmt: skip
            self.assertIn(text, page)
        self.assertEqual(page.count('="data:image/png'), 2)  # the grid, and the errors

    def test_shows_the_drive_if_there_is_one(self):
        self.write_everything()
        self.assertNotIn("Simulated drive", self.report())
        (self.site_dir / "drive").mkdir()
        Image.new("RGB", (64, 48), "red").save(self.site_dir / "drive" / "drive.gif")
        drive = {"duration_s": 61.25, "length_m": 20.5, "path_length_m": 21.0, "max_deviation_m": 0.123,
                 "min_clearance_m": 0.3, "robot_radius_m": 0.25, "position_error_m": 0.004, "heading_error_deg": 0.5}
        figures = self.write("drive/drive.json", json.dumps(drive))
        page = self.report()
        for text in ("data:image/gif", "61.2", "12.3", "Position error at the goal"):
            self.assertIn(text, page)
        del drive["duration_s"]
        figures.write_text(json.dumps(drive))
        self.check_refused("report.py", "drive.json: no 'duration_s'")

    def test_same_bytes_twice(self):
        self.write_everything()
        first = self.report()
        self.assertEqual(self.report(), first)

    def test_renders_whatever_is_missing(self):
        self.site_dir.mkdir(parents=True)
        self.assertIn("map_frame stage did not run", self.report())
        self.write_everything()
        folders = {path.name: path for path in self.site_dir.iterdir() if path.is_dir()}
        for name in sorted(set(folders) - {"frames", "pose_graph", "map_frame"}):  # without these there is no trajectory
            folders[name].rename(self.site_dir / f"{name}_away")
            with self.subTest(name):
                self.report()
        page = self.report()
        for missing in ("localize stage", "grid stage", "evaluate step"):
            self.assertIn(f"The {missing} did not run", page)

    def test_warns_of_a_floor_that_may_be_none(self):
        fake_site.write_site(self.site_dir)
        path = self.site_dir / "map_frame" / "report.json"
        said = "z = 0 is the lowest points, 1.20 m below the median camera"
        path.write_text(json.dumps({"floor": said, "floor_warnings": ["no floor was seen: <remedy>"]}))
        page = self.report()
        self.assertIn(said, page)
        self.assertIn('class="failed">Warning: no floor was seen: &lt;remedy&gt;', page)
        path.write_text(json.dumps({"floor": said, "floor_warnings": []}))
        self.assertNotIn("Warning: no floor", self.report())

    def test_warns_of_a_sensor_that_is_mounted_otherwise(self):
        fake_site.write_site(self.site_dir)
        path = self.site_dir / "pose_graph" / "report.json"
        report = json.loads(path.read_text()) if path.exists() else {}
        wheels = {"sensor": "wheels", "warnings": ["wheels: its clock is 0.050 s late"]}
        path.write_text(json.dumps({**report, "sensors": [wheels, {"sensor": "laser"}]}))
        self.assertIn('class="failed">Warning: wheels: its clock is 0.050 s late', self.report())
        path.write_text(json.dumps({**report, "sensors": [{**wheels, "warnings": []}]}))
        self.assertNotIn("Warning: wheels", self.report())

    def test_site_without_truth_says_so(self):
        fake_site.write_site(self.site_dir, truth=False)
        self.metrics()
        self.assertIn("no ground truth", self.report())

    def test_truth_is_drawn_over_the_estimate(self):
        estimate = fake_site.write_site(self.site_dir)
        drawn = truth_in_map(Site(self.site_dir), self.metrics())
        np.testing.assert_allclose(drawn.positions_m, estimate.positions_m, atol=1e-6)

    def test_missing_site_is_an_error(self):
        self.check_refused("report.py", "make map")


class BuildingRowsTest(unittest.TestCase):
    def test_each_floor_has_its_rows(self):
        floors = [
            {"height_m": 0.0, "found": True, "seen_right_percent": 99.0, "walls_closed_percent": 100.0},
            {"height_m": 2.9, "found": False},
        ]
        rows = dict(building_rows({"grid": floors[0] | {"floors": floors}}))
        self.assertEqual(rows["Floor at 0.0 m: Seen cells right within one cell (%)"], 99.0)
        self.assertEqual(rows["Floor at 0.0 m: Walls in the grid that no free cells lead through (%)"], 100.0)
        self.assertEqual(rows["Floor at 2.9 m: in the map"], "no")
        [row] = building_rows({"grid": {"height_m": 0.0, "seen_right_percent": 98.0}})
        self.assertEqual(row, ["Seen cells right within one cell (%)", 98.0])


class PiecesTest(unittest.TestCase):
    def test_text_is_escaped(self):
        self.assertIn("&lt;b&gt;", html.table(("x",), [("<b>",)]))
        self.assertNotIn("<b>", html.paragraph("<b>"))
        self.assertNotIn("<b>", html.section("<b>", "<b>"))

    def test_choice_of_queries_keeps_failures_and_the_worst(self):
        rows = [{"query_idx": i, "status": "located"} for i in range(40)]
        for i, row in enumerate(rows):
            row["translation_error_cm"] = float(i % 7)
        rows[3] = {"query_idx": 3, "status": "failed"}
        rows[11]["translation_error_cm"] = 99.0
        chosen = choose(rows, 12)
        self.assertEqual(len(chosen), 12)
        self.assertTrue({3, 11} <= {row["query_idx"] for row in chosen})
        self.assertEqual(len({row["query_idx"] for row in chosen}), 12)
        self.assertEqual(choose([], 12), [])

    def test_numbers(self):
        self.assertEqual(html.number(None), "n/a")
        self.assertEqual(html.number(12345), "12345")
        self.assertIsNotNone(re.fullmatch(r"0\.123", html.number(0.12345)))
