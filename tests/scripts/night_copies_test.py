# SPDX-License-Identifier: Apache-2.0
"""tests/bench/night: copies of shards look different, but nothing within a copy changes; a copy's first frame sees what the last one of
the copy before saw; places and truth of a composed site follow from the source's."""

import csv

import numpy as np

from folder_case import FolderTest  # first: it makes scripts and benchmarks importable

from nightmap_eval.trajectory import Trajectory
from nightmap_site.script_errors import DataError
from night import copies, score
from night.compose import Composer, write_tum
from night.source import Source, Table, matrices, read_table

NUM_FRAMES, NUM_FEATURES = 4, 60  # of a shard, of which frames 0 and 3 are described; of a frame
HEADER = "frame_idx,time_ns,camera_idx,sequence_idx,color_path,color_hash,depth_path,depth_hash".split(",")
CAMERA = ('{"cameras": [{"color": {"width": 640, "height": 480, "fx": 500.0, "fy": 500.0, "cx": 319.5, "cy": 239.5, '
          '"k1": 0.0, "k2": 0.0, "p1": 0.0, "p2": 0.0, "k3": 0.0}}]}')  # fmt: skip
LEVEL = np.array([-0.5, 0.5, -0.5, 0.5])  # looks along x, its y axis down


def a_table(**arrays):
    return Table(arrays, {"format": np.bytes_("nightmap test"), "version": np.int32(1)})


def shard_features(first_frame, rng):
    count = NUM_FRAMES * NUM_FEATURES
    pixels = rng.uniform([0, 0], [639, 479], (count, 2)).astype(np.float32)
    reference = np.array([[-1], [first_frame], [first_frame], [-1]], np.int32)
    return a_table(
        frame_idx=np.arange(first_frame, first_frame + NUM_FRAMES, dtype=np.int32)[:, None], reference_frame_idx=reference,
        first_feature=np.arange(0, count + 1, NUM_FEATURES, dtype=np.int32)[:, None], keypoint_px=pixels, raw_keypoint_px=pixels,
        scale_px=np.full((count, 1), 4, np.float32), depth_m=rng.uniform(1, 4, (count, 1)).astype(np.float32),
        descriptor=rng.integers(0, 256, (2 * NUM_FEATURES, 128)).astype(np.uint8),
        reference_feature=np.zeros((2 * NUM_FEATURES, 1), np.int32),
    )  # fmt: skip


def distances(descriptors):
    return np.linalg.norm(descriptors[:, None].astype(float) - descriptors[None], axis=2)


class CopiesTest(FolderTest):
    def setUp(self):
        self.features = shard_features(0, np.random.default_rng(1))

    def test_distances_within_a_copy_are_those_of_the_source_and_those_to_another_copy_are_not(self):
        source = self.features["descriptor"]
        copy, other = (copies.repainted(self.features, copies.permutation(0, number))["descriptor"] for number in (1, 2))
        np.testing.assert_array_equal(distances(copy), distances(source))
        self.assertGreater(np.linalg.norm(copy.astype(float) - other, axis=1).min(), 200)
        np.testing.assert_array_equal(copies.permutation(0, 0), np.arange(128))
        np.testing.assert_array_equal(copies.permutation(0, 1), copies.permutation(0, 1))

    def test_another_visit_sees_the_same_a_little_differently(self):
        again = copies.noised(self.features, np.random.default_rng(2))
        moved_px = again["keypoint_px"] - self.features["keypoint_px"]
        self.assertAlmostEqual(float(np.std(moved_px)), copies.NOISE_PX, delta=0.03)
        np.testing.assert_allclose(again["raw_keypoint_px"] - self.features["raw_keypoint_px"], moved_px, atol=1e-4)
        self.assertLess(np.abs(again["depth_m"] / self.features["depth_m"] - 1).max(), 0.02)
        self.assertLess(np.abs(again["descriptor"].astype(int) - self.features["descriptor"]).max(), 20)

    def test_the_first_frame_sees_points_of_the_frame_before_behind_its_own(self):
        class Camera:
            focal_px, centre_px, size_px = np.array([500.0, 500.0]), np.array([319.5, 239.5]), np.array([640, 480])

        after, ahead = shard_features(4, np.random.default_rng(3)), np.eye(4)
        ahead[2, 3] = -0.5  # the next camera is half a metre ahead
        both, is_joined = copies.joined(after, self.features, {0: ahead}, Camera, np.random.default_rng(4))
        added = np.count_nonzero(is_joined)
        self.assertGreater(added, NUM_FEATURES // 3)
        rows, pixels, depths_m = copies.seen_from(self.features, 3, ahead, Camera, np.random.default_rng(4))
        centred = (self.features["keypoint_px"][rows] - Camera.centre_px) * (1 + 0.5 / depths_m[:, None])
        self.assertLess(np.abs(pixels - Camera.centre_px - centred).max(), 6 * copies.JOINT_SIGMA_PX)
        own = slice(0, NUM_FEATURES)
        np.testing.assert_array_equal(both["keypoint_px"][own], after["keypoint_px"][own])
        np.testing.assert_array_equal(both["keypoint_px"][NUM_FEATURES + added :], after["keypoint_px"][NUM_FEATURES:])
        np.testing.assert_array_equal(np.diff(both["first_feature"][:, 0]), [NUM_FEATURES + added, *[NUM_FEATURES] * 3])
        order, order_before = copies.permutation(0, 2), copies.permutation(0, 1)
        looks = copies.repainted(both, order, is_joined, order_before)["descriptor"]
        np.testing.assert_array_equal(looks[own], after["descriptor"][own][:, order])
        seen = self.features["descriptor"][NUM_FEATURES:][rows - 3 * NUM_FEATURES][:, order_before]
        np.testing.assert_array_equal(looks[NUM_FEATURES : NUM_FEATURES + added], seen)
        np.testing.assert_array_equal(looks[NUM_FEATURES + added :], after["descriptor"][NUM_FEATURES:][:, order])
        both, is_joined = copies.joined(after, self.features, {0: ahead, 3: ahead}, Camera, np.random.default_rng(4))
        counts = np.diff(both["first_feature"][:, 0]) - NUM_FEATURES
        self.assertEqual((counts[0] + counts[3], *counts[1:3]), (np.count_nonzero(is_joined), 0, 0))
        for frame in (0, 3):
            own = copies.rows_of(both, frame).start + np.arange(NUM_FEATURES)
            np.testing.assert_array_equal(both["keypoint_px"][own], after["keypoint_px"][copies.rows_of(after, frame)])

    def test_shifted_indices(self):
        features = copies.shifted_features(self.features, 10)
        np.testing.assert_array_equal(features["reference_frame_idx"][:, 0], [-1, 10, 10, -1])
        odometry = a_table(frame_idx=np.array([[4]]), edge_frame=np.array([[3, 4]]), observation=np.array([[7, 3, 5]]))
        odometry = copies.shifted_odometry(odometry, 10)
        self.assertEqual(odometry["observation"].tolist(), [[7, 13, 5]])
        self.assertEqual((odometry["edge_frame"].tolist(), odometry["frame_idx"].tolist()), ([[13, 14]], [[14]]))


class StubPrograms:
    """Programs that find one edge to the frame before."""

    def run(self, program, inputs, outputs, folder, **_):
        folder.mkdir(exist_ok=True)
        shard = read_table(inputs["features"][-1])["frame_idx"]
        [name] = outputs.values()
        motion(shard[0, 0], len(inputs["features"]) == 1).write(folder / name)


def motion(first_frame, is_start=False):
    frames = np.arange(first_frame, first_frame + NUM_FRAMES, dtype=np.int32)
    edge = np.array([[first_frame if is_start else first_frame - 1, first_frame + is_start]], np.int32)
    return a_table(frame_idx=frames[:, None], frame=edge, edge_frame=edge, edge_is_bridge=np.zeros((1, 1), np.uint8),
                   observation=np.array([[0, first_frame, 0]], np.int32))  # fmt: skip


class ComposerTest(FolderTest):
    """A source of three shards along a straight way; a unit is the last two."""

    def setUp(self):
        source, rng, count = self.folder / "source", np.random.default_rng(5), 3 * NUM_FRAMES
        for job in ("frames", "features", "matches", "odometry"):
            (source / job).mkdir(parents=True)
        self.truth = Trajectory(10**9 * np.arange(1, count + 1), np.c_[0.1 * np.arange(count), np.zeros(count), np.ones(count)],
                                np.tile(LEVEL, (count, 1)))  # fmt: skip
        write_tum(source / "frames/ground_truth.tum", self.truth)
        self.write("source/frames/shards.txt", "nightmap shards, version 1, 3 names\n0000\n0001\n0002\n")
        self.write("source/frames/cameras.json", CAMERA)
        self.write("source/frames/acceleration.h5", "")
        for shard in range(3):
            rows = [[frame, 10**9 * (frame + 1), 0, 0, f"rgb/{frame}.jpg", "ab", f"depth/{frame}.png", "cd"]
                    for frame in range(shard * NUM_FRAMES, (shard + 1) * NUM_FRAMES)]  # fmt: skip
            with open(source / f"frames/shard_{shard:04}.csv", "w", encoding="utf-8", newline="") as file:
                csv.writer(file, lineterminator="\n").writerows([HEADER, *rows])
            shard_features(shard * NUM_FRAMES, rng).write(source / f"features/shard_{shard:04}.h5")
            for job in ("matches", "odometry"):
                motion(shard * NUM_FRAMES, shard == 0).write(source / f"{job}/shard_{shard:04}.h5")
        self.source = Source(source)
        self.composer = Composer(self.source, (1, 2), 2 * 5 * NUM_FRAMES, StubPrograms())
        self.site = self.folder / "site"
        self.composed = self.composer.write(self.site)

    def test_frames_count_up_in_time_and_no_picture_is_twice(self):
        rows = []
        for path in sorted((self.site / "frames").glob("*.csv")):
            rows += list(csv.DictReader(path.read_text().splitlines()))
        self.assertEqual([int(row["frame_idx"]) for row in rows], list(range(10 * NUM_FRAMES)))
        self.assertTrue(np.all(np.diff([int(row["time_ns"]) for row in rows]) > 0))
        self.assertEqual(len({row["color_path"] for row in rows}), len(rows))
        self.assertEqual([int(row["sequence_idx"]) for row in rows], [0] * 5 * NUM_FRAMES + [1] * 5 * NUM_FRAMES)
        self.assertEqual([int(row["time_ns"]) for row in rows], self.composed.times_ns.tolist())

    def test_the_way_goes_on_as_in_the_source_and_comes_back(self):
        first, second = self.composed.positions_m[: 5 * NUM_FRAMES], self.composed.positions_m[5 * NUM_FRAMES :]
        np.testing.assert_array_equal(first, second)
        # 0.1 m a frame; 0.3 m, the step between described frames, from a copy to the next.
        steps_m = np.full(5 * NUM_FRAMES - 1, 0.1)
        steps_m[[2 * NUM_FRAMES - 1, 4 * NUM_FRAMES - 1]] = 0.3
        np.testing.assert_allclose(np.linalg.norm(np.diff(first, axis=0), axis=1), steps_m, atol=1e-6)
        np.testing.assert_allclose(first[:, 2], 1)
        np.testing.assert_array_equal(self.composer.copy_of_frames()[: 5 * NUM_FRAMES], np.arange(5 * NUM_FRAMES) // (2 * NUM_FRAMES))

    def test_motion_belongs_to_the_frames_of_its_shard(self):
        for number in range(10):
            expected = motion(number * NUM_FRAMES, number == 0)
            for job, names in {"matches": ["frame"], "odometry": ["edge_frame", "frame_idx", "observation"]}.items():
                table = read_table(self.site / job / f"shard_{number:04}.h5")
                for name in names:
                    np.testing.assert_array_equal(table[name], expected[name], f"{job} {number}")
            frames = read_table(self.site / f"features/shard_{number:04}.h5")["frame_idx"][:, 0]
            np.testing.assert_array_equal(frames, np.arange(NUM_FRAMES) + number * NUM_FRAMES)

    def test_a_pair_that_measures_the_truth_is_true_and_one_between_copies_is_not(self):
        poses = matrices(self.composed)
        frames = np.array([[3, 5 * NUM_FRAMES + 3], [3, 7 * NUM_FRAMES + 3]])
        b_from_a = np.linalg.inv(poses[frames[0, 1]]) @ poses[frames[0, 0]]
        measured = np.tile([*b_from_a[:3, 3], 0, 0, 0, 1], (2, 1))
        self.assertEqual(score.true_pairs(frames, measured, self.composed).tolist(), [True, False])

    def test_the_unit_leads_farthest_within_the_shards_that_it_may_have(self):
        self.assertEqual(self.source.choose_unit(3), (0, 2))
        first, last = self.source.choose_unit(2)  # on this way all of two shards are alike
        self.assertEqual(last - first, 1)

    def test_a_unit_whose_copies_no_measured_motion_joins_is_refused(self):
        class Bridging(StubPrograms):
            def run(self, program, inputs, outputs, folder, **_):
                super().run(program, inputs, outputs, folder)
                path = folder / next(iter(outputs.values()))
                read_table(path).with_arrays(edge_is_bridge=[1]).write(path)

        with self.assertRaisesRegex(DataError, "no measured motion leads from shard 0002 to shard 0001"):
            Composer(self.source, (1, 2), 40, Bridging()).write(self.folder / "other")
