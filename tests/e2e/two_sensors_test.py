# SPDX-License-Identifier: Apache-2.0
"""One building, two sensors: the places of the demo's query pictures, asked for again by laser scans in the map of demo_laser.
A picture and a scan that are located at one place must agree. Maps are kept in <build>/accuracy: after demo_test, this test takes
seconds.

The scans are cast here, in the true boxes of the building, and share no code with the scanner of synthesize.
"""
import json
import sys
import unittest

import numpy as np

import accuracy
from workspace import REPOSITORY, read_csv

sys.path.append(str(REPOSITORY / "scripts"))
from nightmap_eval.trajectory import associate, planar_umeyama, read_tum, umeyama  # noqa: E402

DATA = accuracy.FOLDER / "data"
QUERIES = accuracy.FOLDER / "two_sensors.log"
# The laser as configs/sites/demo_laser has it; it stands still.
LASER_HEIGHT_M, NUM_BEAMS, MAX_RANGE_M = 0.3, 360, 30.0
NOISE_M, NOISE_PER_M, MISS_RATIO = 0.01, 0.002, 0.005
MAX_APART_M, MAX_TURN_DEG = 0.05, 1.0
MIN_AGREE_PERCENT = 95
FIRST_S = 5000


def boxes_at_height(truth, height_m):
    """Rectangles of the boxes that a level plane cuts: centres (n, 2), half sizes (n, 2), yaw (n). Metres, rad."""
    boxes = [box for box in json.loads(truth.read_text())["boxes"]
             if abs(box["center_m"][2] - height_m) < box["half_size_m"][2]]
    return [np.array([box[key] for box in boxes]) for key in ("center_m", "half_size_m", "yaw_rad")]


def ranges_m(boxes, place, heading_rad):
    """Distance to the nearest box of each beam from -180 degrees of the heading on, counter-clockwise; infinite: none."""
    centers, halves, yaws_rad = boxes
    bearings_rad = heading_rad - np.pi + 2 * np.pi * np.arange(NUM_BEAMS) / NUM_BEAMS

    def in_boxes(x, y):
        cos, sin = np.cos(yaws_rad)[:, None], np.sin(yaws_rad)[:, None]
        return np.stack([cos * x + sin * y, cos * y - sin * x], axis=2)

    from_m = in_boxes(*(place - centers[:, :2]).T[:, :, None])  # (n, 1, 2)
    beams = in_boxes(np.cos(bearings_rad)[None], np.sin(bearings_rad)[None])  # (n, beams, 2)
    with np.errstate(divide="ignore"):
        sides = np.stack([(sign * halves[:, None, :2] - from_m) / beams for sign in (-1, 1)])
    enter, leave = sides.min(axis=0).max(axis=2), sides.max(axis=0).min(axis=2)
    return np.where((enter < leave) & (enter > 0), enter, np.inf).min(axis=0)


def scan_line(boxes, index, place, heading_rad):
    """A line FLASER of a CARMEN log, with the noise of the scanner."""
    rng = np.random.default_rng([5, index])
    exact_m = ranges_m(boxes, place, heading_rad)
    is_missed = (rng.uniform(size=NUM_BEAMS) < MISS_RATIO) | (exact_m > MAX_RANGE_M)
    near_m = np.where(is_missed, 0, exact_m)
    measured_m = np.where(is_missed, MAX_RANGE_M, near_m + (NOISE_M + NOISE_PER_M * near_m) * rng.normal(size=NUM_BEAMS))
    ranges = " ".join(f"{range_m:.3f}" for range_m in measured_m)
    return f"FLASER {NUM_BEAMS} {ranges} 0 0 0 0 0 0 {FIRST_S + index} robot {FIRST_S + index}\n"


def headings_rad(rotations, axis):
    """Where an axis of each frame points on the floor."""
    return np.arctan2(rotations[:, 1, axis], rotations[:, 0, axis])


def turn_deg(first_rad, second_rad):
    return np.abs(np.degrees((first_rad - second_rad + np.pi) % (2 * np.pi) - np.pi))


def world_from_map(map_poses, truth, align):
    """The alignment of all poses of a map with their truth; queries take no part."""
    pairs = associate(map_poses.times_ns, truth.times_ns, 1000)
    if len(pairs) != len(map_poses):
        raise AssertionError(f"{len(map_poses) - len(pairs)} poses of the map have no truth")
    return align(map_poses.positions_m[pairs[:, 0]], truth.positions_m[pairs[:, 1]], False)


class Located:
    """Results of localize, in the world, by row of queries.csv: place (m), heading (rad). `axis` of a frame points ahead."""

    def __init__(self, site_dir, truth, align, axis):
        self.rows = read_csv(site_dir / "localize/queries.csv")
        self.located = [i for i, row in enumerate(self.rows) if row["status"] == "located"]
        move = world_from_map(read_tum(site_dir / "map_frame/trajectory.tum"), truth, align)
        poses = read_tum(site_dir / "localize/queries.tum")  # of the located, by time
        if len(poses) != len(self.located):
            raise AssertionError(f"{site_dir}: {len(poses)} poses of {len(self.located)} located queries")
        headings = headings_rad(move.rotation @ poses.rotations(), axis)
        self.place_m = dict(zip(self.located, move.apply(poses.positions_m)[:, :2]))
        self.heading_rad = dict(zip(self.located, headings))


class TwoSensorsTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        pictures_dir = accuracy.make("demo", DATA, "map", "localize")
        accuracy.make("demo_laser", DATA, "map")
        cls.truth = read_tum(DATA / "demo/queries/groundtruth.txt")
        cls.true_heading_rad = headings_rad(cls.truth.rotations(), 2)
        boxes = boxes_at_height(DATA / "demo_laser/truth/boxes.json", LASER_HEIGHT_M)
        places = zip(cls.truth.positions_m[:, :2], cls.true_heading_rad)
        QUERIES.write_text("".join(scan_line(boxes, i, *place) for i, place in enumerate(places)))
        scans_dir = accuracy.make("demo_laser", DATA, "localize", f"QUERY={QUERIES}")
        cls.pictures = Located(pictures_dir, read_tum(DATA / "demo/groundtruth.txt"), umeyama, 2)
        cls.scans = Located(scans_dir, read_tum(DATA / "demo_laser/robot_groundtruth.txt"), planar_umeyama, 0)

    def test_it_is_one_building(self):
        demo, laser = (json.loads((DATA / site / "truth/boxes.json").read_text()) for site in ("demo", "demo_laser"))
        self.assertGreater(len(demo["boxes"]), 100)
        self.assertEqual(demo["boxes"], laser["boxes"])

    def test_the_scans_cast_here_are_those_of_the_scanner(self):
        """Along the way of the robot of demo_laser, but for what it does not see and the people who walk by."""
        scans = [line.split() for line in (DATA / "demo_laser/robot.log").read_text().splitlines() if line.startswith("FLASER ")]
        truth = read_tum(DATA / "demo_laser/robot_groundtruth.txt")
        self.assertEqual(len(scans), len(truth))
        boxes = boxes_at_height(DATA / "demo_laser/truth/boxes.json", LASER_HEIGHT_M)
        rows = range(0, len(scans), 20)
        headings = headings_rad(truth.rotations(), 0)
        cast_m = np.array([ranges_m(boxes, truth.positions_m[i, :2], headings[i]) for i in rows])
        off_m = np.abs(np.array([scans[i][2:2 + NUM_BEAMS] for i in rows], dtype=float) - cast_m)
        self.assertGreater(np.mean(off_m < 0.08), 0.9)
        self.assertLess(np.median(off_m), 0.02)

    def test_most_are_located(self):
        for located in (self.pictures, self.scans):
            self.assertEqual(len(located.rows), len(self.truth))
        self.assertGreaterEqual(len(self.pictures.located), 0.9 * len(self.truth))
        self.assertGreaterEqual(len(self.scans.located), 0.6 * len(self.truth))

    def test_a_picture_and_a_scan_of_one_place_agree(self):
        both = sorted(set(self.pictures.located) & set(self.scans.located))
        self.assertGreaterEqual(len(both), 0.5 * len(self.truth))
        apart_m = np.array([np.linalg.norm(self.pictures.place_m[i] - self.scans.place_m[i]) for i in both])
        turned_deg = turn_deg(*(np.array([sensor.heading_rad[i] for i in both]) for sensor in (self.pictures, self.scans)))
        agree = (apart_m <= MAX_APART_M) & (turned_deg <= MAX_TURN_DEG)
        worst = [f"{i}: {apart_m[k]:.3f} m, {turned_deg[k]:.2f} deg" for k, i in enumerate(both) if not agree[k]]
        self.assertGreaterEqual(100 * np.mean(agree), MIN_AGREE_PERCENT, worst)

    def test_no_scan_is_located_in_a_wrong_place(self):
        for sensor in (self.pictures, self.scans):
            for i in sensor.located:
                self.assertLess(np.linalg.norm(sensor.place_m[i] - self.truth.positions_m[i, :2]), 0.5, (i, sensor.rows[i]))
