# SPDX-License-Identifier: Apache-2.0
"""The whole chain on a small building: what is made, what is remade, and that bytes agree."""
import json
import os

from browser import shown_text
from nightly import some_of
from workspace import GOALS, PIPELINE, SITE, CopiedSiteTest, as_its_job_wrote, told_by_why

# The folders of the tiles' jobs depend on the lists of the tiles alone. A change before them that moves no pose ends
# there; one of these jobs' own values does not touch the lists.
OF_TILES = {job.folder for job in PIPELINE.jobs.values() if job.unit == "tile"}
# With one of these values, its job reruns and what reads what it makes. By day a few do; pipeline_test tries
# a third of all programs then, as stubs. The night tries all.
CHANGES = [
    "drive.max_v_m_s=0.4", "plan.robot_radius_m=0.2", "localize.max_error_px=4.5", "landmarks.max_error_px=4.5",
    "grid.margin_m=0.3", "octree.max_range_m=3.9", "point_cloud.voxel_size_m=0.021", "tiles.overlap_m=0.6",
    "map_frame.floor_max_tilt_rad=0.6", "pose_graph.edge_sigma_floor_m=0.0035", "odometry.max_iterations=14",
    "loops.max_ratio=0.84", "matches.max_ratio=0.84", "vocabulary.num_kmeans_iterations=7", "features.num_features=900",
    "synthesize.color_noise_levels=2.5",
]


def reached_from(name):
    """Folders of a job and of those that its results go into, by the declared pipeline."""
    reached = {name}
    for job in PIPELINE.jobs.values():
        if job.goal in (*GOALS, "check") and job.program and reached & {*(reference.job for reference in job.inputs), *(found for found, _ in job.finds)}:
            reached.add(job.name)
    folders = {name: PIPELINE.jobs[name].folder for name in reached}
    return {name if folder == "RECORDING" else folder for name, folder in folders.items()}


class ChainTest(CopiedSiteTest):
    made = GOALS

    def setUp(self):
        super().setUp()
        self.base_lists = self.tile_lists()

    def tile_lists(self):
        return {name: digest for name, digest in self.work.hashes().items()
                if name.startswith("tiles/") and name.endswith(".json") and "report" not in name}

    def reran(self, *arguments):
        before = self.work.runs()
        self.make(*GOALS, *arguments)
        after = self.work.runs()
        return {stage for stage in after if before.get(stage) != after[stage]}

    def test_artifacts_agree_with_their_receipts(self):
        self.assertIn("all as written", self.make("verify"))
        self.work.path("grid/map.yaml").write_text("image: other.pgm\n")
        self.assertIn("map.yaml: altered", self.work.output("verify", code=2))

    def test_moved_folders_are_still_up_to_date(self):
        (self.work.folder / "maps").rename(self.work.folder / "results")
        (self.work.folder / "data").rename(self.work.folder / "recordings")
        moved = ["MAPS=results", "DATA=recordings"]
        self.assertEqual(self.work.make("-q", *GOALS, *moved).returncode, 0)
        self.assertIn("all as written", self.make("verify", *moved))

    def test_a_second_make_does_nothing(self):
        self.assertEqual(self.reran(), set())
        self.assertEqual(self.work.make("-q", *GOALS).returncode, 0)

    def test_comments_and_touches_rerun_nothing(self):
        for config in (self.work.folder / "configs").rglob("*.toml"):
            config.write_text(config.read_text() + "\n# a remark\n")
        self.assertEqual(self.reran(), set())
        self.assertEqual(self.work.make("-q", *GOALS).returncode, 0)

    def test_a_value_reruns_its_stage_and_what_follows(self):
        for change in some_of(CHANGES, one_in=5):
            with self.subTest(change=change):
                expected = reached_from(change.partition(".")[0])
                CopiedSiteTest.setUp(self)
                self.assertEqual(self.work.make("-q", *GOALS, f"SET={change}").returncode, 1)
                reran = self.reran(f"SET={change}")
                if "tiles" in expected and self.tile_lists() == self.base_lists:
                    expected = expected - OF_TILES
                self.assertEqual(reran, expected)

    def test_a_list_of_frames_that_comes_out_the_same_reruns_no_more(self):
        self.assertEqual(self.reran("SET=frames.max_failed_ratio=0.19"), {"frames"})

    def test_a_value_and_back_gives_the_first_bytes(self):
        self.make(*GOALS, "SET=octree.max_range_m=3.0")
        self.assertNotEqual(self.work.hashes(), self.hashes)
        self.make(*GOALS)
        self.assertEqual(self.work.hashes(), self.hashes)

    def num_occupied(self):
        """Voxels of the octree, and cells of the grid."""
        pixels = self.work.path("grid/map.pgm").read_bytes().split(b"\n255\n", 1)[1]
        return json.loads(self.work.path("octree/report.json").read_text())["num_occupied_voxels"], pixels.count(b"\0")

    def test_a_stricter_octree_occupies_no_more(self):
        before = self.num_occupied()
        for change in ("SET=octree.occupancy_threshold=0.9", "SET=octree.min_keyframes=4"):
            self.assertIn("octree_0_0", told_by_why(self.make("why", change))[0])
            self.make("map", change)
            voxels, cells = self.num_occupied()
            self.assertLess(voxels, before[0], change)
            self.assertLessEqual(cells, before[1], change)

    def test_looking_changes_nothing(self):
        change = "SET=octree.max_range_m=3.0"
        self.assertEqual(self.work.make("-q", "map", change).returncode, 1)
        why = self.make("why", change)
        self.assertIn("max_range_m", why)
        self.assertNotIn("features", why)
        self.assertEqual(self.work.make("-n", "map", change).returncode, 0)
        self.assertEqual(self.reran(), set())

    def test_a_deleted_artifact_is_remade_with_the_same_bytes(self):
        names = ("features/shard_0001.h5", "octree/map.bt", "pose_graph/report.json", "tiles/tile_0_0.json",
                 "frames/shard_0001.csv", "frames/cameras.json", "frames/held_out.csv", "frames/acceleration.h5",
                 "queries/queries.csv", "queries/query_cameras.json")
        for name in some_of(names, one_in=3):
            with self.subTest(name=name):
                self.work.path(name).unlink()
                self.make(*GOALS)
                self.assertEqual(self.work.hashes(), self.hashes)

    def test_files_of_floors_that_are_gone_are_removed(self):
        leftover = self.work.path("grid/floor_1.pgm")
        leftover.write_bytes(b"of an earlier octree")
        self.make("map", "SET=grid.margin_m=0.3")
        self.assertFalse(leftover.exists())
        self.make("map")
        self.assertEqual(self.work.hashes(), self.hashes)

    def add_a_floor(self):
        """As if grid had found one more, with the same cells; of the time of the other files."""
        grid = self.work.path("grid")
        floors = json.loads((grid / "floors.json").read_text())
        names = {kind: f"floor_1.{kind}" for kind in ("yaml", "png")}
        floors["floors"].append(floors["floors"][0] | {"number": 1, "height_m": 3.0} | names)
        upper = {"floors.json": json.dumps(floors), **{f"floor_1.{kind}": (grid / f"map.{kind}").read_bytes()
                                                       for kind in ("pgm", "png")},
                 "floor_1.yaml": (grid / "map.yaml").read_text().replace("map.pgm", "floor_1.pgm")}  # fmt: skip
        time_ns = (grid / "floors.json").stat().st_mtime_ns
        for name, content in upper.items():
            path = grid / name
            path.write_bytes(content if isinstance(content, bytes) else content.encode())
            os.utime(path, ns=(time_ns, time_ns))
        as_its_job_wrote(grid / "floors.json")

    def test_the_grids_of_all_floors_are_watched(self):
        self.add_a_floor()
        self.assertEqual(self.work.make("-q", *GOALS).returncode, 0)
        path = json.loads(self.work.path("plan/path.json").read_text())
        ends = [f"{name.upper()}={path[name]['x_m']},{path[name]['y_m']}" for name in ("start", "goal")]
        upstairs = [*ends, "SET=plan.floor=1"]
        self.assertEqual(self.reran(*upstairs), {"plan", "drive"})
        self.assertEqual(json.loads(self.work.path("drive/drive.json").read_text())["floor"], 1)
        self.assertEqual(self.reran(*upstairs), set())
        self.work.path("grid/floor_1.pgm").touch()
        self.assertEqual(self.reran(*upstairs), {"plan", "drive"})
        self.work.path("grid/floor_1.yaml").unlink()
        result = self.work.make(*GOALS, *upstairs)  # the floor is gone with the grid made anew
        self.assertEqual(result.returncode, 2)
        self.assertIn("option floor is 1, but the map has floor 0 (z = 0.00 m)", result.stdout)
        self.make(*GOALS)
        self.assertEqual(self.work.hashes(), self.hashes)

    def test_bytes_do_not_depend_on_threads_or_jobs(self):
        ways = (("one thread, two jobs", ["THREADS=1", "-j2"]), ("two threads, two jobs", ["THREADS=2", "-j2"]))
        for name, arguments in some_of(ways, one_in=2):
            with self.subTest(name):
                self.make("clean")
                self.make(*GOALS, *arguments)
                self.assertEqual(self.work.hashes(), self.hashes)

    def test_evaluation_and_report(self):
        self.make("report")
        for name in ("evaluate/metrics.json", "report/index.html"):
            self.assertGreater(self.work.path(name).stat().st_size, 100)
        self.assertEqual(self.work.make("-q", "report").returncode, 0)
        page = shown_text(self, self.work.path("report/index.html"))
        for text in ("small: nightmap", "Loops", "point_cloud", "items skipped"):
            self.assertIn(text, page)

    def test_the_status_of_a_good_run_leaves_no_failure(self):
        self.assertIn("ended with exit code 0", self.make("status"))
        self.assertFalse(self.work.path("logs/failure.json").exists())
        self.assertNotIn("The last run", self.work.path("report/index.html").read_text(encoding="utf-8"))

    def test_a_drive_that_does_not_arrive_commits_nothing(self):
        said = self.work.output("drive", "SET=drive.max_duration_s=0.5", code=2)
        self.assertIn("max_duration_s", said)
        self.assertRegex(said, r"drive/drive\.csv\] Error 3")
        self.assertEqual(self.work.hashes(), self.hashes)
        self.assertEqual(self.work.make("-q", "drive", "SET=drive.max_duration_s=0.5").returncode, 1)
        self.assertEqual(self.work.make("-q", "drive").returncode, 0)  # of this config is what is there

    def test_mistakes_in_what_is_asked_are_refused(self):
        for argument, message in [("SET=octree.max_rang_m=1", "unknown key 'max_rang_m'"),
                                  ("SET=octre.max_range_m=1", "no stage 'octre'"),
                                  ("SET=octree.max_range_m=far", "must be like its default"),
                                  ("SET=octree.max_range_m", "not STAGE.KEY=VALUE"),
                                  ("SET=octree.max_range_m=1e9", "max_range_m"),
                                  ("PROFILE=nowhere", "PROFILE: no profile 'nowhere' in configs; profiles: "),
                                  ("SEED=one", "whole number")]:
            with self.subTest(argument):
                self.assertIn(message, self.work.output("map", argument, code=2))
        self.assertEqual(self.work.hashes(), self.hashes)

    def test_a_recording_that_is_not_there(self):
        self.assertIn("datasets.md", self.work.output("map", "SITE=hololens_office", code=2))

    def test_a_site_without_queries_is_mapped_and_says_so(self):
        site = self.work.folder / f"configs/sites/{SITE}.toml"
        site.write_text(site.read_text().replace("hold_out_every = 7", "hold_out_every = 0"))
        self.make("map")
        self.assertEqual(self.work.make("-q", "map").returncode, 0)
        self.assertIn("has no query pictures", self.work.output("localize", code=2))
