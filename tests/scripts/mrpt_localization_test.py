# SPDX-License-Identifier: Apache-2.0
"""mrpt_localization.py: reads queries, and counts failures as infinite errors. Needs no MRPT."""

import contextlib
import io
import unittest
from unittest import mock

import numpy as np

from folder_case import FolderTest  # first: it makes the benchmarks importable

import mrpt_localization as mrpt
from nightmap_eval.grid import FREE, OCCUPIED, UNKNOWN, Grid
from nightmap_eval.sealed_hdf5 import sealed
from nightmap_site.script_errors import DataError

TIMES_NS = [5 * 10**9, 7 * 10**9]
RANGES_M = [1.0, np.nan, -1.0, 9.0, 10.0, 12.0, 2.0]


def write_queries(path, **changed):
    """A query with two scans of 4 and 2 beams, and one with a scan of a beam."""
    data = {
        "time_ns": np.array(TIMES_NS, dtype=np.int64)[:, None],
        "scan_offset": np.array([0, 2, 3], dtype=np.int64)[:, None],
        "query_from_laser": np.array([[0.0, 0.1, 0.0], [np.pi, 0.0, 0.0], [0.0, 0.0, 0.0]]),
        "beams": np.tile([-1.5, 0.5, 10.0], (3, 1)),
        "range_offset": np.array([0, 4, 6, 7], dtype=np.int64)[:, None],
        "range_m": np.array(RANGES_M, dtype=np.float32)[:, None],
        "rough_position": np.array([[1.0, 2.0, 0.0], [3.0, 4.0, 5.0]]),
    }  # fmt: skip
    with sealed(path) as file:
        for name, value in (data | changed).items():
            if value is not None:
                file[name] = value


def write_truth(path, times_s=(5, 7)):
    lines = [f"{time_s} {time_s}.5 -2 0 0 0 {np.sin(0.4)} {np.cos(0.4)}" for time_s in times_s]
    path.write_text("# map_from_robot\n" + "\n".join(lines) + "\n")


class FilesTest(FolderTest):
    def setUp(self):
        self.path = self.folder / "queries.h5"
        self.truth = self.folder / "truth.tum"

    def test_queries_have_their_scans(self):
        write_queries(self.path)
        first, second = mrpt.read_queries(self.path)
        self.assertEqual([first.time_ns, second.time_ns], TIMES_NS)
        self.assertEqual([len(scan.ranges_m) for scan in first.scans + second.scans], [4, 2, 1])
        np.testing.assert_array_equal(first.scans[1].query_from_laser, [np.pi, 0, 0])
        np.testing.assert_array_equal(second.rough, [3, 4, 5])

    def test_what_hit_nothing_is_zero(self):
        write_queries(self.path)
        first, second = mrpt.read_queries(self.path)
        np.testing.assert_array_equal(first.scans[0].ranges_m, [1, 0, 0, 9])
        np.testing.assert_array_equal(first.scans[1].ranges_m, [0, 0])  # at the limit, and beyond
        np.testing.assert_array_equal(second.scans[0].ranges_m, [2])

    def test_damaged_queries_are_refused(self):
        offset = np.array([0, 3, 1, 7], dtype=np.int64)[:, None]
        for changed, message in (
            ({"range_m": np.ones((5, 1), np.float32)}, "sizes do not add up"),
            ({"scan_offset": np.array([[0], [3]], np.int64)}, "sizes do not add up"),
            ({"rough_position": np.zeros((1, 3))}, "sizes do not add up"),
            ({"range_offset": offset}, "offsets do not increase"),
            ({"beams": None}, "beams"),
        ):  # fmt: skip
            write_queries(self.path, **changed)
            with self.subTest(changed), self.assertRaisesRegex(DataError, f"queries.h5: .*{message}"):
                mrpt.read_queries(self.path)

    def test_a_truncated_file_is_refused(self):
        write_queries(self.path)
        self.path.write_bytes(self.path.read_bytes()[:700])
        with self.assertRaisesRegex(DataError, "queries.h5"):
            mrpt.read_queries(self.path)

    def test_truth_is_that_of_the_times(self):
        write_queries(self.path)
        write_truth(self.truth, (4, 7, 6, 5))
        poses = mrpt.true_poses(self.truth, mrpt.read_queries(self.path))
        np.testing.assert_allclose(poses, [[5.5, -2, 0.8], [7.5, -2, 0.8]], atol=1e-12)

    def test_a_query_without_truth_is_refused(self):
        write_queries(self.path)
        write_truth(self.truth, (5,))
        with self.assertRaisesRegex(DataError, "truth.tum: no pose at 7000000000 ns"):
            mrpt.true_poses(self.truth, mrpt.read_queries(self.path))


class InputTest(unittest.TestCase):
    def setUp(self):
        self.grid = Grid(np.array([[FREE, OCCUPIED, UNKNOWN]], np.uint8), 0.5, 10.0, 20.0, np.pi / 2)
        scan = mrpt.Scan(np.array([0.25, 0.1, 0.0]), np.array([-1.5, 0.5, 10.0]), np.array([1.0, 0.0]))
        self.query = mrpt.Query(5, [scan], np.array([10.0, 21.0, 3.0]))

    def lines(self, ignore_rough=False):
        return mrpt.input_text(self.grid, [self.query], ignore_rough).splitlines()

    def test_scans_and_cells_are_as_the_program_reads_them(self):
        grid, row, _, scan = self.lines()
        self.assertEqual((grid, row), ("grid 3 1 0.5", "120"))
        self.assertEqual(scan, "scan 0.25 0.1 0 -1.5 0.5 10 2 1 0")

    def test_the_disc_is_in_the_frame_of_the_grid(self):
        words = self.lines()[2].split()
        self.assertEqual(words[:2], ["query", "1"])
        np.testing.assert_allclose([float(word) for word in words[2:]], [1, 0, 3], atol=1e-12)
        self.assertEqual(float(self.lines(ignore_rough=True)[2].split()[-1]), 0)

    def test_results_are_in_the_frame_of_the_map(self):
        truth = np.array([[9.0, 20.0, 0.0], [10.0, 21.3, -np.pi + 0.1]])
        text = "1 2 1 0 1.6 0.01 0.01 0.001 150 0.5\n"
        (row,) = mrpt.results(text, self.grid, truth, 0.15)
        np.testing.assert_allclose([row["x_m"], row["y_m"]], [10, 21])
        np.testing.assert_allclose(row["error_m"], 0.3)
        np.testing.assert_allclose(row["error_deg"], np.degrees(abs(1.6 + np.pi / 2 - np.pi - 0.1)))
        self.assertEqual((row["query"], row["seed"], row["num_particles"]), (1, 2, 150))
        self.assertTrue(row["converged"])
        self.assertFalse(mrpt.results(text, self.grid, truth, 0.14)[0]["converged"])  # the deviation is 0.1414 m


def row(error_m, error_deg=0.1, converged=True):
    return {"error_m": error_m, "error_deg": error_deg, "converged": converged, "cpu_s": 0.5}


class SummaryTest(unittest.TestCase):
    def test_failures_are_infinite(self):
        figures = mrpt.summary([row(0.01), row(0.02), row(0.03, converged=False)], 4)
        self.assertEqual(figures["converged_percent"], 50)
        self.assertEqual(figures["within_5cm_0.5deg_percent"], 50)
        self.assertEqual(figures["median_error_m"], np.inf)
        self.assertEqual(figures["median_error_deg"], np.inf)
        self.assertEqual(mrpt.summary([row(0.01), row(0.02), row(0.03)], 4)["median_error_m"], 0.03)

    def test_position_and_heading_must_be_right(self):
        figures = mrpt.summary([row(0.04, 0.4), row(0.04, 0.8), row(0.2, 0.1), row(0.04, 90)], 4)
        self.assertEqual(figures["within_5cm_0.5deg_percent"], 25)
        self.assertEqual(figures["within_10cm_1deg_percent"], 50)
        self.assertEqual(figures["within_50cm_5deg_percent"], 75)

    def test_only_what_converged_is_a_wrong_place(self):
        figures = mrpt.summary([row(7), row(8, converged=False), row(0.4)], 4)
        self.assertEqual(figures["wrong_place_percent"], 25)

    def test_time_is_of_all_queries(self):
        self.assertEqual(mrpt.summary([row(7), row(8, converged=False)], 4)["cpu_s_per_query"], 0.25)

    def test_no_result_is_no_error(self):
        figures = mrpt.summary([], 3)
        self.assertEqual((figures["converged_percent"], figures["wrong_place_percent"]), (0, 0))
        self.assertEqual(figures["median_error_m"], np.inf)

    def test_seeds_have_a_median_each(self):
        seeds = [{"a": 1.0, "b": np.inf}, {"a": 5.0, "b": 2.0}, {"a": 3.0, "b": np.inf}]
        self.assertEqual(mrpt.median_of_seeds(seeds), {"a": 3.0, "b": np.inf})

    def test_a_failure_is_null_in_json(self):
        self.assertEqual(mrpt.printable({"a": [np.inf, 1.5, True], "b": "x"}), {"a": [None, 1.5, True], "b": "x"})


class CommandLineTest(unittest.TestCase):
    FILES = ("--map", "m.yaml", "--queries", "q.h5", "--truth", "t.tum")

    def exit_code(self, call):
        with contextlib.redirect_stderr(io.StringIO()) as text, self.assertRaises(SystemExit) as caught:
            call()
        return caught.exception.code, text.getvalue()

    def test_settings_are_those_of_the_line(self):
        arguments = mrpt.parse_arguments([*self.FILES, "--set", "steps=7"])
        self.assertEqual(arguments.settings, mrpt.SETTINGS | {"steps": 7})

    def test_wrong_settings_are_refused(self):
        for words in (["--set", "stepz=7"], ["--set", "steps=many"], ["--set", "steps"], ["--seeds", "0"], ["--max-queries", "-1"]):
            with self.subTest(words):
                self.assertEqual(self.exit_code(lambda words=words: mrpt.parse_arguments([*self.FILES, *words]))[0], 2)

    def test_without_mrpt_it_names_the_package(self):
        with mock.patch.object(mrpt, "HEADERS", "/nowhere/*"):
            code, text = self.exit_code(lambda: mrpt.compile_filter("/nowhere"))
        self.assertEqual(code, 2)
        self.assertIn("apt-get install libmrpt-slam-dev", text)

    def test_queries_are_evenly_spread(self):
        self.assertEqual(mrpt.spread(list(range(11)), 3), [0, 5, 10])
        self.assertEqual(mrpt.spread([1, 2], 0), [1, 2])
        self.assertEqual(mrpt.spread([1, 2], 5), [1, 2])
