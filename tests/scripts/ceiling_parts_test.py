# SPDX-License-Identifier: Apache-2.0
"""Parts of the evaluation of a ceiling's map: chi-square bounds, planar poses, rays in the exact ceiling, NEES and NIS."""

import json
import unittest
from types import SimpleNamespace

import numpy as np

import ceiling_site
from fake_site import rotation_about
from folder_case import FolderTest
from nightmap_eval.ceiling.ceiling_consistency import FrameErrors, bounds, errors_then, nees_figures, nis_figures, quantile
from nightmap_eval.ceiling.true_ceiling import TrueCeiling, rays_of, read_camera
from nightmap_eval.planar_poses import compose, first_pose_alignment, headings_rad, inverse, to_rows, to_trajectory, wrapped_rad
from nightmap_eval.trajectory import Trajectory, quaternion
from nightmap_site.script_errors import DataError


class ChiSquareTest(unittest.TestCase):
    def test_bounds_of_tables(self):
        np.testing.assert_allclose(bounds(np.array([1, 3, 100])), [[0.001, 0.2158, 74.2219], [5.0239, 9.3484, 129.5612]], atol=1e-4)
        self.assertAlmostEqual(quantile(0.95, 2), 5.9915, places=4)


class ReadCameraTest(FolderTest):
    def test_a_lens_of_another_model_is_refused(self):
        path = self.folder / "cameras.json"
        site = SimpleNamespace(needed=lambda job, output: path)
        path.write_text(json.dumps({"cameras": [{"color": ceiling_site.CAMERA}]}))
        self.assertEqual(read_camera(site)["fx"], ceiling_site.CAMERA["fx"])
        path.write_text(json.dumps({"cameras": [{"color": ceiling_site.CAMERA | {"lens": "fisheye"}}]}))
        with self.assertRaisesRegex(DataError, "cameras.json: the truth of a ceiling is seen through OpenCV's five"):
            read_camera(site)


class PlanarPosesTest(unittest.TestCase):
    def test_a_pose_and_its_inverse_are_nothing(self):
        rows = np.random.default_rng(1).normal(size=(20, 3))
        for product in (compose(rows, inverse(rows)), compose(inverse(rows), rows)):
            np.testing.assert_allclose(product, 0, atol=1e-12)
        np.testing.assert_allclose(to_rows(to_trajectory(np.arange(20), rows)), rows, atol=1e-12)

    def test_angles_are_wrapped(self):
        np.testing.assert_allclose(wrapped_rad([0, 3.5, -3.5, 13]), [0, 3.5 - 2 * np.pi, 2 * np.pi - 3.5, 13 - 4 * np.pi])

    def test_the_heading_of_a_tilted_pose_is_that_of_its_x_axis(self):
        tilted = rotation_about([0, 0, 1], 0.7) @ rotation_about([1, 0, 0], 0.1)
        poses = Trajectory(np.zeros(1, int), np.zeros((1, 3)), np.array([quaternion(tilted)]))
        np.testing.assert_allclose(headings_rad(poses), [0.7], atol=1e-12)

    def test_the_first_poses_are_put_on_each_other(self):
        truth = to_trajectory(ceiling_site.times_ns(), ceiling_site.drive())
        estimate = to_trajectory(ceiling_site.times_ns(), ceiling_site.in_map(ceiling_site.drive()))
        np.testing.assert_allclose(first_pose_alignment(estimate, truth).apply(estimate.positions_m), truth.positions_m, atol=1e-9)


class RaysTest(unittest.TestCase):
    def setUp(self):
        x0, y0, x1, y1, heights_m = np.array(ceiling_site.RECTANGLES).T
        self.ceiling = TrueCeiling(np.column_stack([x0, x1, y0, y1]), heights_m, None)

    def ends(self, origins_m, directions):
        return self.ceiling.cast(np.array(origins_m, float), np.array(directions, float))

    def test_a_ray_ends_at_what_is_in_its_way(self):
        for name, origin_m, direction, end_m in (
            ("the ceiling above", [1, 1, 0.35], [0, 0, 1], [1, 1, 2.6]), ("the ceiling aside", [1, 1, 0.6], [0.5, -0.25, 1], [2, 0.5, 2.6]),
            # At x = 4.2 it is 1.95 m high: below the lintel's 2.1 m.
            ("through the doorway", [3, 0, 0.6], [0.8, 0.1, 0.9], [3 + 2 * 0.8 / 0.9, 2 * 0.1 / 0.9, 2.6]),
            ("the lintel", [3, 0, 0.5], [1, 0, 1.8], [4, 0, 2.3]), ("the lintel from below", [3.9, 0, 0.5], [0.2, 0, 1.6], [4.1, 0, 2.1]),
            ("the wall beside the doorway", [3, 1, 0.5], [1, 0, 1], [4, 1, 1.5]), ("the wall aside", [3, 0, 0.5], [0, -2, 1], [3, -2, 1.5]),
            ("the frame of the doorway", [3.5, 0, 0.5], [0.6, 0.6, 0.3], [4, 0.5, 0.75]),
            ("back from the second room", [5, 0, 0.6], [-0.8, 0, 0.8], [3, 0, 2.6])):  # fmt: skip
            with self.subTest(name):
                np.testing.assert_allclose(self.ends([origin_m], [direction]), [end_m])

    def test_rays_down_or_from_outside_end_nowhere(self):
        self.assertTrue(np.isnan(self.ends([[1, 1, 0.5], [1, 1, 0.5], [9, 0, 0.5]], [[0, 0, -1], [1, 0, 0], [0, 0, 1]])).all())
        self.assertEqual(self.ends(np.zeros((0, 3)), np.zeros((0, 3))).shape, (0, 3))

    def test_distortion_is_removed(self):
        camera = ceiling_site.CAMERA | {"k1": -0.2, "k2": 0.05, "p1": 0.001, "p2": -0.002, "k3": 0.003}
        x, y = np.meshgrid(np.linspace(-0.8, 0.8, 9), np.linspace(-0.6, 0.6, 7))
        x, y = x.ravel(), y.ravel()
        r2 = x * x + y * y
        radial = 1 + r2 * (camera["k1"] + r2 * (camera["k2"] + r2 * camera["k3"]))
        u = x * radial + 2 * camera["p1"] * x * y + camera["p2"] * (r2 + 2 * x * x)
        v = y * radial + camera["p1"] * (r2 + 2 * y * y) + 2 * camera["p2"] * x * y
        pixels = np.column_stack([camera["fx"] * u + camera["cx"], camera["fy"] * v + camera["cy"]])
        np.testing.assert_allclose(rays_of(camera, pixels), np.column_stack([x, y, np.ones(63)]), atol=1e-6)


class ConsistencyTest(unittest.TestCase):
    def setUp(self):
        self.random = np.random.default_rng(3)

    def frame_errors(self, num, factor):
        """Errors drawn of covariances that are stated `factor` times as large."""
        roots = self.random.normal(size=(num, 3, 3)) * 0.02
        errors = np.einsum("nij,nj->ni", roots, self.random.normal(size=(num, 3)))
        covariances = roots @ roots.transpose(0, 2, 1)
        is_regular = np.linalg.eigvalsh(covariances)[:, 0] > 1e-9
        return FrameErrors(np.arange(num)[is_regular], np.zeros(num)[is_regular], errors[is_regular], factor * covariances[is_regular])

    def test_modelled_noise_is_within_the_bounds(self):
        figures = nees_figures(self.frame_errors(4000, 1))
        self.assertAlmostEqual(figures["within_percent"], 95, delta=1.5)
        self.assertAlmostEqual(figures["mean"], 3, delta=0.15)

    def test_dishonest_covariances_are_outside(self):
        self.assertGreater(nees_figures(self.frame_errors(1000, 0.1))["above_percent"], 50)
        self.assertGreater(nees_figures(self.frame_errors(1000, 20))["below_percent"], 50)

    def test_a_frame_without_uncertainty_is_not_judged(self):
        errors = self.frame_errors(10, 1)
        errors.covariances[0] = 0
        self.assertEqual(nees_figures(errors)["num_frames"], len(errors.errors) - 1)

    def test_nis_is_judged_by_its_own_degrees_of_freedom(self):
        degrees = self.random.integers(1, 60, 4000) * 2
        degrees[:10] = 0
        ceiling_map = SimpleNamespace(frame_num_residuals=degrees, frame_nis=self.random.chisquare(np.maximum(degrees, 1)))
        figures = nis_figures(ceiling_map)
        self.assertEqual(figures["num_frames"], 3990)
        self.assertAlmostEqual(figures["within_percent"], 95, delta=1.5)
        self.assertAlmostEqual(figures["mean_per_degree_of_freedom"], 1, delta=0.02)

    def test_errors_are_in_the_map_and_headings_wrap(self):
        arrays = ceiling_site.map_arrays()
        poses = arrays["frame_pose"].copy()
        poses[7] += [0.03, -0.04, 2 * np.pi + 0.01]
        ceiling_map = SimpleNamespace(frame_time_ns=arrays["frame_time_ns"], frame_pose=poses,
                                      frame_covariance=arrays["frame_covariance"].reshape(-1, 3, 3))  # fmt: skip
        errors = errors_then(ceiling_map, to_trajectory(ceiling_site.times_ns(), ceiling_site.drive())).errors
        np.testing.assert_allclose(errors[7], [0.03, -0.04, 0.01], atol=1e-9)
        np.testing.assert_allclose(np.delete(errors, 7, axis=0), 0, atol=1e-9)
