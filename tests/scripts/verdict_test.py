# SPDX-License-Identifier: Apache-2.0
"""Checks of recordings and maps: what each notices, what leaves it quiet, and the verdict that follows."""

import json
import math
import shutil
import tempfile
import unittest
from pathlib import Path
from types import SimpleNamespace
from unittest import mock

import numpy as np

import fake_site
from fake_site import walk
from folder_case import SiteFolderTest
from nightmap_eval.dense import verdict_cloud
from nightmap_eval.verdict import verdict_calibration, verdict_depth, verdict_recording, verdict_way
from nightmap_eval.verdict.verdict_recording import COLUMNS
from nightmap_eval.verdict.verdict import (
    FORM,
    GOOD,
    LOOK,
    NOT_KNOWN,
    REFUSE,
    check,
    lines,
    map_needs,
    needs_line,
    unknown,
    verdict_json,
    worst,
)
from nightmap_site.checked_reading import read_object
from nightmap_site.site import Site

# A frame of a good recording.
FRAME = {"brightness": 120, "dark_share": 0, "bright_share": 0, "blur_px": 1.2, "textured_share": 1, "measured_share": 0.8, "depth_p10_m": 1,
         "depth_median_m": 2, "depth_p90_m": 3, "planar_share": 0.5, "planar_share_otherwise": 0.25, "same_color": 0, "same_depth": 0, "tracked_share": 0.9, "flow_px": 5, "gain": 1}  # fmt: skip
CAMERA = {"camera_id": "c", "depth_units_per_m": 1000, "color": {"width": 640, "height": 480, "fx": 520, "fy": 520, "cx": 318, "cy": 255}}
WINDOW = {"num_edges": 100, "by_frame_offset": [1, 1, 1, 1, 2, 1, 1, 1, 1], "at_best_shift": 2, "at_no_shift": 2}


def judged(checks):
    return {item.name: item.verdict for item in checks}


class CheckTest(unittest.TestCase):
    def test_limits_include_their_ends(self):
        for value, verdict in ((0, GOOD), (5, GOOD), (5.1, LOOK), (40, LOOK), (41, REFUSE), (-1, REFUSE), (math.nan, REFUSE)):
            self.assertEqual(check("x", value, "%", (0, 5), "reason", "advice", usable=(0, 40)).verdict, verdict, value)

    def test_advice_has_the_value_and_only_where_it_is_needed(self):
        self.assertEqual(check("x", 7.0, "%", (0, 5), "", "{value:.0f} % is too much").advice, "7 % is too much")
        self.assertEqual(check("x", 3.0, "%", (0, 5), "", "{value:.0f} % is too much").advice, "")

    def test_the_worst_check_decides(self):
        good, look = (check("x", value, "", (0, 1), "", "") for value in (0, 2))
        refuse = check("x", 9, "", (0, 1), "", "", usable=(0, 3))
        self.assertEqual(worst([]), GOOD)
        self.assertEqual(worst([good, look, good]), LOOK)
        self.assertEqual(worst([look, refuse, good]), REFUSE)

    def test_what_could_not_be_measured_is_shown_and_never_passes_for_good(self):
        shown, matters = unknown("height", "reason", "no floor was seen"), unknown("up", "reason", "unknown up", matters=True)
        self.assertEqual((shown.verdict, matters.verdict), (NOT_KNOWN, LOOK))
        self.assertEqual(worst([shown]), GOOD)
        self.assertEqual(worst([shown, matters]), LOOK)
        self.assertEqual(list(lines([shown]))[1], "  not known: height not known (not measured): no floor was seen")
        written = json.loads(json.dumps(verdict_json(SimpleNamespace(name="x"), [shown])))
        self.assertNotIn("value", written["checks"][0])
        path = Path(self.enterContext(tempfile.TemporaryDirectory())) / "verdict.json"
        path.write_text(json.dumps(written))
        self.assertEqual(read_object(path, FORM)["checks"][0]["verdict"], NOT_KNOWN)

    def test_the_text_names_what_is_not_good(self):
        checks = [check("speed", 9.0, "m/s", (0, 3), "", "too fast"), check("height", 1.0, "m", (0, 3), "", "")]
        text = "\n".join(lines(checks))
        self.assertTrue(text.startswith("verdict: look at this"))
        self.assertIn("speed 9 m/s (0 to 3 m/s): too fast", text)
        self.assertNotIn("height", text)


class DepthTest(unittest.TestCase):
    def setUp(self):
        self.random = np.random.default_rng(3)

    def scores(self, middle, best, num_windows=15):
        scores = self.random.normal(1.2, 0.1, (num_windows, 9))
        scores[:, 4] += middle
        scores[:, 6] += best
        return scores

    def test_color_of_another_frame(self):
        self.assertEqual(verdict_depth.best_offset(self.scores(middle=0, best=1)), 2)
        self.assertEqual(verdict_depth.best_offset(self.scores(middle=1, best=0)), 0)

    def test_chance_is_no_shift(self):
        for _ in range(50):
            self.assertEqual(verdict_depth.best_offset(self.scores(middle=0, best=0)), 0)

    def test_depth_that_fits_no_frame(self):
        self.assertGreater(verdict_depth.own_agreement(self.scores(middle=1, best=0)), 1.6)
        self.assertLess(verdict_depth.own_agreement(self.scores(middle=0, best=0)), 1.2)

    def test_a_shift_counts_when_it_is_better_beyond_chance(self):
        survey = SimpleNamespace(at_no_shift=self.random.normal(1.2, 0.1, 12), at_best_shift=self.random.normal(2.2, 0.1, 12),
                                 best_shift=np.array([0.06, 0.0]))  # fmt: skip
        self.assertAlmostEqual(verdict_depth.shift_of(survey), 0.06)
        survey.at_best_shift = survey.at_no_shift + self.random.normal(0, 0.2, 12)
        self.assertEqual(verdict_depth.shift_of(survey), 0)


class MapTest(SiteFolderTest):
    def setUp(self):
        fake_site.write_site(self.site_dir)
        self.site = Site(self.site_dir)

    def write(self, job, **report):
        path = self.site.path(job, "report")
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(json.dumps(report))

    def write_survey(self, fixed_parts=(), **changes):
        """A survey of forty frames alike, but for the changes of half of them."""
        rows = [FRAME | (changes if i % 2 else {}) for i in range(fake_site.NUM_FRAMES)]
        lines = [f"{i},{time_ns},0," + ",".join(str(row[name]) for name in COLUMNS) for i, (time_ns, row) in enumerate(zip(walk().times_ns, rows))]
        path = self.site.path("survey", "frames")
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("\n".join(["frame_idx,time_ns,sequence_idx," + ",".join(COLUMNS), *lines]) + "\n")
        self.write("survey", num_frames=40, num_frames_surveyed=40, alignment={"best_shift_x": 0, "best_shift_y": 0, "windows": [WINDOW] * 5},
                   fixed_parts=list(fixed_parts))  # fmt: skip
        self.site.path("frames", "cameras").write_text(json.dumps({"cameras": [CAMERA]}))

    def not_good(self, **changes):
        self.write_survey(**changes)
        return {item.name for item in verdict_recording.checks(self.site) if item.verdict != GOOD}

    def test_a_good_recording(self):
        self.assertEqual(self.not_good(), set())

    def cameras_checks(self, depth_along_ray=False, **color):
        self.write_survey(planar_share=0.2, planar_share_otherwise=0.6)
        camera = CAMERA | {"color": CAMERA["color"] | color} | ({"depth_along_ray": True} if depth_along_ray else {})
        self.site.path("frames", "cameras").write_text(json.dumps({"cameras": [camera]}))
        return {item.name: item for item in verdict_recording.checks(self.site)}

    def test_intrinsics_of_pictures_of_another_size(self):
        for factor, verdict in ((1.02, GOOD), (1.25, LOOK), (2, REFUSE), (0.5, REFUSE), (0.8, LOOK)):
            with self.subTest(factor):
                scaled = {"width": round(640 / factor), "height": round(480 / factor), "cy": 245}
                found = self.cameras_checks(**scaled)["size of the pictures of camera c"]
                self.assertEqual(found.verdict, verdict, found)
                if verdict != GOOD:
                    self.assertIn(f"fx = {520 / (factor if factor in (2, 0.5) else found.value):.6g}", found.advice)
                    self.assertAlmostEqual(found.value, factor, delta=0.04 * factor)

    def test_a_principal_point_off_the_middle(self):
        self.assertEqual(self.cameras_checks(cx=318, cy=420)["principal point of camera c"].verdict, LOOK)

    def test_depth_that_is_flat_only_along_the_ray(self):
        found = self.cameras_checks()["flatness of depth"]
        self.assertEqual(found.verdict, LOOK)
        self.assertIn("set depth_along_ray = true", found.advice)

    def test_depth_that_is_flat_only_as_z(self):
        self.assertIn("remove depth_along_ray", self.cameras_checks(depth_along_ray=True)["flatness of depth"].advice)

    def test_faults_of_a_recording(self):
        faults = {"blurred frames": {"blur_px": 4}, "frozen pictures": {"same_color": 1}, "frozen depth": {"same_depth": 1},
                  "exposure jumps": {"gain": 2.2}, "dark frames": {"dark_share": 0.9}, "overexposed frames": {"bright_share": 0.9},
                  "frames without texture": {"textured_share": 0.1}, "frames unlike the one before": {"tracked_share": 0.05}}  # fmt: skip
        for name, change in faults.items():
            with self.subTest(name):
                self.assertEqual(self.not_good(**change), {name})
            shutil.rmtree(self.site.folder_of("survey"))

    def test_frames_written_twice_are_no_stall_of_the_camera(self):
        for path in self.site_dir.glob("frames/shard_*.csv"):
            header, *rows = path.read_text().splitlines()
            rows = [row.split(",") for row in rows]
            for row in rows:
                row[1] = str(int(row[1]) - 99_000_000 * (int(row[0]) % 2))  # 1 ms after the frame before
            path.write_text("\n".join([header, *map(",".join, rows)]) + "\n")
        self.assertEqual(self.not_good(same_color=1, flow_px=0), {"copied frames"})
        found = {item.name: item.advice for item in verdict_recording.checks(self.site)}
        self.assertIn("writes frames twice", found["copied frames"])

    def test_copies_do_not_hide_that_depth_belongs_to_other_colors(self):
        with mock.patch.dict(WINDOW, by_frame_offset=[1] * 9), mock.patch.dict(FRAME, flow_px=3):
            self.assertIn("color at edges of depth", self.not_good(same_color=1, flow_px=0))

    def test_parts_of_the_robot(self):
        clean, low = {"camera_id": "high", "share": 0.0}, {"camera_id": "a{b}", "share": 0.04, "mask": "mask_1.png"}
        for share, verdict in ((0.04, LOOK), (0.18, REFUSE)):
            self.write_survey(fixed_parts=[clean, low | {"share": share}])
            (found,) = (item for item in verdict_recording.checks(self.site) if item.verdict != GOOD)
            self.assertEqual((found.name, found.verdict), ("parts of the robot in the picture", verdict))
            for word in ("camera a{b}", "survey/mask_1.png", 'mask = "mask.png"', f"{100 * share:.1f} %"):
                self.assertIn(word, found.advice)
            shutil.rmtree(self.site.folder_of("survey"))
        self.assertEqual(self.not_good(fixed_parts=[clean]), set())

    def test_a_robot_in_the_picture_is_nothing_that_moves(self):
        self.write("join_clouds", held_out_rays_agreeing_percent=40)
        for parts, moves in ([], True), ([{"camera_id": "c", "share": 0.2, "mask": "mask_0.png"}], False):
            self.write_survey(fixed_parts=parts)
            (rays,) = (item for item in verdict_cloud.checks(self.site) if item.name == "held-out rays")
            self.assertEqual("profile moving" in rays.advice, moves)
            self.assertEqual("part of the robot" in rays.advice, not moves)
            shutil.rmtree(self.site.folder_of("survey"))

    def test_depth_of_another_scale(self):
        for factor, name in ((5, "far surfaces"), (0.2, "far surfaces")):
            scaled = {key: FRAME[key] * factor for key in ("depth_p10_m", "depth_median_m", "depth_p90_m")}
            with mock.patch.dict(FRAME, scaled):
                self.assertIn(name, self.not_good())
            shutil.rmtree(self.site.folder_of("survey"))

    def test_frames_without_depth_are_no_stall(self):
        nothing = {"measured_share": 0, "depth_p10_m": "", "depth_median_m": "", "depth_p90_m": ""}
        self.assertEqual(self.not_good(**nothing), {"frames without depth"})
        advice = {item.name: item.advice for item in verdict_recording.checks(self.site)}["frames without depth"]
        self.assertRegex(advice, "^no depth measured in 50 % of the frames: sunlight, .*range, or a covered projector$")

    def test_a_truth_by_another_clock(self):
        self.write("frames", ground_truths_apart=[{"file": "office/{truth}.txt", "apart_s": 7199.25}])
        self.assertEqual(self.not_good(), {"ground truth apart from the frames"})
        text = "\n".join(lines(verdict_recording.checks(self.site)))
        self.assertIn("ground truth apart from the frames 7.2e+03 s (0 to 0 s): office/{truth}.txt gives no frame a pose: the nearest of its times is 7199.25 s", text)

    def test_without_depth(self):
        nothing = dict.fromkeys(("measured_share", "depth_p10_m", "depth_median_m", "depth_p90_m"), "")
        with mock.patch.dict(FRAME, nothing):
            self.assertEqual(self.not_good(), set())

    def test_focal_length(self):
        for scale, verdict in ((1.01, GOOD), (0.9, LOOK), (1.58, REFUSE)):
            self.write("adjust", calibrations=[{"focal_scale": scale}])
            self.assertEqual(judged(verdict_calibration.checks(self.site)), {"focal length of camera 0": verdict})

    def test_offset_of_depth(self):
        path = self.site.path("frames", "cameras")
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(json.dumps({"cameras": [CAMERA | {"camera_id": "c{0}", "depth_offset_m": 0.02}]}))
        for offset_m, sigma_m, verdict in ((0.03, 0.002, GOOD), (-0.06, 0.002, LOOK), (0.098, 0.002, REFUSE), (0.3, 0.05, NOT_KNOWN)):
            self.write("adjust", depth_offsets=[{"offset_m": offset_m, "sigma_m": sigma_m}])
            found = list(verdict_calibration.checks(self.site))
            self.assertEqual(judged(found), {"offset of depth of camera 0": verdict})
            if verdict in (LOOK, REFUSE):
                self.assertIn(f"set depth_offset_m = {0.02 + offset_m:.3f} in the [[camera]] c{{0}}", "".join(lines(found)))
        self.write("adjust", calibrations="not estimated", depth_offsets="not estimated")
        self.assertEqual(judged(verdict_calibration.checks(self.site)), {})

    def test_floor(self):
        self.write("map_frame", floor_source="floor plane", camera_height_m=1.2, below_floor_percent=0.1, floor_warnings=[])
        found = judged(verdict_way.checks(self.site))
        self.assertEqual((found["camera height"], found["below the floor"], found["warnings of the floor"]), (GOOD, GOOD, GOOD))
        self.write("map_frame", floor_source="floor plane", camera_height_m=0.4, below_floor_percent=30, floor_warnings=["{odd}"])
        found = judged(verdict_way.checks(self.site))
        self.assertEqual((found["below the floor"], found["warnings of the floor"]), (LOOK, LOOK))

    def test_held_out_rays(self):
        self.write("survey", fixed_parts=[])
        for percent, verdict in ((97, GOOD), (80, LOOK), (48, REFUSE)):
            self.write("join_clouds", held_out_rays_agreeing_percent=percent, num_points=10)
            self.assertEqual(judged(verdict_cloud.checks(self.site))["held-out rays"], verdict)

    def test_the_script_writes_and_prints_the_verdict(self):
        self.write_survey()
        for job in ("survey", "check", "verdict"):
            self.assertTrue(self.site.has(job))
        out = self.site_dir / "check" / "verdict.json"
        result = fake_site.run("verdict.py", "--site-dir", self.site_dir, "--out", out)
        self.assertEqual(json.loads(out.read_text())["verdict"], GOOD, result.stderr)
        shutil.rmtree(self.site.folder_of("survey"))
        self.write_survey(blur_px=5)
        result = fake_site.run("verdict.py", "--site-dir", self.site_dir, "--out", out)
        self.assertEqual(result.returncode, 0, result.stderr)
        written = json.loads(out.read_text())
        self.assertEqual(written["verdict"], LOOK)
        self.assertEqual(written["checks"][0]["name"], "blurred frames")
        self.assertTrue(result.stdout.startswith("verdict: look at this"), result.stdout)

    def test_a_check_says_what_a_map_takes(self):
        self.write_survey()
        self.assertIsNone(map_needs(self.site))  # without a receipt
        report = self.site.folder_of("survey") / "report.json"
        report.write_text(json.dumps(json.loads(report.read_text()) | {"num_frames": 6000, "num_frames_surveyed": 300}))
        (report.parent / "receipt.json").write_text(json.dumps({"wall_time_s": 3.0}))
        needs = map_needs(self.site)
        jobs = self.site.pipeline.jobs.values()
        self.assertAlmostEqual(needs["time_s"], 0.01 * 6000 * sum(job.surveys_per_frame for job in jobs), 1)
        self.assertGreater(needs["time_s"], 200)
        self.assertGreater(needs["size_MB"], 6 * 90)
        self.assertEqual(needs["not_counted"], [])
        self.assertRegex(needs_line(needs), r"^a map of the 6000 frames takes about \d+ min here, and up to \d+ MB$")
        self.assertIn("30 s and the time of labels here", needs_line(needs | {"time_s": 30, "not_counted": ["labels"]}))
        out = self.site_dir / "check" / "verdict.json"
        result = fake_site.run("verdict.py", "--site-dir", self.site_dir, "--out", out)
        self.assertEqual(json.loads(out.read_text())["needs"], needs, result.stderr)
        self.assertIn(needs_line(needs), result.stdout)
