# SPDX-License-Identifier: Apache-2.0
"""The page's first screen and its parts: the plan with layers, fields per place, where to look, files, and what changed since the run before."""

import json
import re
import unittest

import numpy as np

import fake_site
from folder_case import SiteFolderTest
from nightmap_eval.grid import FREE, Grid
from nightmap_eval.laser.report_laser import objects_of
from nightmap_eval.page import changes
from nightmap_eval.page.fields import Cells, Field, fields
from nightmap_eval.page.files import opened_by, size_text
from nightmap_eval.page.floor_map import Layer, Plan, area, drawing, raster, thinned
from nightmap_eval.page.layers import plan_parts
from nightmap_eval.page.places import bad_parts, places_to_look_at
from nightmap_eval.sealed_hdf5 import sealed
from nightmap_eval.trajectory import Trajectory
from nightmap_site.script_errors import DataError
from nightmap_site.site import Site

PLACES = "x_m,y_m,z_m,num_flat,thickness_m,num_rays,num_rays_agreeing\n"


def field(values, name="thickness of surfaces", resolution_m=0.5, origin_m=(1.0, 2.0)):
    return Field(name, 0, np.array(values, float), resolution_m, origin_m, 0.0, 0, 5, "cm")


class FloorMapTest(SiteFolderTest):
    def plan(self):
        fake_site.write_map(self.site_dir / "grid", "map", fake_site.room_pixels())
        return Plan(Site(self.site_dir))

    def test_a_picture_of_cells_lies_where_its_grid_does(self):
        found = re.search(r'x="([^"]+)" y="([^"]+)" width="([^"]+)" height="([^"]+)"', raster(b"", (6, 4), (-3, -2)))
        x, y, width, height = map(float, found.groups())
        np.testing.assert_allclose((x, y, width, height), (-3, -2, 6, 4))  # y is down: the top is at y = 2 of the map
        self.assertIn("rotate(-28.647890 -3.0000 2.0000)", raster(b"", (1, 1), (-3, -2), 0.5))

    def test_the_view_holds_the_grid_and_the_way(self):
        plan = self.plan()
        x, y, width, height = map(float, plan.view(0).split())
        np.testing.assert_allclose((x, y, width, height), (-3.5, -2.5, 7, 5))
        plan.add_way(Layer("way"), np.array([[0.0, 0, 1], [9, 5, 1]]), "way")
        x, y, width, height = map(float, plan.view(0).split())
        np.testing.assert_allclose((x, y, width, height), (-3.5, -5.5, 13, 8))

    def test_a_way_is_cut_where_the_floor_changes(self):
        plan, layer = self.plan(), Layer("way")
        plan.floors = [{"number": 0, "height_m": 0.0}, {"number": 1, "height_m": 3.0}]
        plan._reach_m[1] = []
        way = np.array([[0, 0, 1.2], [1, 0, 1.3], [1, 0, 4.2], [2, 0, 4.2], [2, 0, 1.1]], float)
        plan.add_way(layer, way, "way")
        self.assertEqual([len(layer.parts[floor]) for floor in (0, 1)], [2, 1])

    def test_lines_are_thinned_to_what_is_seen(self):
        points = np.column_stack([np.linspace(0, 1, 1001), np.zeros(1001), np.zeros(1001)])
        kept = thinned(points)
        np.testing.assert_allclose(kept[[0, -1]], points[[0, -1]])
        self.assertLess(len(kept), 60)
        self.assertEqual(len(thinned(points[:1])), 1)
        self.assertLessEqual(len(thinned(np.cumsum(np.ones((20000, 3)), axis=0))), 4001)

    def test_users_text_stays_text(self):
        layer = Layer("<b>")
        layer.add(0, area([np.zeros((3, 2))], "box", "</title><script>"))
        drawn = drawing('"<i>', self.plan(), [layer], 'make plan SITE=" onload="x')
        self.assertNotRegex(drawn.partition("<script>")[0], r'<b>|<i>|</title><script|" onload')

    def test_layers_that_are_empty_have_no_box(self):
        self.assertNotIn("objects", drawing("x", self.plan(), [Layer("objects")], ""))


class CellsTest(unittest.TestCase):
    def test_median_sum_and_most_are_those_of_each_cell(self):
        random = np.random.default_rng(3)
        points, values = random.uniform(-2, 3, (500, 2)), random.uniform(0, 1, 500)
        cells = Cells(points, 0.5)
        keys = np.floor(points / 0.5).astype(int)
        for key in np.unique(keys, axis=0):
            row, column = key[::-1] - cells.low[::-1]
            inside = values[(keys == key).all(axis=1)]
            at = row * cells.columns + column
            self.assertEqual(cells.median(values)[at], np.sort(inside)[len(inside) // 2])
            self.assertAlmostEqual(cells.sums(values)[at], inside.sum())
            self.assertEqual(cells.most(values, values >= 0)[at], inside.max())
        self.assertTrue(np.isnan(cells.median(values)).sum() == cells.size - len(np.unique(keys, axis=0)))


class FieldsTest(SiteFolderTest):
    def write_landmarks(self, keyframes, stray_m=1.1):
        (self.site_dir / "landmarks").mkdir(parents=True)
        with sealed(self.site_dir / "landmarks/landmarks.h5") as file:
            file["regions/num_landmarks"] = np.array([[2], [0], [1]])
            positions_m = np.array([[0.1, 0.1, 1], [0.2, 0.1, 1], [stray_m, 0.1, 1]])
            sigmas_m, keyframes = np.array([[0.01], [0.03], [0.2]], np.float32), np.array(keyframes, np.int32)[:, None]
            regions = [(slice(0, 2), slice(0, 4), [0, 2, 4]), (slice(0, 0), slice(0, 0), [0]), (slice(2, 3), slice(4, 5), [0, 1])]
            for i, (landmarks, observations, offsets) in enumerate(regions):
                file[f"region_{i}/landmarks/position_in_map_m"] = positions_m[landmarks]
                file[f"region_{i}/landmarks/position_sigma_m"] = sigmas_m[landmarks]
                file[f"region_{i}/observations/offsets"] = np.array(offsets)[:, None]
                file[f"region_{i}/observations/keyframe_idx"] = keyframes[observations]

    def fields(self):
        site = Site(self.site_dir)
        return {one.name: one for one in fields(site, Plan(site))}

    def test_landmarks_that_went_astray_make_no_field_large(self):
        self.write_landmarks([7, 8, 8, 9, 7], stray_m=1500.0)
        self.assertEqual(self.fields()["keyframes that saw it"].values.shape, (1, 1))

    def test_a_cell_counts_each_keyframe_once(self):
        self.write_landmarks([7, 8, 8, 9, 7])
        found = self.fields()
        np.testing.assert_array_equal(found["keyframes that saw it"].values[0], [3, np.nan, np.nan, np.nan, 1])
        np.testing.assert_allclose(found["uncertainty of landmarks"].values[0][[0, 4]], [3, 20], rtol=1e-6)

    def test_damaged_landmarks_are_named(self):
        self.write_landmarks([7, 8])
        with self.assertRaisesRegex(DataError, "landmarks.h5: damaged"):
            self.fields()

    def test_places_of_all_tiles_are_one_field(self):
        self.write("tiles/tiles.txt", "nightmap tiles, version 1, 2 names\n0_0\n1_0\n")
        self.write("point_cloud/places_0_0.csv", PLACES + "0.25,0.25,1.25,50,0.06,10,9\n0.25,0.25,0.25,50,0.01,10,3\n0.75,0.25,0.25,3,0.5,1,0\n")
        self.write("point_cloud/places_1_0.csv", PLACES + "1.25,0.25,0.25,50,0.02,0,0\n")
        found = self.fields()
        np.testing.assert_allclose(found["thickness of surfaces"].values, [[6, np.nan, 2]])
        np.testing.assert_allclose(found["held-out rays that agree"].values, [[60, np.nan, np.nan]])


class PlacesTest(SiteFolderTest):
    def test_a_bad_part_is_told_at_its_worst_cell(self):
        values = np.full((4, 6), 1.0)
        values[1, 1:3], values[1, 2], values[3, 5] = 5, 7.5, 9  # the last is smaller than a place
        (area_m2, place), = bad_parts(field(values))
        self.assertEqual((area_m2, place.x_m, place.y_m), (0.5, 2.25, 2.75))
        self.assertEqual(place.said, "surfaces are up to 7.5 cm thick")

    def test_where_nothing_is_known_nothing_is_bad(self):
        self.assertEqual(list(bad_parts(field(np.full((3, 3), np.nan)))), [])
        self.assertEqual(list(bad_parts(field(np.full((3, 3), 80.0), "held-out rays that agree"))), [])
        self.assertEqual(len(list(bad_parts(field(np.full((3, 3), 60.0), "held-out rays that agree")))), 1)

    def test_guessed_motion_is_a_place_of_the_way(self):
        estimate = fake_site.write_site(self.site_dir)
        (self.site_dir / "pose_graph").mkdir(exist_ok=True)
        (self.site_dir / "pose_graph/report.json").write_text(json.dumps({"parts": [{"runs": [[0, 29]]}, {"runs": [[30, 32]]}]}))
        site = Site(self.site_dir)
        [place], judged = places_to_look_at(site, Plan(site), [])
        self.assertEqual(judged, ["motion"])
        np.testing.assert_allclose((place.x_m, place.y_m), estimate.positions_m[31, :2], atol=1e-6)
        self.assertRegex(place.said, "^frames 30 to 32 hang together")

    def test_the_page_names_them_and_leads_there(self):
        fake_site.write_site(self.site_dir)
        self.write("tiles/tiles.txt", "nightmap tiles, version 1, 1 names\n0_0\n")
        self.write("point_cloud/places_0_0.csv", PLACES + "1.25,1.25,0.25,50,0.07,0,0\n1.75,1.25,0.25,50,0.06,0,0\n")
        page = self.report()
        self.assertIn('data-place="1.25 1.25 0">at 1.2, 1.2</a>: surfaces are up to 7.0 cm thick', page)
        self.assertIn('<g class="bad"><circle', page)


class DamagedTest(SiteFolderTest):
    """A page of what is whole, as make status and a failed run write it."""

    def test_one_damaged_file_costs_its_sections_only(self):
        fake_site.write_site(self.site_dir)
        fake_site.write_map(self.site_dir / "grid", "map", fake_site.room_pixels())
        self.write("verdict/verdict.json", json.dumps({"verdict": "good", "checks": []}))
        self.write("map_frame/trajectory.tum", "no number\n")
        self.check_refused("report.py", "map_frame/trajectory.tum:1")
        page = self.written("report.py", "report/index.html", "--of-what-is-whole")
        for text in ("Damaged results", "map_frame/trajectory.tum:1", "<strong>Good.</strong>", "grid/map.pgm</a>"):
            self.assertIn(text, page)

    def test_loops_of_frames_that_the_lists_lack_are_left_out(self):
        fake_site.write_site(self.site_dir)
        self.write("pose_graph/loops.csv", "frame_a,frame_b,status,reason\n0,99999,accepted,\n")
        self.assertIn("accepted", self.report())

    def test_objects_that_cannot_be_read_cost_no_page(self):
        path = self.folder / "objects.yaml"
        for text in ("objects: [", "\t", "", "objects:\n  - {name: a}\n", "objects:\n  - {name: a, x_m: 1, y_m: b}\n"):
            path.write_text(text)
            with self.assertRaisesRegex(DataError, "objects.yaml"):
                objects_of(path)
        path.write_text("objects:\n  - {name: a, x_m: 1, y_m: 2, size_x_m: 2, size_y_m: 1, angle_deg: 90}\n")
        [(name, corners_m)] = objects_of(path)
        np.testing.assert_allclose((corners_m.min(axis=0), corners_m.max(axis=0)), ((0.5, 1), (1.5, 3)), atol=1e-12)


class VerdictTest(SiteFolderTest):
    def page(self, found, *checks):
        (self.site_dir / "verdict").mkdir(parents=True, exist_ok=True)
        rows = [{"name": f"check {i}", "verdict": verdict, "value": 1.0, "unit": "%", "limit": "at most 1 %", "reason": "r", "advice": advice}
                for i, (verdict, advice) in enumerate(checks)]  # fmt: skip
        self.write("verdict/verdict.json", json.dumps({"verdict": found, "checks": rows}))
        return self.report()

    def first(self, page):
        return page.partition('class="said"')[2].partition('class="map"')[0]

    def test_a_good_map_says_what_it_is_for(self):
        fake_site.write_site(self.site_dir)
        first = self.first(self.page("good", ("good", ""), ("not known", "")))
        self.assertIn("<strong>Good.</strong> All 1 checks are within their limits; 1 could not be measured.", first)
        self.assertIn("make localize SITE=office QUERY=photo.jpg", first)
        self.assertIn("No place of the map stands out, by motion.", first)

    def test_a_bad_map_names_what_failed_and_the_remedy(self):
        fake_site.write_site(self.site_dir)
        first = self.first(self.page("do not use", ("good", ""), ("look at this", "look"), ("do not use", "record <slower>")))
        self.assertIn("<strong>Do not use this map.</strong> 1 of 3 checks failed: check 2.", first)
        self.assertIn("<li>check 2: record &lt;slower&gt;</li>", first)
        self.assertNotIn("make localize", first)

    def test_a_failed_run_names_the_job_its_error_and_the_next_command(self):
        fake_site.write_site(self.site_dir)
        failure = {"goals": ["map"], "failed": [{"job": "octree", "exit_code": 1, "log": ["10:00:00 error octree: disk <full>; free 2 GB"]}],
                   "out_of_date": [], "num_out_of_date": 0}  # fmt: skip
        self.write("logs/failure.json", json.dumps(failure))
        first = self.first(self.page("good", ("good", "")))
        self.assertIn("<strong>The last run failed.</strong> octree did not end well", first)
        self.assertIn("octree: disk &lt;full&gt;; free 2 GB", first)
        self.assertIn("<code>make map SITE=office</code>", first)

    def test_before_a_map_there_is_no_verdict(self):
        fake_site.write_site(self.site_dir)
        self.assertIn("No verdict yet.", self.first(self.report()))


class ChangesTest(SiteFolderTest):
    def setUp(self):
        fake_site.write_site(self.site_dir)
        self.write("verdict/verdict.json", json.dumps({"verdict": "good", "checks": []}))

    def test_the_page_tells_what_changed_until_something_else_does(self):
        self.write("config/grid.toml", "resolution_m = 0.05\nseed = 0\n")
        self.assertNotIn("What changed", self.report())
        self.assertNotIn("What changed", self.report())  # the same results
        self.write("config/grid.toml", "resolution_m = 0.1\nseed = 0\n")
        said = "<td>grid.resolution_m</td><td>0.05</td><td>0.1</td>"
        page = self.report()
        self.assertIn(said, page)
        self.assertNotIn("grid.seed", page)
        self.assertEqual(self.report(), page)
        self.write("config/grid.toml", "resolution_m = 0.1\nseed = 1\n")
        page = self.report()
        self.assertNotIn(said, page)
        self.assertIn("<td>grid.seed</td><td>0</td><td>1</td>", page)

    def test_a_damaged_file_of_runs_is_begun_anew(self):
        state = {"options": {"grid": 3}, "figures": {}, "times_s": {}}
        for text in ("{", "[]", '{"format": "x"}', json.dumps({"format": "nightmap runs", "version": 1, "now": state, "before": state})):
            self.write("report/runs.json", text)
            self.report()
            self.assertIn("now", json.loads((self.site_dir / "report/runs.json").read_text()))

    def test_what_is_no_part_of_the_map_and_a_failed_run_are_no_change(self):
        self.report()
        runs = (self.site_dir / "report/runs.json").read_bytes()
        self.write("config/plan.toml", 'start = "1,1"\n')
        self.report()
        self.assertEqual((self.site_dir / "report/runs.json").read_bytes(), runs)
        self.write("config/grid.toml", "resolution_m = 0.3\n")
        self.write("logs/failure.json", json.dumps({"goals": ["map"], "failed": [], "out_of_date": [], "num_out_of_date": 0}))
        self.report()
        self.assertEqual((self.site_dir / "report/runs.json").read_bytes(), runs)

    def test_times_that_hardly_differ_are_no_change(self):
        states = [{"options": {}, "figures": {}, "times_s": {"a": 10.0, "b": 10.0}}, {"options": {}, "figures": {}, "times_s": {"a": 11.0, "b": 14.0}}]
        section = changes.changes_section({"before": states[0], "now": states[1]})
        self.assertIn("<td>b</td>", section)
        self.assertNotIn("<td>a</td>", section)


class FilesTest(SiteFolderTest):
    def test_each_result_is_a_link_with_its_size(self):
        fake_site.write_site(self.site_dir)
        fake_site.write_map(self.site_dir / "grid", "map", fake_site.room_pixels())
        page = self.report()
        for name, size in (("grid/map.pgm", "2.4 kB"), ("map_frame/trajectory.tum", None)):
            path = re.search(rf'<a href="\.\./{name}">{name}</a></td><td>([^<]*)</td>', page)
            self.assertIsNotNone(path, name)
            self.assertTrue(size is None or path[1] == size, path[1])
        self.assertRegex(page, r'<summary>2 files frames/shard_U.csv</summary><ul class="plain"><li><a href="\.\./frames/shard_0000.csv">')

    def test_sizes_and_programs(self):
        self.assertEqual([size_text(size) for size in (0, 999, 1000, 2_400_000, 3e12)], ["0 B", "999 B", "1.0 kB", "2.4 MB", "3000 GB"])
        self.assertEqual((opened_by("x.tum"), opened_by("x.unknown")), ("evo_traj tum", ""))


if __name__ == "__main__":
    unittest.main()
