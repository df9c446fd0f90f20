# SPDX-License-Identifier: Apache-2.0
"""Lists of shards, tiles and floors are data for Make: damaged ones are made anew, hostile ones run nothing,
and results of shards that are no more disappear."""
import json
import subprocess
import unittest

from nightly import IS_NIGHT
from workspace import SITE, CopiedSiteTest, Workspace, environment

TOUCH = "$(shell touch {0}/pwned)$(info x)`touch {0}/pwned`"
OFFICE = """\
root = "office"
[[camera]]
id = "color"
width = 640
height = 480
fx = 525
fy = 525
cx = 319.5
cy = 239.5
depth_units_per_m = 5000
depth_registered = true
[[sequence]]
layout = "tum"
folder = "."
camera = "color"
"""
ONE_SHARD = "SET=frames.max_frames=20"  # of shard_size = 25


class ListsTest(CopiedSiteTest):
    made = ("map", "localize")

    def test_a_damaged_list_is_made_anew_by_its_stage(self):
        for name, stage in (("frames/shards.txt", "frames"), ("tiles/tiles.txt", "tiles"), ("grid/floors.json", "grid"),
                            ("queries/queries.txt", "queries")):
            path = self.work.path(name)
            whole, before = path.read_bytes(), self.work.runs()
            damaged = [whole[:-3], b"" if stage == "queries" else whole.replace(b"0", b"$(shell exit)")]  # a query may have any name
            if stage == "frames" or IS_NIGHT:  # how lists are read is the same for all
                damaged += [b"", b"SHARDS := 0000\n", b"\tx\n", whole + whole]
            for content in damaged:
                with self.subTest(name, content=content[:40]):
                    path.write_bytes(content)
                    self.assertEqual(self.work.make("-q", "map").returncode, 1)
                    self.assertEqual(path.read_bytes(), content)  # looking changes nothing
                    self.assertIn(f"{stage}: its last run", self.make("why"))
                    said = self.make("map")
                    lines = [line for line in said.splitlines() if line.startswith("nightmap:")]
                    self.assertEqual(len(lines), 1, said)
                    self.assertRegex(lines[0], f"{name}.*: {stage} makes it anew")
                    self.assertEqual(path.read_bytes(), whole)
                    self.assertEqual(self.work.make("-q", "map").returncode, 0)
            after = self.work.runs()
            woken = {run for run in after if after[run] != before.get(run)}
            self.assertEqual(woken, {stage})
        self.assertEqual(self.work.hashes(), self.hashes)

    def test_a_truth_of_queries_that_is_gone_comes_back(self):
        path = self.work.path("queries/query_ground_truth.tum")
        whole = path.read_bytes()
        path.unlink()
        self.assertEqual(self.work.make("-q", "map").returncode, 1)
        self.make("map")
        self.assertEqual(path.read_bytes(), whole)
        self.assertEqual(self.work.make("-q", "map").returncode, 0)

    def test_results_of_shards_that_are_no_more_are_removed_and_come_back(self):
        self.assertGreater(len(list(self.work.path("features").glob("shard_*.h5"))), 1)
        self.make("map", ONE_SHARD)
        for stage in ("features", "matches", "odometry"):
            names = {path.name for path in self.work.path(stage).glob("*_0*")}
            self.assertEqual({name[:-len(name.split(".")[1]) - 1].split("_")[1] for name in names}, {"0000"}, names)
        self.make("evaluate", ONE_SHARD)
        self.assertNotIn("shard_0001", self.work.make("verify").stdout)
        self.make("map", "localize")
        hashes = {name: digest for name, digest in self.work.hashes().items() if not name.startswith("evaluate/")}
        self.assertEqual(hashes, self.hashes)
        self.assertIn("all as written", self.make("verify"))

    def test_results_of_queries_that_are_no_more_are_removed_and_come_back(self):
        site = self.work.folder / f"configs/sites/{SITE}.toml"
        text = site.read_text()
        self.make("report")
        self.assertIn("<dt>queries located</dt>", self.work.path("report/index.html").read_text())
        mine = self.work.path("localize/notes.txt")
        mine.write_text("of the user\n")
        site.write_text(text.replace("hold_out_every = 7", "hold_out_every = 0"))
        self.make("-q", "map", code=1)
        self.assertIn("no longer has localize", self.make("map"))
        self.assertEqual(list(self.work.path("localize").iterdir()), [mine])
        self.make("report")
        self.assertNotIn("<dt>queries located</dt>", self.work.path("report/index.html").read_text())
        self.assertNotIn("queries", json.loads(self.work.path("evaluate/metrics.json").read_text()))
        self.assertIn("all as written", self.make("verify"))
        mine.unlink()
        site.write_text(text)
        self.make("map", "localize")
        hashes = {name: digest for name, digest in self.work.hashes().items() if not name.startswith("evaluate/")}
        self.assertEqual(hashes, self.hashes)

    def test_localize_says_where_its_pictures_were_taken(self):
        said = self.make("localize").splitlines()
        queries = self.work.path("localize/queries.csv").read_text().splitlines()[1:]
        self.assertIn(f"{len(queries)} queries of the site: ", "\n".join(said))
        with open(self.work.path("frames/shard_0000.csv"), encoding="utf-8") as file:
            picture = file.read().splitlines()[1].split(",")[4]
        copy = self.work.folder / "asked.png"
        copy.write_bytes((self.work.folder / "data" / picture).read_bytes())
        said = self.make("localize", "QUERY=asked.png", "CAMERA=" + self.camera()).splitlines()
        rows = [line.split() for line in said if "asked.png" in line and "queries.csv" not in line]
        self.assertEqual(len(rows), 1, said)
        self.assertEqual(rows[0][1], "located")
        position = [float(value) for value in rows[0][2:5]]
        frame = self.work.path("map_frame/trajectory.tum").read_text().splitlines()
        true = next(line for line in frame if not line.startswith("#")).split()[1:4]
        for found, expected in zip(position, true):
            self.assertAlmostEqual(found, float(expected), delta=0.1)

    def camera(self):
        text = (self.work.folder / f"configs/sites/{SITE}.toml").read_text()
        return text.split("[[camera]]")[1].split("id =")[1].split('"')[1]

    def test_the_report_says_that_the_last_plan_failed(self):
        self.make("plan")
        self.make("report")
        page = self.work.path("report/index.html")
        self.assertNotIn("The last run of plan failed", page.read_text())
        self.make("plan", "START=1000,1000", "GOAL=1001,1000", code=2)
        self.assertEqual(self.work.make("-q", "report").returncode, 1)
        self.make("report")
        text = page.read_text()
        self.assertIn("The last run of plan failed, the path shown here is of an earlier run: start", text)
        self.make("report", "SET=grid.margin_m=0.3")
        self.assertIn("The path is out of date", page.read_text())
        self.make("plan", "SET=grid.margin_m=0.3")
        self.make("report", "SET=grid.margin_m=0.3")
        for note in ("out of date", "The last run of plan failed"):
            self.assertNotIn(note, page.read_text())

    def test_the_make_after_a_failed_one_renews_the_page(self):
        self.make("plan", "START=1000,1000", "GOAL=1001,1000", code=2)
        page = self.work.path("report/index.html")
        self.assertIn("failed or was killed", page.read_text())
        self.make("map")
        self.assertNotIn("failed or was killed", page.read_text())
        self.assertFalse(self.work.path("evaluate/metrics.json").exists())


class HostileFilesTest(unittest.TestCase):
    """`make -n` in a folder whose results were put there by somebody else."""

    def setUp(self):
        self.folder = Workspace().folder
        self.addCleanup(Workspace(self.folder).remove)
        recording = self.folder / "data" / "office"
        recording.mkdir(parents=True)
        (self.folder / "configs/sites/office.toml").write_text(OFFICE)

    def write(self, name, text):
        path = self.folder / "maps/office" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)

    def make(self, *arguments):
        return subprocess.run(["make", "SITE=office", *arguments], cwd=self.folder, env=environment(), text=True,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT)

    def test_nothing_in_them_is_run(self):
        touch = TOUCH.format(self.folder)
        names = {"frames/shards.txt": ("shards", "0000"), "tiles/tiles.txt": ("tiles", "0_0")}
        floors = {"format": "nightmap floors", "version": 2,
                  "floors": [{"number": 0, "height_m": 0.0, "yaml": f"{touch}.yaml"}]}
        for header in ("{touch}", "nightmap {kind}, version 1, 1 names\n{touch}",
                       "nightmap {kind}, version 1, 2 names\n{name}\n{touch}\n",
                       "{variable} := {touch}", "nightmap {kind}, version 1, 1 names\n{name} {touch}\n"):
            for name, (kind, good) in names.items():
                self.write(name, header.format(touch=touch, kind=kind, name=good, variable=kind.upper()) + "\n")
            self.write("queries/queries.txt", f"a {touch}\n{touch}\n")
            self.write("grid/floors.json", json.dumps(floors, indent=1))
            self.write("plan/receipt_$(touch pwned).json", "{}")
            self.write("features/receipt_0000$(shell touch pwned).json", "{}")
            (self.folder / "data/office/$(touch pwned).png").write_text("x")
            for goals in (["-n", "map"], ["-q", "map"], ["why"], ["-n", "report", "plan"], ["-n", "localize"]):
                with self.subTest(header, goals=goals):
                    result = self.make(*goals)
                    self.assertIn(result.returncode, (0, 1), result.stdout)
                    self.assertNotIn("missing separator", result.stdout)
                    self.assertFalse((self.folder / "pwned").exists(), result.stdout)

    def test_names_that_make_or_a_shell_would_take_apart_are_refused(self):
        for argument in ("DATA=a:b", "MAPS=a,b", "DATA=a$$(pwd)", "MAPS=a;b", "BUILD=a'b", "SITE=a`b`", "DATA=a=b", "MAPS=a%"):
            with self.subTest(argument):
                result = self.make("-n", "map", argument)
                self.assertEqual(result.returncode, 2)
                self.assertIn("rename the folder or make a link", result.stdout)
        self.assertFalse((self.folder / "pwned").exists())

    def test_the_front_page_runs_no_name_of_a_config(self):
        (self.folder / "configs/sites/$(touch pwned).toml").write_text("")
        self.assertEqual(self.make("help").returncode, 0)
        self.assertFalse((self.folder / "pwned").exists())
