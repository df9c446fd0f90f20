# SPDX-License-Identifier: Apache-2.0
"""The building in tiles: the same map as in one, and only the tiles that something changed in are remade."""
import json
import os

from nightly import some_of
from signal_at_write import SignalAtWrite
from workspace import SITE, SiteTest, Workspace, as_its_job_wrote

SMALL = "SET=tiles.edge_m=6"
KEYFRAMES = "map_frame/keyframes.tum"


class TilesTest(SiteTest):
    given = ("map", SMALL,)

    @classmethod
    def setUpClass(cls):
        cls.base = Workspace.made("map").removed_after(cls)
        cls.whole = {name: digest for name, digest in cls.base.hashes().items()}
        cls.tiled = cls.base.copy().removed_after(cls)
        result = cls.tiled.make("map", SMALL, "-j2")
        if result.returncode != 0:
            raise AssertionError(f"the chain in tiles failed:\n{result.stdout}")

    def setUp(self):
        self.work = self.tiled.copy().removed_after(self)

    def tiles(self):
        header, *names = self.work.path("tiles/tiles.txt").read_text(encoding="utf-8").splitlines()
        self.assertEqual(header, f"nightmap tiles, version 1, {len(names)} names")
        return names

    def near(self, tile):
        """The tile and its neighbours."""
        x, y = map(int, tile.split("_"))
        around = {f"{x + dx}_{y + dy}" for dx in (-1, 0, 1) for dy in (-1, 0, 1)}
        return around & set(self.tiles())

    def written(self, stage):
        """The file of each tile's artifact, and when it was made."""
        stats = {path.stem.removeprefix("tile_"): path.stat() for path in self.work.path(stage).glob("tile_*")}
        return {tile: (stat.st_ino, stat.st_mtime_ns) for tile, stat in stats.items()}

    def times(self):
        """The same of each tile's cloud and octree."""
        clouds, octrees = self.written("point_cloud"), self.written("octree")
        self.assertEqual(set(clouds), set(octrees))
        return {tile: (clouds[tile], octrees[tile]) for tile in clouds}

    def set_keyframes(self, lines):
        """As if map_frame had found these."""
        self.work.path(KEYFRAMES).write_text("".join(lines), encoding="utf-8")
        as_its_job_wrote(self.work.path(KEYFRAMES))
        os.utime(self.work.path("map_frame/receipt.json"))

    def keyframes(self):
        lines = self.work.path(KEYFRAMES).read_text(encoding="utf-8").splitlines(keepends=True)
        self.assertTrue(all(line.startswith("#") for line in lines[:2]))
        return lines[:2], lines[2:]

    def test_tiles_do_not_show_in_the_map(self):
        self.assertGreaterEqual(len(self.tiles()), 4)
        self.assertEqual(set(self.times()), set(self.tiles()))
        hashes = self.work.hashes()
        for name in ("point_cloud/cloud.ply", "octree/map.ot", "octree/map.bt", "grid/map.pgm"):
            self.assertEqual(hashes[name], self.whole[name], name)

    def test_bytes_do_not_depend_on_threads_or_jobs(self):
        hashes = self.work.hashes()
        for stage in ("tiles", "point_cloud", "octree"):
            for path in self.work.path(stage).iterdir():
                path.unlink()
        self.make("THREADS=1", "-j3")
        self.assertEqual(self.work.hashes(), hashes)

    def test_back_to_one_tile_leaves_nothing_of_the_others(self):
        self.work.output("map")
        self.assertEqual(self.work.hashes(), self.whole)
        self.assertFalse(list(self.work.path("point_cloud").glob("receipt_1_*.json")))
        self.assertIn("all as written", self.work.make("verify").stdout)

    def test_appended_frames_far_from_the_rest_redo_only_their_tiles(self):
        comments, poses = self.keyframes()
        count = len(poses) - len(poses) // 10
        self.assertGreater(len(poses), count)
        self.set_keyframes(comments + poses[:count])
        self.make()
        before = self.times()
        far = []
        for line in poses[count:]:
            words = line.split()
            far.append(" ".join([words[0], str(float(words[1]) + 60), *words[2:]]) + "\n")
        self.set_keyframes(comments + poses[:count] + far)
        self.make()
        after = self.times()
        self.assertLess(set(before), set(after))
        self.assertEqual({tile: after[tile] for tile in before}, before)
        for tile in set(after) - set(before):
            self.assertGreaterEqual(int(tile.split("_")[0]), 60 // 6 - 2, tile)
        self.assertEqual(self.work.make("-q", "map", SMALL).returncode, 0)

    def test_a_changed_pose_redoes_the_tiles_it_touches(self):
        comments, poses = self.keyframes()
        words = poses[0].split()
        before = {stage: self.written(stage) for stage in ("point_cloud", "octree")}
        poses[0] = " ".join([words[0], str(float(words[1]) + 0.001), *words[2:]]) + "\n"
        self.set_keyframes(comments + poses)
        self.make()
        redone = {}
        for stage, old in before.items():
            new = self.written(stage)
            redone[stage] = {tile for tile in new if new[tile] != old[tile]}
        self.assertTrue(redone["point_cloud"])
        self.assertLess(redone["point_cloud"], set(self.tiles()))
        # A cloud tells the octrees around it which rays count.
        self.assertEqual(redone["octree"], {near for tile in redone["point_cloud"] for near in self.near(tile)})

    def test_a_deleted_or_cut_artifact_is_remade_with_the_same_bytes(self):
        hashes = self.work.hashes()
        name = self.tiles()[1]
        paths = (f"tiles/tile_{name}.json", "tiles/cameras.json", "tiles/tiles.txt", f"point_cloud/tile_{name}.ply",
                 f"point_cloud/report_{name}.json", "point_cloud/cloud.ply", f"octree/tile_{name}.ot",
                 f"octree/receipt_{name}.json", "octree/map.bt")
        for path in some_of(paths, one_in=3):
            with self.subTest(path):
                self.work.path(path).unlink()
                self.assertEqual(self.work.make("-q", "map", SMALL).returncode, 1)
                self.make()
                self.assertEqual(self.work.hashes(), hashes)
        # The state that a kill between two renames leaves: an output newer than its receipt.
        for path in some_of((f"point_cloud/tile_{name}.ply", f"octree/tile_{name}.ot"), one_in=2):
            with self.subTest(path):
                artifact = self.work.path(path)
                artifact.write_bytes(artifact.read_bytes()[:300])
                self.make()
                self.assertEqual(self.work.hashes(), hashes)

    def test_a_killed_run_goes_on_with_the_tiles_it_had_not_made(self):
        hashes = self.work.hashes()
        signals = SignalAtWrite()
        self.addCleanup(signals.remove)
        for stage in some_of(("point_cloud", "octree"), one_in=2):
            with self.subTest(stage):
                folder = self.work.path(stage)
                for path in folder.iterdir():
                    path.unlink()
                signals.kill(self.work.command("map", SMALL), self.work.folder, f"tile_{self.tiles()[1]}.")
                # The receipt of a tile is committed last.
                done = {path.stem.removeprefix("receipt_") for path in folder.glob("receipt_*.json")}
                self.assertTrue(done)
                self.assertLess(done, set(self.tiles()))
                before = self.written(stage)
                self.make()
                after = self.written(stage)
                self.assertEqual({tile: after[tile] for tile in done}, {tile: before[tile] for tile in done})
                self.assertEqual(self.work.hashes(), hashes)

    def test_looking_changes_nothing_and_names_the_stage(self):
        hashes, times = self.work.hashes(), self.times()
        why = self.work.make("why", "SET=tiles.edge_m=7").stdout
        self.assertIn("edge_m 6.0 -> 7.0", why)
        self.assertIn("point_cloud_0_0: ", self.work.make("why", SMALL + " point_cloud.voxel_size_m=0.03").stdout)
        self.assertEqual(self.work.make("-n", "map", "SET=tiles.edge_m=7").returncode, 0)
        self.assertEqual(self.work.make("-q", "map", "SET=tiles.edge_m=7").returncode, 1)
        self.assertEqual((self.work.hashes(), self.times()), (hashes, times))
        self.assertEqual(self.work.make("-q", "map", SMALL).returncode, 0)

    def test_ranges_that_tiles_do_not_reach_are_refused(self):
        for value, remedy in (("point_cloud.max_depth_m=4.5", "tiles.max_range_m"),
                              ("octree.max_range_m=4.5", "tiles.max_range_m"),
                              ("point_cloud.surface_radius_m=0.3", "tiles.overlap_m")):
            self.assertIn(remedy, self.work.output("map", f"{SMALL} {value}", code=2))
        self.assertIn("tiles.edge_m", self.work.output("map", "SET=tiles.edge_m=3", code=2))

    def cloud_reports(self, work):
        tiles = [json.loads(path.read_text()) for path in sorted(work.path("point_cloud").glob("report_*.json"))]
        return tiles, json.loads(work.path("point_cloud/report.json").read_text())

    def test_held_out_rays_are_reported_for_tiles_and_site(self):
        tiles, site = self.cloud_reports(self.work)
        whole_tiles, whole = self.cloud_reports(self.base)
        num = {name: sum(tile[f"num_held_out_rays{name}"] for tile in tiles) for name in ("", "_agreeing", "_blocked")}
        self.assertEqual(num[""], sum(tile["num_held_out_rays"] for tile in whole_tiles))
        for kind in ("agreeing", "blocked"):
            percent = site[f"held_out_rays_{kind}_percent"]
            self.assertAlmostEqual(percent, 100 * num[f"_{kind}"] / num[""])
            self.assertAlmostEqual(percent, whole[f"held_out_rays_{kind}_percent"], delta=2)
        self.assertGreater(site["held_out_rays_agreeing_percent"], 80)
        self.assertLess(site["held_out_rays_blocked_percent"], 3)

    def test_consistency_is_an_option(self):
        def num_inconsistent(*setting):
            self.work.output(f"maps/{SITE}/point_cloud/cloud.ply", " ".join((SMALL, *setting)))
            return sum(tile["num_inconsistent"] for tile in self.cloud_reports(self.work)[0])

        by_default = num_inconsistent()
        self.assertGreater(by_default, 0)
        self.assertEqual(num_inconsistent("point_cloud.min_consistent_frames=0"), 0)
        self.assertGreater(num_inconsistent("point_cloud.min_consistent_frames=2"), by_default)
        self.assertIn("min_consistent_frames", self.work.output("map", SMALL + " point_cloud.min_consistent_frames=-1", code=2))

    def test_pcd_is_exported_when_asked_for(self):
        self.make(SMALL + " join_clouds.export_pcd=true")
        points = [line for line in self.work.path("point_cloud/cloud.pcd").read_bytes().split(b"\n")[:12]
                  if line.startswith(b"POINTS")]
        cloud = self.work.path("point_cloud/cloud.ply").read_bytes()
        self.assertIn(b"element vertex " + points[0].split()[1] + b"\n", cloud[:300])
        self.make()
        self.assertFalse(self.work.path("point_cloud/cloud.pcd").exists())

    def test_a_file_of_a_later_stage_can_be_asked_for(self):
        grid = self.work.path("grid/map.pgm")
        content = grid.read_bytes()
        grid.unlink()
        self.work.output(f"maps/{SITE}/grid/map.pgm", f"maps/{SITE}/adjust/graph.g2o", SMALL, "-j2")
        self.assertEqual(grid.read_bytes(), content)
