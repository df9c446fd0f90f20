#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""The profile labels on the small building: tables and chairs, by the label pictures of the recording, are left out of features,
cloud and octree; what reruns after a change; mistakes in the model file and in label pictures."""
import csv
import json
import os
import re
import shutil
import time
import unittest

import h5py
import matplotlib.image
import numpy as np
from workspace import SITE, Workspace

CLASSES = ("none", "wall", "floor", "ceiling", "door", "table", "chair", "shelf", "cabinet", "bed", "sofa", "poster", "object", "lamp")
MOVING = ("table", "chair")
MODEL = f"classes = {json.dumps(CLASSES)}\nmoving = {json.dumps(MOVING)}\n"


def unpacked(file, i):
    """The mask of frame i of a file of masks."""
    offset = np.ravel(file["run_offset"])
    runs = np.ravel(file["run"])[offset[i]:offset[i + 1]]
    width, height = file["size_px"][i]
    return np.repeat(np.arange(len(runs)) % 2, runs).reshape(height, width).astype(bool)


def use_labels(work):
    """Gives the small building the labels of its recording, and the model's table of classes."""
    site = work.folder / f"configs/sites/{SITE}.toml"
    text = site.read_text().replace("root =", 'profile = "labels"\nroot =', 1)
    site.write_text(text.replace("[[sequence]]\n", '[[sequence]]\nlabel_folder = "labels"\n') + '\n[import]\nmodel = "model.toml"\n')
    (work.folder / "data").mkdir(exist_ok=True)
    (work.folder / "data/model.toml").write_text(MODEL)


class LabelsTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.work = Workspace.made("map")
        cls.addClassCleanup(cls.work.remove)
        cls.work.as_recorded()
        cls.plain = cls.work.copy()
        cls.addClassCleanup(cls.plain.remove)
        use_labels(cls.work)
        cls.model = cls.work.folder / "data/model.toml"
        result = cls.work.make("map")
        if result.returncode != 0:
            raise AssertionError(result.stdout)

    def make(self, work, *arguments, code=0):
        result = work.make(*arguments)
        self.assertEqual(result.returncode, code, result.stdout)
        return result.stdout

    def labels_of(self, color_path):
        path = self.work.folder / "data" / color_path.replace("/rgb/", "/labels/").replace(".jpg", ".png")
        return np.rint(255 * matplotlib.image.imread(path)).astype(int)

    def test_no_feature_lies_on_what_moves(self):
        moving = [CLASSES.index(name) for name in MOVING]
        counts = {self.plain: 0, self.work: 0}
        for path in sorted(self.work.path("features").glob("shard_*.csv")):
            rows = list(csv.DictReader(path.open()))
            for work in counts:
                with h5py.File(work.path(f"features/{path.stem}.h5")) as file:
                    first, pixels = np.ravel(file["first_feature"]), np.rint(file["raw_keypoint_px"][:]).astype(int)
                for i, row in enumerate(rows):
                    self.assertTrue(row["mask_path"] and row["mask_hash"], row)
                    x, y = pixels[first[i]:first[i + 1]].T
                    counts[work] += np.isin(self.labels_of(row["color_path"])[y, x], moving).sum()
        self.assertGreater(counts[self.plain], 100)
        self.assertEqual(counts[self.work], 0)

    def test_masks_hold_the_classes_that_move_and_a_margin(self):
        moving = [CLASSES.index(name) for name in MOVING]
        rows = [row for row in csv.DictReader(self.work.path("features/shard_0001.csv").open()) if row["mask_hash"]]
        with h5py.File(self.work.path("features/masks_0001.h5")) as file:
            self.assertEqual([int(row["time_ns"]) for row in rows], list(np.ravel(file["time_ns"])))
            shares = []
            for i, row in enumerate(rows):
                mask, moves = unpacked(file, i), np.isin(self.labels_of(row["color_path"]), moving)
                self.assertTrue(mask[moves].all())
                shares.append((mask.mean(), moves.mean()))
        masked, moved = np.mean(shares, axis=0)
        self.assertTrue(0.01 < moved < masked < 2 * moved, (masked, moved))

    def test_the_map_has_less_of_them(self):
        count = {work: json.loads(work.path("octree/report_0_0.json").read_text())["num_rays"] for work in (self.plain, self.work)}
        self.assertLess(count[self.work], 0.99 * count[self.plain])
        receipt = json.loads(self.work.path("octree/receipt_0_0.json").read_text())
        masks = [entry for entry in receipt["inputs"] if entry["name"] == "masks"]
        self.assertEqual(len(masks), 3)
        self.assertFalse(any("xxh3" in entry for entry in masks))

    def test_options_of_later_jobs_label_nothing_again(self):
        self.assertEqual(self.work.make("-q", "map").returncode, 0, self.work.make("why").stdout)
        work = self.work.copy()
        self.addCleanup(work.remove)
        before = work.runs()
        self.make(work, "map", "SET=octree.resolution_m=0.06")
        after = work.runs()
        reran = {job for job in after if after[job] != before[job]}
        self.assertTrue("octree" in reran and not reran & {"features", "point_cloud"}, reran)

    def test_options_of_features_and_of_masks_label_no_picture_again(self):
        work = self.work.copy()
        self.addCleanup(work.remove)
        shard, options = f"maps/{SITE}/features/shard_0001.h5", "SET=features.num_features=600"
        self.assertRegex(self.make(work, shard, options), r"[1-9]\d* frames with labels, 0 of them labelled anew")
        (work.folder / "data/model.toml").write_text(f"{MODEL}margin_px = 9\n")
        self.assertRegex(self.make(work, shard, options), r"[1-9]\d* frames with labels, 0 of them labelled anew")
        kept = {name: work.path(f"features/{name}").read_bytes() for name in ("labels_0001.h5", "masks_0001.h5")}
        for path in work.path("features").glob("*_0001.*"):
            path.unlink()
        self.assertRegex(self.make(work, shard, options), r"([1-9]\d*) frames with labels, \1 of them labelled anew")
        self.assertEqual({name: work.path(f"features/{name}").read_bytes() for name in kept}, kept)

    def test_a_changed_label_picture_reruns_its_shard_and_a_changed_model_all(self):
        work = self.work.copy()
        self.addCleanup(work.remove)
        receipts = sorted(work.path("features").glob("receipt_*.json"))
        before = [path.stat().st_mtime_ns for path in receipts]
        picture = sorted((work.data() / "labels").glob("*.png"))[3]
        shutil.copyfile(sorted((work.data() / "labels").glob("*.png"))[9], picture)
        self.make(work, *(f"maps/{SITE}/features/shard_{shard:04}.h5" for shard in range(3)))
        self.assertEqual([path.stat().st_mtime_ns != time for path, time in zip(receipts, before)], [True, False, False])
        (work.folder / "data/model.toml").write_text(MODEL.replace('"table", "chair"]', '"chair"]'))
        self.assertIn("[import] model", self.make(work, "why"))
        self.make(work, "map")
        self.assertTrue(all(path.stat().st_mtime_ns != time for path, time in zip(receipts, before)))
        self.make(work, "verify")

    def made_anew_is_the_same(self, work):
        """Makes the map of a changed model, which reruns what it must, and once more from nothing."""
        self.make(work, "-q", "map", code=1)
        self.make(work, "map")
        self.make(work, "-q", "map")
        hashes = work.hashes()
        shutil.rmtree(work.path(""))
        self.make(work, "map")
        expected = work.hashes()
        self.assertEqual({name: hashes.get(name) for name in expected}, expected)  # another test may have asked for more

    def test_a_renamed_class_is_renamed_in_all_results(self):
        work = self.work.copy()
        self.addCleanup(work.remove)
        old = json.loads(work.path("things/things.json").read_text())["things"][0]["class"]
        (work.folder / "data/model.toml").write_text(MODEL.replace(f'"{old}"', '"thingamajig"'))
        self.made_anew_is_the_same(work)
        names = [entry["name"] for entry in json.loads(work.path("voxel_labels/legend.json").read_text())["classes"]]
        self.assertEqual(names, ["thingamajig" if name == old else name for name in CLASSES])
        self.make(work, "plan", "GOAL=object:thingamajig")
        self.assertIn("nor a class of things", self.make(work, "plan", f"GOAL=object:{old}", code=2))

    def test_classes_in_another_order_change_places(self):
        work = self.work.copy()
        self.addCleanup(work.remove)
        (work.folder / "data/model.toml").write_text(MODEL.replace('"shelf", "cabinet"', '"cabinet", "shelf"'))
        before = self.num_voxels_of_classes(work)
        self.made_anew_is_the_same(work)
        after = self.num_voxels_of_classes(work)
        self.assertEqual((after["cabinet"], after["shelf"]), (before["shelf"], before["cabinet"]))

    def num_voxels_of_classes(self, work):
        legend = json.loads(work.path("voxel_labels/legend.json").read_text())
        return {entry["name"]: entry["num_voxels"] for entry in legend["classes"]}

    def voxels(self, work):
        """Heights of the centres and classes of the labelled voxels."""
        with h5py.File(work.path("voxel_labels/voxels.h5")) as file:
            weights, labels, first = (np.ravel(file[name]) for name in ("vote_weight", "vote_label", "vote_offset"))
            best = [labels[a + np.argmax(weights[a:b])] for a, b in zip(first, first[1:])]
            return (file["key"][:, 2] + 0.5) * file["resolution_m"][0], np.array(best)

    def test_the_cloud_has_its_classes_for_other_programs(self):
        """Read without nightmap's own readers: as the header declares, by the types that PLY names."""
        types = {"float": "<f4", "uchar": "u1", "uint": "<u4"}
        header, body = self.work.path("voxel_labels/cloud.ply").read_bytes().split(b"end_header\n", 1)
        properties = [line.split()[1:] for line in header.decode().splitlines() if line.startswith("property")]
        points = np.frombuffer(body, [(name, types[kind]) for kind, name in properties])
        self.assertEqual(points.dtype["label"], np.dtype("<u4"))
        np.testing.assert_array_equal(points["scalar_label"], points["label"])
        floor = points["label"] == CLASSES.index("floor")
        self.assertGreater(floor.sum(), 1000)
        self.assertGreater((np.abs(points["z"][floor]) < 0.1).mean(), 0.98)

    def test_voxels_have_the_classes_of_the_label_pictures(self):
        height_m, label = self.voxels(self.work)
        report = json.loads(self.work.path("voxel_labels/report.json").read_text())
        self.assertEqual(report["num_labelled_voxels"], len(label))
        floor, wall = (label == CLASSES.index(name) for name in ("floor", "wall"))
        self.assertGreater(floor.sum(), 1000)
        self.assertGreater(wall.sum(), 1000)
        self.assertGreater((np.abs(height_m[floor]) < 0.1).mean(), 0.98)
        self.assertGreater((height_m[wall] > 0.1).mean(), 0.9)
        self.assertFalse(np.isin(label, [CLASSES.index(name) for name in MOVING]).any())
        legend = json.loads(self.work.path("voxel_labels/legend.json").read_text())
        self.assertEqual([entry["num_voxels"] for entry in legend["classes"]], list(np.bincount(label, minlength=len(CLASSES))))

    def test_another_palette_colors_again_and_runs_nothing_else(self):
        work = self.work.copy()
        self.addCleanup(work.remove)
        tree = work.path("voxel_labels/map.ot").read_bytes()
        config = work.folder / f"configs/sites/{SITE}/join_labels.toml"
        config.parent.mkdir(exist_ok=True)
        config.write_text(f"palette = {json.dumps([f'#0000{label:02x}' for label in range(len(CLASSES))])}\n")
        receipts = {path: path.stat().st_mtime_ns for path in work.path(".").glob("*/receipt*.json") if path.parent.name != "frames"}
        self.make(work, "map")
        reran = [path for path, time in receipts.items() if path.stat().st_mtime_ns != time]
        self.assertEqual(reran, [work.path("voxel_labels/receipt.json")])
        changed = work.path("voxel_labels/map.ot").read_bytes()
        self.assertEqual(len(changed), len(tree))
        nodes = np.frombuffer(changed.split(b"data\n", 1)[1], np.uint8).reshape(-1, 8)
        colored = nodes[(nodes[:, 4:7] != 255).any(axis=1)]
        self.assertTrue((colored[:, 4:6] == 0).all() and (colored[:, 6] < len(CLASSES)).all())
        self.assertEqual(self.voxels(work)[1].tolist(), self.voxels(self.work)[1].tolist())
        config.write_text('palette = ["#000000"]\n')
        self.assertIn("palette has 1 colors for 14 classes", self.make(work, "map", code=2))

    def test_a_plan_to_a_thing_ends_before_it_and_faces_it(self):
        things = json.loads(self.work.path("things/things.json").read_text())["things"]
        self.assertTrue(things)
        grid = np.flipud(matplotlib.image.imread(self.work.path("grid/map.pgm")))
        spec = self.work.path("grid/map.yaml").read_text()
        resolution_m = float(re.search(r"resolution: (\S+)", spec)[1])
        origin_m = np.array(json.loads(re.search(r"origin: (.*)", spec)[1]))[:2]
        for name in (things[0]["name"], things[0]["class"]):
            self.make(self.work, "plan", f"GOAL=object:{name}")
            goal = json.loads(self.work.path("plan/path.json").read_text())["goal"]
            thing = next(thing for thing in things if thing["name"] == goal["box"]["name"])
            self.assertEqual(thing["class"], things[0]["class"])
            self.assertLessEqual(goal["box"]["distance_m"], 1)
            column, row = np.floor((np.array([goal["x_m"], goal["y_m"]]) - origin_m) / resolution_m).astype(int)
            self.assertGreater(grid[row, column], 250)
            with open(self.work.path("plan/path.csv"), encoding="utf-8") as file:
                last = list(csv.DictReader(file))[-1]
            ahead_rad = np.arctan2(thing["y_m"] - goal["y_m"], thing["x_m"] - goal["x_m"])
            self.assertGreater(np.cos(float(last["heading_rad"]) - ahead_rad), np.cos(np.pi / 4))
        self.assertIn("nor a class of things", self.make(self.work, "plan", "GOAL=object:piano", code=2))

    def test_queries_are_masked_too(self):
        work = self.work.copy()
        self.addCleanup(work.remove)
        self.make(work, "localize", "report")
        located = work.path("localize/queries.csv").read_text().splitlines()
        with h5py.File(work.path("query_labels/masks.h5")) as file:
            self.assertEqual(len(file["time_ns"]), len(located) - 1)
        self.assertGreater(sum(",located," in line for line in located), 0.5 * len(located))

    def test_damaged_octrees_and_masks_end_their_job_and_are_named(self):
        """Zeros to the end; size and times stay, so that no job makes them anew."""
        work = self.work.copy()
        self.addCleanup(work.remove)
        self.make(work, "map", "localize")
        tile = min(work.path("octree").glob("tile_*.ot"), key=lambda path: -path.stat().st_size)
        for file, goal, option in ((tile, "map", "voxel_labels.keyframe_stride=2"),
                                   (work.path("octree/map.ot"), "map", "join_labels.max_failed_ratio=0.06"),
                                   (work.path("octree/map.ot"), "map", "grid.margin_m=0.6"),
                                   (work.path("query_labels/masks.h5"), "localize", "localize.max_focal_ratio=1.9")):  # fmt: skip
            whole, times = file.read_bytes(), file.stat()
            file.write_bytes(whole[:len(whole) // 5].ljust(len(whole), b"\0"))
            os.utime(file, ns=(times.st_atime_ns, times.st_mtime_ns))
            begin = time.monotonic()
            self.assertRegex(self.make(work, goal, f"SET={option}", code=2), rf"error.*{file.parent.name}/{file.name}: ")
            self.assertLess(time.monotonic() - begin, 20)
            file.write_bytes(whole)
            os.utime(file, ns=(times.st_atime_ns, times.st_mtime_ns))

    def test_a_wrong_model_is_refused_before_anything_runs(self):
        work = self.work.copy()
        self.addCleanup(work.remove)
        model, before = work.folder / "data/model.toml", work.runs()
        for text, said in ((MODEL.replace("moving", "movng"), "data/model.toml:2: unknown key 'movng'"),
                           (MODEL.replace('"table", "chair"]', '"stool"]'), "'moving' names \"stool\", which is no class"),
                           (MODEL + 'network = "none.onnx"\ninput_width_px = 10\ninput_height_px = 10\n', "found no network"),
                           (MODEL.replace("classes", "# classes"), "'classes' is missing")):  # fmt: skip
            model.write_text(text)
            self.assertIn(said, self.make(work, "map", code=2))
            self.assertEqual(work.runs(), before)

    def test_label_pictures_that_cannot_be_are_named(self):
        work = self.work.copy()
        self.addCleanup(work.remove)
        pictures = sorted((work.data() / "labels").glob("*.png"))
        matplotlib.image.imsave(pictures[0], np.full((240, 320, 3), 20, np.uint8))
        self.make(work, f"maps/{SITE}/frames/shards.txt")
        report = json.loads(work.path("frames/report.json").read_text())
        self.assertIn("labels must be one channel of 8 bits", json.dumps(report))
        (work.folder / "data/model.toml").write_text(MODEL.replace(', "shelf", "cabinet", "bed", "sofa", "poster", "object", "lamp"', ""))
        out = self.make(work, "map", code=2)
        self.assertRegex(out, r"small/labels/\d+\.png: label \d+ is none of the 7 classes in .*model\.toml")


if __name__ == "__main__":
    unittest.main()
