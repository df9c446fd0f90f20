# SPDX-License-Identifier: Apache-2.0
"""A map to which frames are appended ends in the bytes of a clean build, and reruns only what they reach: a real
recording that goes on, and a made-up building in which a second recording sees rooms that the first did not."""
import json
import os
import pathlib
import re
import shutil
import tempfile
import unittest

from nightly import IS_NIGHT
from rendered_sites import recording
from workspace import REPOSITORY, SITE as BUILDING, SiteTest, Workspace

from nightmap_site.unit_lists import near  # of the scripts that workspace finds

SITE = "tum_fr1_xyz_15hz"
DATA = pathlib.Path(os.environ.get("NIGHTMAP_DATA", REPOSITORY / "../shared/data")).resolve()
FIRST, ALL, SHARD = (300, 399, 100) if IS_NIGHT else (60, 80, 20)  # frames; at night the whole recording


class AppendTest(SiteTest):
    given = (f"SITE={SITE}", "map",)

    def setUp(self):
        if not (DATA / SITE).is_dir():
            if os.environ.get("CI") == "true":
                self.fail(f"no recording {DATA / SITE}; set NIGHTMAP_DATA")
            self.skipTest(f"no recording {DATA / SITE}: set NIGHTMAP_DATA")
        self.work = Workspace(tempfile.mkdtemp(prefix="nightmap-e2e-")).removed_after(self)
        (self.work.folder / "data").mkdir()
        (self.work.folder / "data" / SITE).symlink_to(DATA / SITE)
        sites = self.work.folder / "configs/sites" / SITE
        sites.mkdir(exist_ok=True)
        (sites / "frames.toml").write_text(f"shard_size = {SHARD}\n")

    def hashes(self):
        return self.work.hashes(SITE)

    def test_appended_frames(self):
        self.make(f"SET=frames.max_frames={FIRST}")
        output = self.make(f"SET=frames.max_frames={ALL}")
        for job in ("features", "matches", "odometry"):
            self.assertRegex(output, rf"(?m)^{job} +1 of 4 ", output)
            self.assertNotIn(f"== {job}_0000", output)
            self.assertIn(f"== {job}_0003", output)
        appended = self.hashes()
        shutil.rmtree(self.work.folder / "maps")
        self.make(f"SET=frames.max_frames={ALL}")
        self.assertEqual(appended, self.hashes())


class SecondRecordingTest(unittest.TestCase):
    """Two drives through one building, each about half of the route: they meet, and each sees rooms of its own."""

    NUM_FRAMES, SHARD = 80, 20
    SYNTHESIZE = ("num_rooms = 2\nlength_ratio = 0.6\noverlap_m = 0\nnum_queries = 0\nmax_step_m = 0.3\nmax_turn_rad = 0.3\n"
                  "num_frames = {num_frames}\nrecording = {index}\nstart_ratio = {start_ratio}\n")  # fmt: skip

    def setUp(self):
        self.work = Workspace().removed_after(self)
        sites = self.work.folder / "configs/sites"
        values = (sites / BUILDING / "synthesize.toml").read_text().splitlines()
        pictures = "\n".join(line for line in values if line.partition("_")[0] in ("image", "focal") or "light" in line)
        for index, start_ratio in enumerate((0.0, 0.5)):
            config, folder = self.work.folder / f"synthesize_{index}.toml", self.work.data() / str(index)
            drive = self.SYNTHESIZE.format(num_frames=self.NUM_FRAMES, index=index, start_ratio=start_ratio)
            config.write_text(drive + pictures)
            folder.mkdir(parents=True)
            result = self.work.run("synthesize", "--config", config, "--out", f"site={folder}/synthesize.json")
            self.assertEqual(result.returncode, 0, result.stdout)
        (sites / BUILDING / "frames.toml").write_text(f"shard_size = {self.SHARD}\n")
        (sites / BUILDING / "tiles.toml").write_text("edge_m = 8.0\n")
        text = (sites / f"{BUILDING}.toml").read_text().split("[[sequence]]")[0]
        self.text = text.replace("synthetic = true", "synthetic = false").replace("hold_out_every = 7", "hold_out_every = 0")
        self.site = sites / f"{BUILDING}.toml"

    def map_of(self, num_recordings):
        self.site.write_text(self.text + "".join(recording(str(index), index) for index in range(num_recordings)))
        return self.work.output("map")

    def num_free_cells(self):
        return json.loads(self.work.path("grid/report.json").read_text())["num_free_cells"]

    def tiles(self):
        return {path.stem.removeprefix("tile_"): path.read_bytes() for path in self.work.path("tiles").glob("tile_*.json")}

    def check_made(self, output, job, expected, num_all, num_joins=0):
        """Checks that these units were made and no others, and that the table says how many."""
        self.assertEqual(set(re.findall(rf"(?m)^== {job}_(\S+)$", output)), expected)
        self.assertRegex(output, rf"(?m)^{job} +{len(expected) + num_joins} of {num_all + num_joins} ")

    def test_rooms_not_seen_before(self):
        self.map_of(1)
        first, seen = self.tiles(), self.num_free_cells()
        output = self.map_of(2)
        self.assertGreater(self.num_free_cells(), 1.3 * seen)
        num_shards = self.NUM_FRAMES // self.SHARD
        for job in ("features", "matches", "odometry"):
            new = {f"{shard:04}" for shard in range(num_shards, 2 * num_shards)}
            self.check_made(output, job, new, 2 * num_shards)
        tiles = self.tiles()
        changed = {tile for tile in tiles if tiles[tile] != first.get(tile)}
        self.check_made(output, "point_cloud", changed, len(tiles), num_joins=1)
        reached = {tile for tile in tiles if changed & set(near(tile, set(tiles)))}  # their clouds bound its free space
        self.check_made(output, "octree", reached, len(tiles), num_joins=1)
        if IS_NIGHT:  # by day AppendTest compares with a clean build
            appended = self.work.hashes()
            shutil.rmtree(self.work.folder / "maps")
            self.map_of(2)
            self.assertEqual(appended, self.work.hashes())
