#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""The profile moving with labels, whole, on the small building: a board labelled as a person passes before the camera and is in no
pose, feature or map; what is an object may move by its label, stands, and is in all of them; the map has classes, things and located queries."""
import csv
import json
import unittest

import h5py
import moving_test
import numpy as np
from labels_test import CLASSES, unpacked
from PIL import Image
from workspace import SITE

PERSON, OBJECT = len(CLASSES), CLASSES.index("object")
MODEL = f"classes = {json.dumps([*CLASSES, 'person'])}\nmoving = [\"person\", \"object\"]\n"


class PeopleTest(moving_test.BoardTest):
    keys = moving_test.BoardTest.keys + 'label_folder = "labels"\n'
    tables = '\n[import]\nmodel = "model.toml"\n'

    @classmethod
    def setUpClass(cls):
        cls.record()
        (cls.work.folder / "data/model.toml").write_text(MODEL)
        for path in sorted((cls.work.data() / "moving").glob("*.png")):
            labels = path.parent.parent / "labels" / path.name
            Image.fromarray(np.where(np.array(Image.open(path)), PERSON, np.array(Image.open(labels))).astype(np.uint8)).save(labels)
        cls.make("map", "localize", "evaluate", "report")

    def report(self, job):
        return json.loads(self.work.path(f"{job}/report.json").read_text())

    def test_who_passes_is_masked_and_what_stands_is_not(self):
        shares, features = ([], []), np.zeros(2)  # shares: of the pixels of each in a frame
        for path in sorted(self.work.path("moving").glob("shard_*.csv")):
            with h5py.File(self.work.path(f"moving/masks_{path.stem[6:]}.h5")) as masks, \
                 h5py.File(self.work.path(f"features/{path.stem}.h5")) as file:
                first, keypoints = np.ravel(file["first_feature"]), np.rint(file["raw_keypoint_px"][:]).astype(int)
                for i, row in enumerate(csv.DictReader(path.read_text().splitlines())):
                    labels = np.array(Image.open(self.work.folder / "data" / row["label_path"]))
                    x, y = keypoints[first[i]:first[i + 1]].T
                    for k, label in enumerate((PERSON, OBJECT)):
                        if np.mean(labels == label) > 0.01:
                            shares[k].append(unpacked(masks, i)[labels == label].mean())
                        features[k] += (labels[y, x] == label).sum()
        self.assertGreater(np.mean(shares[0]), 0.8)
        self.assertLess(np.median(shares[1]), 0.25)  # what the board hides in the frames around may be masked
        self.assertLess(features[0], 0.02 * features[1])

    def test_the_map_has_the_classes_of_what_stands(self):
        voxels = {entry["name"]: entry["num_voxels"] for entry in json.loads(self.work.path("voxel_labels/legend.json").read_text())["classes"]}
        self.assertGreater(voxels["object"], 50)
        self.assertLess(voxels["person"], 0.05 * voxels["object"])
        self.assertTrue(json.loads(self.work.path("things/things.json").read_text())["things"])

    def test_each_keyframe_of_the_map_has_a_mask(self):
        with h5py.File(self.work.path("ghosts/masks.h5")) as file:
            self.assertEqual(len(file["time_ns"]), self.report("ghosts")["num_keyframes"])
        self.assertGreater(self.report("ghosts")["num_regions"], 0)
        self.assertIn("stand still", self.work.path("report/index.html").read_text())

    def test_the_map_is_made_under_the_masks_of_ghosts(self):
        for receipt in ("landmarks/receipt.json", "point_cloud/receipt_0_0.json", "octree/receipt_0_0.json", "voxel_labels/receipt_0_0.json"):
            inputs = json.loads(self.work.path(receipt).read_text())["inputs"]
            self.assertEqual([entry["path"].split("/")[-2:] for entry in inputs if entry["name"] == "masks"], [["ghosts", "masks.h5"]], receipt)

    def test_queries_are_located(self):
        located = self.work.path("localize/queries.csv").read_text().splitlines()
        self.assertGreater(sum(",located," in line for line in located), 0.5 * len(located))

    def test_other_labels_reach_the_map(self):
        """The list of frames that the tiles read hands on the hashes of labels and masks."""
        work = self.work.copy()
        self.addCleanup(work.remove)
        model = work.folder / "data/model.toml"
        model.write_text(MODEL.replace('"person", "object"]', '"person"]'))
        self.assertEqual(work.make("-q", "map").returncode, 1)
        result = work.make("map")
        self.assertEqual(result.returncode, 0, result.stdout)
        hashes = work.hashes()
        clean = work.copy()
        self.addCleanup(clean.remove)
        clean.make("clean", f"SITE={SITE}")
        result = clean.make("map")
        self.assertEqual(result.returncode, 0, result.stdout)
        expected = clean.hashes()
        self.assertEqual({name: hashes.get(name) for name in expected}, expected)


if __name__ == "__main__":
    unittest.main()
