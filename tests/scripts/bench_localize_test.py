# SPDX-License-Identifier: Apache-2.0
"""bench_localize.py: maps padded to a size are as real ones would be, and what is timed."""

from unittest.mock import patch

import h5py
import numpy as np

import fake_site
import padded_map
from folder_case import FolderTest
from nightmap_eval.sealed_hdf5 import sealed
from nightmap_site.script_errors import DataError

NUM_LANDMARKS, NUM_KEYFRAMES, NUM_FRAMES = 60, 4, 6
NODES = [[1, 3, 0], [4, 2, 1], [0, 0, 1], [6, 2, 1], [0, 0, 2], [0, 0, 2], [0, 0, 2], [0, 0, 2]]

# Stands for the program: two queries, of which the second is not located in maps of 100 landmarks
# or more; a millisecond for each ten landmarks.
LOCALIZE = """#!/usr/bin/python3
import json, sys
import h5py
paths = dict(argument.split("=", 1) for argument in sys.argv if "=" in argument)
outs = [a.split("=", 1) for flag, a in zip(sys.argv, sys.argv[1:]) if flag == "--out"]
out = dict(outs)
landmarks = [a for a in sys.argv if a.startswith("landmarks=")][0].split("=", 1)[1]
size = int(h5py.File(landmarks)["regions/num_landmarks"][:].sum())
assert len(h5py.File(paths["vocabulary"])["frames/word_offsets"]) >= 7
parts = [["read", 1], ["extract", 0.1], ["locate", 0.0001 * size], ["extract", 0.1], ["locate", 0.0001 * size]]
json.dump({"parts": [{"name": n, "wall_time_s": 9, "cpu_time_s": s} for n, s in parts]}, open(out["receipt"], "w"))
rows = ["query_idx,status,tx_m,ty_m,tz_m", f"0,located,{0.001 * size},0,0"]
rows.append("1,located,1,2,3" if size < 100 else "1,not_in_map,,,")
open(out["queries"], "w").write("\\n".join(rows) + "\\n")
"""


def write(path, attributes, arrays):
    path.parent.mkdir(parents=True, exist_ok=True)
    with sealed(path) as file:
        file.attrs["format"] = attributes
        for name, values in arrays.items():
            file[name] = values.reshape(len(values), -1)


def write_site(site_dir, seed=0, kind=0):
    """Each landmark has one or two descriptors and is seen by one or two of the keyframes."""
    rng = np.random.default_rng(seed)
    of = np.sort(np.r_[np.arange(NUM_LANDMARKS), rng.permutation(NUM_LANDMARKS)[:20]])
    descriptors = np.minimum(255, 45 * np.abs(rng.normal(size=(len(of), 128)))).astype(np.uint8)
    counts = rng.integers(1, 3, NUM_LANDMARKS)
    seen = [np.sort(rng.permutation(NUM_KEYFRAMES)[:count]) for count in counts]
    poses = np.tile([0, 0, 0, 0, 0, 0, 1.0], (NUM_KEYFRAMES, 1))
    centres = np.minimum(255, 45 * np.abs(rng.normal(size=(len(NODES), 128)))).astype(np.uint8)
    write(site_dir / "landmarks" / "landmarks.h5", "nightmap.landmarks", {
        "kind": np.array([kind], np.int32), "regions/num_landmarks": np.array([NUM_LANDMARKS], np.int64),
        "region_0/landmarks/position_in_map_m": rng.normal(size=(NUM_LANDMARKS, 3)),
        "region_0/landmarks/position_sigma_m": np.full(NUM_LANDMARKS, 0.01, np.float32),
        "region_0/descriptors/values": descriptors, "region_0/descriptors/landmark_idx": of.astype(np.int32),
        "region_0/descriptors/words": np.zeros((len(of), 2), np.int32),
        "keyframes/frame_idx": np.array([0, 2, 3, 5], np.int32),
        "keyframes/time_ns": np.array([10, 20, 30, 40], np.int64), "keyframes/map_from_camera": poses,
        "region_0/observations/offsets": np.r_[0, np.cumsum(counts)],
        "region_0/observations/keyframe_idx": np.concatenate(seen).astype(np.int32),
        "region_0/observations/feature_idx": np.zeros(sum(counts), np.int32),
    })  # fmt: skip
    write(site_dir / "vocabulary" / "vocabulary.h5", "nightmap.vocabulary", {
        "tree/kind": np.array([0], np.int32), "tree/depth": np.array([2], np.int32),
        "tree/nodes": np.array(NODES, np.int32), "tree/centres": centres,
        "frames/word_offsets": np.arange(NUM_FRAMES + 1) * 5,
        "frames/words": rng.integers(2, 8, 5 * NUM_FRAMES).astype(np.int32),
    })  # fmt: skip


def brute_force_path(descriptor, nodes, centres):
    """Down to the nearest child, in integers; the leaf repeated."""
    path, at = [], 0
    for _ in range(2):
        first, num_children, _ = nodes[at]
        children = range(first, first + num_children)
        if num_children:
            at = min(children, key=lambda node: int(((descriptor.astype(int) - centres[node]) ** 2).sum()))
        path.append(at)
    return path


class PaddedMapTest(FolderTest):
    def setUp(self):
        self.site = self.folder / "site"
        write_site(self.site)
        self.real = padded_map.read_map(self.site / "landmarks" / "landmarks.h5")
        self.rng = np.random.default_rng(1)

    def test_a_thinned_map_keeps_what_belongs_together(self):
        thinned = padded_map.thin(self.real, 25, self.rng)
        self.assertEqual(len(thinned), 25)
        for new, position_m in enumerate(thinned.positions_m):
            old = int(np.flatnonzero((self.real.positions_m == position_m).all(axis=1))[0])
            for name in ("descriptors", "seen"):
                before, after = getattr(self.real, name), getattr(thinned, name)
                if name == "descriptors":
                    before, after = before[self.real.landmark_idxs == old], after[thinned.landmark_idxs == new]
                else:
                    before, after = before[before[:, 0] == old, 1], after[after[:, 0] == new, 1]
                np.testing.assert_array_equal(before, after)

    def test_a_padded_map_is_the_real_one_and_other_points(self):
        base = padded_map.thin(self.real, 30, self.rng)
        padded = padded_map.pad(base, self.real, [], 200, self.rng)
        self.assertEqual(len(padded), 200)
        np.testing.assert_array_equal(padded.positions_m[:30], base.positions_m)
        np.testing.assert_array_equal(padded.descriptors[: len(base.descriptors)], base.descriptors)
        self.assertTrue((np.diff(padded.landmark_idxs) >= 0).all())
        self.assertEqual(set(padded.landmark_idxs), set(range(200)))
        self.assertEqual(padded.seen[:, 1].max(), len(padded.poses) - 1)
        self.assertTrue((np.diff(padded.seen[:, 0]) >= 0).all())
        self.assertAlmostEqual(padded.seen_per_keyframe() / base.seen_per_keyframe(), 1, delta=0.25)
        # No added landmark looks like a real one, as it would in a mere copy.
        added = padded.descriptors[len(base.descriptors) :].astype(int)
        nearest = [np.sqrt(((added - one) ** 2).sum(axis=1)).min() for one in base.descriptors.astype(int)]
        self.assertGreater(min(nearest), 0.4 * padded_map.NORM)

    def test_another_building_is_copied_as_it_is_first(self):
        write_site(self.folder / "other", seed=5)
        other = padded_map.read_map(self.folder / "other" / "landmarks" / "landmarks.h5")
        padded = padded_map.pad(self.real, self.real, [other], 2 * NUM_LANDMARKS, self.rng)
        added = padded.descriptors[len(self.real.descriptors) :]
        self.assertEqual(set(map(bytes, added)), set(map(bytes, other.descriptors)))

    def test_a_shuffled_landmark_looks_like_another_one(self):
        shuffled = padded_map.shuffled(self.real, self.rng)
        before, after = ([set(map(bytes, sparse.descriptors[sparse.landmark_idxs == i])) for i in range(NUM_LANDMARKS)]
                         for sparse in (self.real, shuffled))  # fmt: skip
        self.assertCountEqual(map(sorted, after), map(sorted, before))
        self.assertFalse(any(map(set.intersection, before, after)))
        np.testing.assert_array_equal(shuffled.landmark_idxs, np.sort(shuffled.landmark_idxs))
        np.testing.assert_array_equal(shuffled.positions_m, self.real.positions_m)

    def test_no_copy_shows_a_place_of_the_real_map(self):
        padded = padded_map.pad(self.real, self.real, [], 3 * NUM_LANDMARKS, self.rng)
        first = np.searchsorted(padded.landmark_idxs, np.arange(len(padded)))
        looks = padded.descriptors[first].astype(float).reshape(3, NUM_LANDMARKS, 128)
        apart = np.linalg.norm(looks[0] - np.roll(looks[0], 1, axis=0), axis=1).mean()
        for copy in looks[1:]:  # at the same points, as alike as two landmarks of the map
            self.assertGreater(np.linalg.norm(looks[0] - copy, axis=1).mean(), 0.9 * apart)

    def test_half_of_a_mixed_descriptor_is_anothers(self):
        mixed = padded_map.mixed(self.real, self.rng)
        norms = np.linalg.norm(mixed.descriptors.astype(float), axis=1)
        self.assertLess(abs(norms - padded_map.NORM).max(), 8)
        of, to = mixed.descriptors.reshape(-1, 16, 8), self.real.descriptors.reshape(-1, 16, 8)
        cosine = (of.astype(float) * to).sum(axis=2) / np.linalg.norm(of, axis=2) / np.linalg.norm(to, axis=2)
        self.assertTrue(((cosine > 0.998).sum(axis=1) >= 8).all())
        self.assertLess(np.median((cosine > 0.998).sum(axis=1)), 10)

    def test_words_are_those_of_the_tree(self):
        with h5py.File(self.site / "vocabulary" / "vocabulary.h5") as file:
            paths = padded_map.word_paths(file["tree"], self.real.descriptors)
            nodes, centres = file["tree/nodes"][:], file["tree/centres"][:].astype(int)
        expected = [brute_force_path(one, nodes, centres) for one in self.real.descriptors]
        self.assertEqual(paths.tolist(), expected)
        self.assertGreater(len(set(paths[:, 1])), 2)

    @patch.object(padded_map, "REGION_LANDMARKS", 70)
    def test_files_hold_the_added_keyframes_as_frames_of_their_own(self):
        out = self.site / "padded"
        out.mkdir()
        padded = padded_map.pad(self.real, self.real, [], 150, self.rng)
        vocabulary = self.site / "vocabulary" / "vocabulary.h5"
        with h5py.File(vocabulary) as file:
            paths = padded_map.write_map(
                self.site / "landmarks" / "landmarks.h5", file, padded, NUM_KEYFRAMES, out / "landmarks.h5"
            )
        padded_map.write_vocabulary(vocabulary, padded, paths[:, -1], NUM_KEYFRAMES, out / "vocabulary.h5", self.rng)
        with h5py.File(out / "landmarks.h5") as landmarks:
            num_regions = len(landmarks["regions/min_m"])
            x_m = [landmarks[f"region_{i}/landmarks/position_in_map_m"][:, 0] for i in range(num_regions)]
            self.assertEqual([len(of_region) for of_region in x_m], [120, 30])  # the base with a copy, and another
            for of_region, least_m, most_m in zip(x_m, landmarks["regions/min_m"][:, 0], landmarks["regions/max_m"][:, 0]):
                self.assertTrue(((least_m <= of_region) & (of_region < most_m)).all())
        again = padded_map.read_map(out / "landmarks.h5")
        np.testing.assert_array_equal(again.seen, padded.seen)
        np.testing.assert_array_equal(again.descriptors, padded.descriptors)
        with h5py.File(out / "landmarks.h5") as landmarks, h5py.File(out / "vocabulary.h5") as words:
            self.assertEqual(landmarks.attrs["format"], "nightmap.landmarks")
            frames = np.ravel(landmarks["keyframes/frame_idx"])
            self.assertEqual(frames.tolist(), [0, 2, 3, 5, *range(6, 2 + len(padded.poses))])
            counts = np.diff(np.ravel(words["frames/word_offsets"]))
            self.assertEqual(len(counts), NUM_FRAMES + len(padded.poses) - NUM_KEYFRAMES)
            self.assertEqual(counts.sum(), len(words["frames/words"]))
            self.assertGreaterEqual(counts.min(), 5)
            self.assertEqual(len(words["postings/frame_idx"]), np.ravel(words["postings/begins"])[-1])

    def test_postings_are_tf_idf_of_unit_length(self):
        frames = [[2, 5, 2], [5], [], [3, 5, 3, 3]]
        offsets = np.r_[0, np.cumsum([len(frame) for frame in frames])]
        begins, of, weights = padded_map.postings(offsets, np.concatenate(frames).astype(int))
        self.assertEqual(begins.tolist(), [0, 0, 0, 1, 2, 2, 5])
        self.assertEqual(of.tolist(), [0, 3, 0, 1, 3])
        rare, common = np.log(5 / 1), np.log(5 / 3)
        expected = [2 * rare / np.hypot(2 * rare, common), 3 * rare / np.hypot(3 * rare, common),
                    common / np.hypot(2 * rare, common), 1, common / np.hypot(3 * rare, common)]  # fmt: skip
        np.testing.assert_allclose(weights, expected, rtol=1e-6)

    def test_other_descriptors_are_refused(self):
        write_site(self.site, kind=1)
        with self.assertRaisesRegex(DataError, "landmarks.h5: made with another detector"):
            padded_map.read_map(self.site / "landmarks" / "landmarks.h5")


class BenchLocalizeTest(FolderTest):
    def setUp(self):
        write_site(self.folder / "site")
        write_site(self.folder / "donor", seed=5)
        (self.folder / "build" / "run").mkdir(parents=True)
        self.program(LOCALIZE)

    def program(self, text):
        path = self.write("build/run/localize", text)
        path.chmod(0o755)

    def run_bench(self, *arguments):
        return fake_site.run(
            "bench_localize.py", self.folder / "site", "--data", self.folder, "--build", self.folder / "build",
            *arguments,
        )  # fmt: skip

    def test_a_row_for_each_size(self):
        result = self.run_bench("--sizes", 120, 40, "--repeats", 2, "--donor", self.folder / "donor")
        self.assertEqual(result.returncode, 0, result.stderr)
        rows = [[cell.strip() for cell in line.strip("|\n").split("|")] for line in result.stdout.splitlines()]
        rows = [dict(zip(rows[0], row)) for row in rows[2:]]
        # Two queries: 200 ms to describe, 8 ms (24 ms) to locate.
        self.assertEqual([row["landmarks"] for row in rows], ["40", "120"])
        self.assertEqual([row["extract (CPU ms)"] for row in rows], ["100.0", "100.0"])
        self.assertEqual([row["locate (CPU ms)"] for row in rows], ["4.0", "12.0"])
        self.assertEqual([row["both / extract"] for row in rows], ["1.04", "1.12"])
        self.assertEqual([row["both / smallest"] for row in rows], ["1.00", "1.08"])
        self.assertEqual([row["located"] for row in rows], ["2 of 2", "1 of 2"])
        self.assertEqual([row["moved"] for row in rows], ["0", "1"])  # by 80 mm

    def test_the_table_goes_into_the_page(self):
        page = self.write("figures.md", "a\n<!-- bench_localize:begin -->\nold\n<!-- bench_localize:end -->\nb\n")
        self.assertEqual(self.run_bench("--sizes", 40, "--repeats", 1, "--page", page).returncode, 0)
        self.assertIn("| 40 |", page.read_text())
        self.assertNotIn("old", page.read_text())

    def test_failures_are_told(self):
        self.program("#!/bin/sh\necho no such camera\nexit 1\n")
        self.check_failed(self.run_bench("--sizes", 40), "no such camera")
        self.assertEqual(self.run_bench("--sizes", 0).returncode, 2)
