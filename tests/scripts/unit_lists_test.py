# SPDX-License-Identifier: Apache-2.0
"""The lists of shards, tiles and floors: what is read of whole ones, and that damaged ones are refused."""

import json
import os

from folder_case import SiteFolderTest  # first: it makes scripts and benchmarks importable

import remove_leftovers
from nightmap_make.graph import Graph
from nightmap_make.site_state import SiteState
from nightmap_site.pipeline import read_pipeline
from nightmap_site.script_errors import DataError
from nightmap_site.site import CONFIGS
from nightmap_site.unit_lists import CurrentRuns, near, read_floors, read_queries, read_shards, read_tiles

PIPELINE = read_pipeline(str(CONFIGS))
SHARDS = "nightmap shards, version 1, 3 names\n0000\n0001\n0002\n"
QUERIES = "nightmap queries, version 1, 1 names\na.jpg\n"
TILES = "nightmap tiles, version 1, 3 names\n-1_0\n0_0\n0_10\n"
COMMAND = "$(shell touch pwned)"


def floors_json(*yamls, numbers=None):
    numbers = numbers or range(len(yamls))
    rows = [{"number": n, "height_m": 3.0 * n, "yaml": yaml} for n, yaml in zip(numbers, yamls)]
    return json.dumps({"format": "nightmap floors", "version": 2, "floors": rows})


class SiteFolder(SiteFolderTest):
    def setUp(self):
        self.write("frames/shards.txt", SHARDS)
        self.write("tiles/tiles.txt", TILES)
        self.write("grid/floors.json", floors_json("map.yaml", "floor_1.yaml"))
        self.write("queries/queries.txt", QUERIES)


class ListsTest(SiteFolder):
    def state(self):
        """The site as make sees it, and what was said of its lists."""
        said, state = [], SiteState("office", str(self.site_dir), "data")
        state.read_lists(PIPELINE, said.append)
        return state, said

    def test_whole_lists(self):
        state, said = self.state()
        self.assertEqual((said, state.damaged, state.has("queries")), ([], set(), True))
        self.assertEqual(state.lists, {"shard": ["0000", "0001", "0002"], "tile": ["-1_0", "0_0", "0_10"],
                                       "floor": ["map", "floor_1"], "query": ["a.jpg"]})  # fmt: skip
        self.assertEqual(near("0_0", {"1_1", "-1_-1", "0_0", "2_0"}), ["-1_-1", "0_0", "1_1"])

    def test_lists_that_are_not_there_are_empty(self):
        for path in list(self.site_dir.rglob("*.*")):
            path.unlink()
        for queries, tiles in ((None, None), ("nightmap queries, version 1, 0 names\n", "nightmap tiles, version 1, 0 names\n")):
            if queries:
                self.write("queries/queries.txt", queries)
                self.write("tiles/tiles.txt", tiles)
            state, said = self.state()
            self.assertEqual((said, state.damaged, state.has("queries")), ([], set(), False))
            self.assertEqual([state.lists[kind] for kind in ("shard", "tile", "floor")], [[], [], []])

    def check_damaged(self, name, contents, reader, stage):
        for content in contents:
            with self.subTest(content):
                path = self.write(name, content)
                with self.assertRaisesRegex(DataError, f"{path}"):
                    reader()
                state, said = self.state()
                self.assertEqual(state.damaged, {stage})
                self.assertNotIn("pwned", str(state.lists))
                self.assertRegex("\n".join(said), f"^nightmap: {path}.*: {stage} makes it anew$")

    def test_damaged_lists_of_shards(self):
        cut = [SHARDS[:end] for end in range(len(SHARDS))]
        others = ["SHARDS := 0000\n", SHARDS + "0003\n", SHARDS.replace("0001", "0002"), SHARDS.replace("0002", COMMAND),
                  SHARDS.replace("0001", "../x"), SHARDS.replace("0001", "00 1"), SHARDS.replace("0001", "000\u0661"),
                  "nightmap shards, version 1, 2 names\n0001\n0000\n", SHARDS.replace("version 1", "version 2"), TILES,
                  SHARDS.replace("\n", "\r\n"), b"\xff\xfe", b"\0" * 100, f"$(error x)\n{SHARDS}"]
        self.check_damaged("frames/shards.txt", cut + others, lambda: read_shards(self.site_dir), "frames")

    def test_damaged_lists_of_tiles(self):
        cut = [TILES[:end] for end in range(len(TILES))]
        others = [TILES.replace("0_10", "0_0"), TILES.replace("0_10", "0_-1"), TILES.replace("0_10", "-0_0"),
                  TILES.replace("0_10", "1_2_3"), TILES.replace("0_10", "../0_1"), TILES.replace("0_10", COMMAND),
                  TILES.replace("0_10", "0_10:0_10"), TILES.replace("0_10", "0_1 0_2"), TILES.replace("0_10", "0_01")]
        self.check_damaged("tiles/tiles.txt", cut + others, lambda: read_tiles(self.site_dir), "tiles")

    def test_damaged_lists_of_floors(self):
        whole = floors_json("map.yaml", "floor_1.yaml")
        others = [floors_json(), floors_json("map.yaml", "map.yaml"), floors_json("map.yaml", f"{COMMAND}.yaml"),
                  floors_json("map.yaml", "../map.yaml"), floors_json("map.yaml", numbers=[1]), "[" * 100000, "5", "[]",
                  floors_json("map.yaml", 5), whole.replace("3.0", "NaN"), whole.replace("3.0", '"3"'),
                  whole.replace("2,", "3,", 1), whole.replace("nightmap floors", "floors"), b"\xff"]
        cut = [whole[:end] for end in range(0, len(whole), 7)]
        self.check_damaged("grid/floors.json", cut + others, lambda: read_floors(self.site_dir / "grid"), "grid")

    def test_damaged_lists_of_queries(self):
        cut = [QUERIES[:end] for end in range(len(QUERIES))]
        others = [QUERIES.replace("1 names", "0 names"), QUERIES.replace("queries", "tiles"), b"\xff" * 40, "\n" + QUERIES]
        self.check_damaged("queries/queries.txt", cut + others, lambda: read_queries(self.site_dir / "queries/queries.txt"), "queries")

    def test_a_pipe_or_folder_in_place_of_a_list_is_damage(self):
        path = self.site_dir / "tiles" / "tiles.txt"
        path.unlink()
        os.mkfifo(path)
        self.assertEqual(self.state()[0].damaged, {"tiles"})
        path.unlink()
        path.mkdir()
        self.assertEqual(self.state()[0].damaged, {"tiles"})

    def test_runs_of_other_shards_and_tiles_are_no_runs_of_the_map(self):
        runs = CurrentRuns(self.site_dir)
        for name in ("receipt.json", "receipt_0002.json", "report_0_10.json", "receipt_loops.json"):
            self.assertTrue(runs.has(self.site_dir / "features" / name), name)
        for name in ("receipt_0003.json", "report_0_11.json"):
            self.assertFalse(runs.has(self.site_dir / "features" / name), name)
        self.write("frames/shards.txt", SHARDS[:20])
        self.assertTrue(CurrentRuns(self.site_dir).has("receipt_0003.json"))  # nothing is known


class LeftoversTest(SiteFolder):
    def test_results_of_shards_that_are_no_more_are_removed_and_nothing_else(self):
        stay = ["features/shard_0002.h5", "features/report_0000.json", "features/shard_0003.txt", "features/notes_0003.h5",
                "features/shard_0003.h5.mine", "loops/loops.h5", "loops/receipt.json", "octree/shard_0003.h5",
                "logs/features_0001.log", "logs/octree_0003.log", "frames/report.json", "odometry/shard_003.h5"]
        go = ["features/shard_0003.h5", "features/report_0010.json", "features/receipt_0003.json", "matches/shard_0004.h5",
              "odometry/shard_0003.tum", "logs/odometry_0003.log"]
        for name in stay + go:
            self.write(name, "x")
        state = SiteState("office", str(self.site_dir), "data")
        state.read_lists(PIPELINE, self.fail)
        remove_leftovers.remove(str(self.site_dir), Graph(PIPELINE, state), "shard")
        self.assertEqual([name for name in stay if not (self.site_dir / name).exists()], [])
        self.assertEqual([name for name in go if (self.site_dir / name).exists()], [])

    def removed(self, graph, stay, go):
        for name in stay + go:
            self.write(name, "x")
        remove_leftovers.remove_gone(str(self.site_dir), graph, str(CONFIGS))
        self.assertEqual([name for name in stay if not (self.site_dir / name).exists()], [])
        self.assertEqual([name for name in go if (self.site_dir / name).exists()], [])

    def graph(self, pipeline=PIPELINE, tell=None, **tables):
        state = SiteState("office", str(self.site_dir), "data")
        state.tables = {"import": {"trajectory": "poses.tum"}} | tables
        state.read_lists(pipeline, tell or self.fail)
        return Graph(pipeline, state)

    def test_results_of_queries_that_are_no_more_are_removed(self):
        go = ["localize/queries.csv", "localize/queries.tum", "localize/receipt.json", "logs/localize.log"]
        stay = ["localize/notes.txt", "localize/queries.csv.mine", "localize/mine/queries.csv", "plan/path.csv", "drive/receipt.json",
                "landmarks/colmap/cameras.txt", "logs/plan.log", "evaluate/metrics.json", "logs/report.log", "octree/tile_0_0.ot"]  # fmt: skip
        self.removed(self.graph(), stay + go, [])
        for listed in ("nightmap queries, version 1, 0 names\n", ""):  # what the config asks for is not gone with its list
            self.write("queries/queries.txt", listed)
            for asking in ({"hold_out_every": 7}, {"query": [{"pictures": "a.jpg"}]}):
                self.removed(self.graph(tell=str, **asking), stay + go, [])
        self.write("config/asked/office.toml", '[[query]]\npictures = "a.jpg"\n')
        self.removed(self.graph(tell=str), stay + go, [])
        self.write("config/asked/office.toml", "")
        self.removed(self.graph(tell=str), stay, go)

    def test_results_of_jobs_that_another_profile_had_are_removed(self):
        go = ["matches/shard_0000.h5", "matches/receipt_0001.json", "loops/loops.h5", "loops/report.json", "odometry/shard_0000.tum",
              "pose_graph/graph.h5", "pose_graph/loops.csv", "adjust/graph.g2o", "logs/loops.log", "logs/matches_0000.log"]  # fmt: skip
        stay = ["pose_graph/trajectory.tum", "pose_graph/receipt.json", "matches/shard_0000.h5.mine", "features/shard_0000.h5",
                "grid/distances.h5", "logs/pose_graph.log", "loops/readme"]  # fmt: skip
        imported = read_pipeline(str(CONFIGS), "imported", ("trajectory",))
        self.removed(self.graph(imported), stay, go)
        self.assertTrue((self.site_dir / "loops").exists())
        self.assertFalse((self.site_dir / "odometry").exists())
        self.removed(self.graph(), stay + go, [])
