# SPDX-License-Identifier: Apache-2.0
"""The exact ceiling of a made-up building (truth/ceiling.json), and where a camera's rays meet it.

The free space is rectangles, each with a ceiling of its own height; all other sides are walls, as
stages/ceiling/synthesize_ceiling/ceiling_plan.h says. Building frame: z up, floor z = 0.
"""

from dataclasses import dataclass

import numpy as np

from nightmap_eval.ceiling.ceiling_consistency import quantile, squared_mahalanobis
from nightmap_eval.trajectory import interpolated, read_tum
from nightmap_eval.trajectory_errors import statistics
from nightmap_eval.walls_and_doors import RECORD_AGAIN, truth_folder
from nightmap_site.checked_reading import NUMBER, read_object
from nightmap_site.script_errors import DataError

RECTANGLE = dict.fromkeys(("x0", "y0", "x1", "y1", "height_m"), NUMBER)
CAMERA = dict.fromkeys(("fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3"), NUMBER)
TOUCHING_M = 1e-9
MAX_STEPS = 100  # rectangles that a ray crosses
NUM_ITERATIONS = 30  # to remove the distortion
MAX_CAMERA_GAP_NS = 500_000_000  # between the true poses of the camera around a sighting
ELLIPSOID_PROBABILITY = 0.95
# A track compares patches: an edge so near pulls its corner along, most of all in the last sighting before it hides the corner.
PIXEL_OFFSETS = ((0, 0), (5, 0), (-5, 0), (0, 5), (0, -5), (4, 4), (-4, 4), (4, -4), (-4, -4))
EDGE_STEP_M = 0.15


@dataclass
class TrueCeiling:
    areas_m: np.ndarray  # (R, 4) x0, x1, y0, y1 of each rectangle
    heights_m: np.ndarray  # (R,)
    building_from_camera: object  # Trajectory

    def rectangles_at(self, points_m):
        """Index of a rectangle that holds each point from above, -1 outside."""
        x, y = np.asarray(points_m)[:, :2].T[..., None]
        x0, x1, y0, y1 = self.areas_m.T
        holds = (x >= x0) & (x <= x1) & (y >= y0) & (y <= y1)
        return np.where(holds.any(axis=1), holds.argmax(axis=1), -1)

    def cast(self, origins_m, directions):
        """Points (n, 3) on ceilings and walls where rays end; NaN for rays that lead down or begin outside.

        Within a rectangle, a ray reaches the ceiling or goes out through a side. There it continues in the neighbour if it
        is below the neighbour's ceiling; else it hits the side."""
        points_m = np.full((len(origins_m), 3), np.nan)
        rects = self.rectangles_at(origins_m)
        rays = np.flatnonzero((rects >= 0) & (directions[:, 2] > 0))
        rects = rects[rays]
        for _ in range(MAX_STEPS):
            if len(rays) == 0:
                break
            ends_m, next_rects = self._cross(rects, origins_m[rays], directions[rays])
            is_end = next_rects < 0
            points_m[rays[is_end]] = ends_m[is_end]
            rays, rects = rays[~is_end], next_rects[~is_end]
        return points_m

    def _cross(self, rects, origins_m, directions):
        """Where rays leave their rectangles (through the ceiling or a side), and the rectangles that they enter; -1: none."""
        slopes = directions[:, :2] / directions[:, 2:]  # per metre of height
        x0, x1, y0, y1 = self.areas_m[rects].T
        walls_m = np.where(slopes > 0, np.column_stack([x1, y1]), np.column_stack([x0, y0]))
        with np.errstate(divide="ignore", invalid="ignore"):
            to_walls_m = np.where(slopes == 0, np.inf, (walls_m - origins_m[:, :2]) / slopes)
        axes = np.where(to_walls_m[:, 0] < to_walls_m[:, 1], 0, 1)  # 0: the ray meets a side of constant x first
        rows = np.arange(len(rects))
        to_ceilings_m = self.heights_m[rects] - origins_m[:, 2]
        to_sides_m = np.maximum(to_walls_m[rows, axes], 0)
        is_ceiling = to_ceilings_m <= to_sides_m
        rises_m = np.where(is_ceiling, to_ceilings_m, to_sides_m)
        ends_m = origins_m + rises_m[:, None] * np.column_stack([slopes, np.ones(len(rects))])
        entered = self._neighbours(axes, walls_m[rows, axes], slopes[rows, axes] > 0, ends_m)
        return ends_m, np.where(is_ceiling, -1, entered)

    def _neighbours(self, axes, sides_m, is_upper, ends_m):
        """The rectangle beyond each side at the point where the ray meets it; -1: a wall, or a lower ceiling's face."""
        bounds_m = self.areas_m.reshape(-1, 2, 2)  # rectangle, axis, end
        rows = np.arange(len(axes))
        touched_m = bounds_m[:, axes, np.where(is_upper, 0, 1)].T  # (ray, rectangle): the side that would touch
        across_m = bounds_m[:, 1 - axes].transpose(1, 0, 2)  # (ray, rectangle, end)
        along_m = ends_m[rows, 1 - axes][:, None]
        touches = (np.abs(touched_m - sides_m[:, None]) < TOUCHING_M) & (along_m >= across_m[..., 0]) & (along_m < across_m[..., 1])
        first = touches.argmax(axis=1)
        is_open = touches.any(axis=1) & (ends_m[:, 2] < self.heights_m[first])
        return np.where(is_open, first, -1)


def read_true_ceiling(site):
    """None for a recording that is not made up of a ceiling."""
    folder = truth_folder(site)
    if folder is None or not (folder / "ceiling.json").exists() or not (folder.parent / "camera_groundtruth.txt").exists():
        return None
    path = folder / "ceiling.json"
    rectangles = read_object(path, {"rectangles": [RECTANGLE]}, RECORD_AGAIN)["rectangles"]
    if not rectangles:
        raise DataError(f"{path}: no rectangle; {RECORD_AGAIN}")
    areas_m = np.array([[entry[name] for name in ("x0", "x1", "y0", "y1")] for entry in rectangles], float)
    heights_m = np.array([entry["height_m"] for entry in rectangles], float)
    return TrueCeiling(areas_m, heights_m, read_tum(folder.parent / "camera_groundtruth.txt", RECORD_AGAIN))


def read_camera(site):
    """fx, fy ... of the site's one camera."""
    path = site.needed("frames", "cameras")
    cameras = read_object(path, {"cameras": [{"color": CAMERA}]})["cameras"]
    if len(cameras) != 1:
        raise DataError(f"{path}: {len(cameras)} cameras; a map of a ceiling has one")
    if "lens" in cameras[0]["color"]:
        raise DataError(f"{path}: the truth of a ceiling is seen through OpenCV's five coefficients only; use a camera without `lens`, k4, k5, k6")
    return cameras[0]["color"]


def rays_of(camera, pixels):
    """Directions (n, 3) with z = 1 of pixels of the picture, in the camera's frame (the inverse of OpenCV's distortion)."""
    k1, k2, p1, p2, k3 = (camera[name] for name in ("k1", "k2", "p1", "p2", "k3"))
    seen = (np.asarray(pixels, float) - [camera["cx"], camera["cy"]]) / [camera["fx"], camera["fy"]]
    x, y = seen.T
    for _ in range(NUM_ITERATIONS):
        r2 = x * x + y * y
        radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3))
        x, y = ((seen[:, 0] - 2 * p1 * x * y - p2 * (r2 + 2 * x * x)) / radial,
                (seen[:, 1] - 2 * p2 * x * y - p1 * (r2 + 2 * y * y)) / radial)  # fmt: skip
    return np.column_stack([x, y, np.ones(len(x))])


def true_landmarks(ceiling_map, ceiling, camera):
    """(rows of the landmarks whose sighting has a true end, these points (n, 3) in the building, mask of those at an edge).

    At an edge the ray passes a lintel or the frame of a doorway so closely that few pixels decide where it ends."""
    # A time stands once in a trajectory; several landmarks were seen last in one frame.
    times_ns, frame_of = np.unique(ceiling_map.landmark_last_time_ns, return_inverse=True)
    known, poses = interpolated(ceiling.building_from_camera, times_ns, MAX_CAMERA_GAP_NS)
    rows = np.flatnonzero(np.isin(frame_of, known))
    poses = poses.select(np.searchsorted(known, frame_of[rows]))
    pixels = ceiling_map.landmark_last_raw_px[rows]
    rays = (np.einsum("nij,nj->ni", poses.rotations(), rays_of(camera, pixels + offset)) for offset in PIXEL_OFFSETS)
    points_m, *around_m = (ceiling.cast(poses.positions_m, directions) for directions in rays)
    spread_m = np.max([np.linalg.norm(other_m - points_m, axis=1) for other_m in around_m], axis=0)
    has_end = np.isfinite(points_m[:, 0])
    return rows[has_end], points_m[has_end], ~(spread_m[has_end] < EDGE_STEP_M)


def landmark_figures(site, ceiling_map, ceiling, alignments):
    """Errors in the frames of the named alignments (building_from_map), and the share that the map's ellipsoids hold."""
    rows, true_m, is_at_edge = true_landmarks(ceiling_map, ceiling, read_camera(site))
    figures = {"num_judged": len(rows), "num_at_edge": int(is_at_edge.sum()),
               "num_without_true_point": len(ceiling_map.landmark_position_m) - len(rows)}  # fmt: skip
    if len(rows) == 0:
        return figures
    limit = quantile(ELLIPSOID_PROBABILITY, 3)
    for name, building_from_map in alignments.items():
        errors_m = ceiling_map.landmark_position_m[rows] - building_from_map.apply_inverse(true_m)
        distances_m = np.linalg.norm(errors_m, axis=1)
        squared = squared_mahalanobis(errors_m, ceiling_map.landmark_covariance_m2[rows])
        figures[name] = {
            **statistics(distances_m, "error_{}_m", "median", "p90", "max"),
            "error_max_off_edges_m": float(np.max(distances_m[~is_at_edge], initial=0)),
            "height_error_median_m": float(np.median(np.abs(errors_m[:, 2]))),
            "inside_percent": 100 * float(np.mean(squared <= limit)),
        }
    return figures
