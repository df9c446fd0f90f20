#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""The Makefile and resolve_config.py without any stage program."""
import os
import pathlib
import re
import shlex
import shutil
import subprocess
import tempfile
import tomllib
import unittest

from workspace import PIPELINE, REPOSITORY, environment

PYTHON = "/usr/bin/python3"
FRESH_MACHINE = ("bash", "make", "git", "sed", "expand", "nproc")
DEFAULTS = {"octree": "resolution_m = 0.05\nnum_hits = 2\nmode = \"ray\"\n", "plan": "seed = 7\nstart = \"\"\n"}
SITE = 'root = "office"\n[[sequence]]\nfolder = "."\n'


class FreshMachineTest(unittest.TestCase):
    def test_front_page_and_first_commands_need_only_make(self):
        with tempfile.TemporaryDirectory() as folder:
            for tool in FRESH_MACHINE:
                os.symlink(shutil.which(tool), os.path.join(folder, tool))
            for goals in ([], ["help"], ["-n", "deps"], ["-n", "build"]):
                result = subprocess.run(["make", "PYTHON=/nonexistent", *goals], cwd=REPOSITORY, text=True,
                                        env=environment() | {"PATH": folder}, capture_output=True)
                self.assertEqual(result.returncode, 0, result.stderr)
                self.assertEqual(result.stderr, "")
            front_page = subprocess.run(["make"], cwd=REPOSITORY, env=environment() | {"PATH": folder},
                                        text=True, capture_output=True).stdout
            for word in ("make demo", "make test", "SITE", "sites:"):
                self.assertIn(word, front_page)

    def test_every_goal_is_on_the_front_page(self):
        text = "".join((REPOSITORY / name).read_text(encoding="utf-8") for name in ("Makefile", "scripts/development.mk"))
        lists = re.findall(r"(?m)^(?:\.PHONY:|OF_SITE :=)(.*)$", text)
        goals = {word for line in lists for word in line.split() if re.fullmatch(r"[a-z][a-z-]*", word)}
        goals |= set(PIPELINE.goals)
        self.assertGreater(len(goals), 20)
        front_page = subprocess.run(["make", "help"], cwd=REPOSITORY, env=environment(), text=True,
                                    capture_output=True).stdout
        for goal in goals - {"the_site"}:
            self.assertIn(f"make {goal} ", front_page)

    def test_the_makefile_is_a_front_page(self):
        text = (REPOSITORY / "Makefile").read_text(encoding="utf-8")
        self.assertLessEqual(len(text.splitlines()), 150)
        for path in (REPOSITORY / "Makefile", *(REPOSITORY / "scripts").glob("*.mk")):
            self.assertNotIn("$(eval", path.read_text(encoding="utf-8"), path.name)


class BuildTest(unittest.TestCase):
    def test_two_at_the_same_time_take_turns(self):
        """Of two sites made in one checkout, each builds the programs first."""
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)
            for tool in ("cmake", "ninja"):
                (root / tool).write_text(f"#!/bin/sh\necho {tool} >> {root}/calls\nsleep 0.3\n")
                (root / tool).chmod(0o755)
            command = ["make", "--eval=override PROGRAMS :=", f"BUILD={root}/build", f"{root}/build/programs.mk"]
            path = {"PATH": f"{root}:{os.environ['PATH']}"}
            runs = [subprocess.Popen(command, cwd=REPOSITORY, env=environment() | path, text=True,
                                     stdout=subprocess.DEVNULL, stderr=subprocess.PIPE) for _ in range(2)]
            for run in runs:
                _, errors = run.communicate()
                self.assertEqual((run.returncode, errors), (0, ""))
            self.assertEqual((root / "calls").read_text().split(), ["cmake", "ninja"] * 2)


class ResolveConfigTest(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="nightmap-e2e-"))
        self.addCleanup(shutil.rmtree, self.folder)
        for name in ("configs/default", "configs/coarse", "configs/sites", "data/office"):
            (self.folder / name).mkdir(parents=True)
        for stage, text in DEFAULTS.items():
            self.write(f"default/{stage}.toml", text)
        self.write("sites/office.toml", SITE)

    def write(self, name, text):
        path = self.folder / "configs" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")

    def resolve(self, *arguments, code=0, options=()):
        result = subprocess.run([PYTHON, "-I", "-S", *options, REPOSITORY / "scripts/resolve_config.py", "--site",
                                 "configs/sites/office.toml", "--data", "data", "--out", "maps/office/config", *arguments],
                                cwd=self.folder, capture_output=True, text=True)
        self.assertEqual(result.returncode, code, result.stderr)
        return result

    def config(self, stage, folder="config"):
        return tomllib.loads((self.folder / "maps/office" / folder / f"{stage}.toml").read_text())

    def time(self, stage):
        return (self.folder / "maps/office/config" / f"{stage}.toml").stat().st_mtime_ns

    def test_later_layers_win(self):
        self.resolve("--profile", "default")
        self.assertEqual(self.config("octree"), {"resolution_m": 0.05, "num_hits": 2, "mode": "ray"})
        self.assertEqual(self.config("plan")["seed"], 0)
        self.write("coarse/octree.toml", "resolution_m = 0.1\nnum_hits = 3\n")
        self.write("sites/office/octree.toml", "num_hits = 4\n")
        self.resolve("--profile", "coarse", "--seed", "5", "--set", "octree.mode=beam  plan.start='1 2'")
        self.assertEqual(self.config("octree"), {"resolution_m": 0.1, "num_hits": 4, "mode": "beam"})
        self.assertEqual(self.config("plan"), {"seed": 5, "start": "1 2"})
        self.resolve("--profile", "coarse", "--set", "octree.num_hits=9")
        self.assertEqual(self.config("octree")["num_hits"], 9)

    def test_rewritten_only_when_the_meaning_changes(self):
        self.resolve()
        octree, plan = self.time("octree"), self.time("plan")
        self.write("default/octree.toml", "mode = 'ray' # said otherwise\nnum_hits=2\nresolution_m = 5e-2\n")
        self.resolve("--set", "octree.resolution_m=0.050")
        self.assertEqual(self.time("octree"), octree)
        self.resolve("--set", "octree.resolution_m=1")
        self.assertNotEqual(self.time("octree"), octree)
        self.assertEqual(self.time("plan"), plan)

    def test_preview_leaves_the_real_configs_alone(self):
        self.resolve()
        octree = self.time("octree")
        self.resolve("--preview", "maps/office/.preview", "--set", "octree.num_hits=5")
        self.assertEqual((self.time("octree"), self.config("octree")["num_hits"]), (octree, 2))
        self.assertEqual(self.config("octree", ".preview")["num_hits"], 5)
        self.assertEqual((self.folder / "maps/office/.preview/plan.toml").stat().st_mtime_ns, self.time("plan"))

    def test_mistakes_exit_with_2_and_say_what_is_right(self):
        self.write("coarse/octre.toml", "num_hits = 3\n")
        for arguments, message in [(["--set", "octre.num_hits=3"], "stages: octree, plan"),
                                   (["--set", "octree.hits=3"], "known keys: mode, num_hits, resolution_m"),
                                   (["--set", "octree.num_hits"], "not STAGE.KEY=VALUE"),
                                   (["--set", "octree.num_hits="], "not STAGE.KEY=VALUE"),
                                   (["--set", "octree.num_hits=3.5"], "must be like its default 2"),
                                   (["--set", "octree.num_hits=true"], "must be like its default 2"),
                                   (["--set", "octree.mode='ray"], "quotation"),
                                   (["--profile", "fine"], "profiles: coarse, default"),
                                   (["--profile", "sites"], "profiles: coarse, default"),
                                   (["--profile", "coarse"], "no stage 'octre'"),
                                   (["--seed", "-1"], "whole number"),
                                   (["--site", "configs/sites/home.toml"], "sites: office"),
                                   (["--data", "elsewhere"], "datasets.md")]:
            with self.subTest(arguments):
                self.assertIn(message, self.resolve(*arguments, code=2).stderr)
        self.write("default/plan.toml", "seed = \n")
        self.assertIn("plan.toml: not valid TOML", self.resolve(code=2).stderr)

    def site(self, folder="config"):
        return tomllib.loads((self.folder / "maps/office" / folder / "queries/office.toml").read_text())

    def picture(self, name):
        path = self.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(b"pixels")
        return path

    def test_the_copy_of_the_site_has_the_lines_and_the_name_of_the_users_file(self):
        copy = self.folder / "maps/office/config/site/office.toml"
        site = self.folder / "configs/sites/office.toml"
        self.resolve()
        time_ns = copy.stat().st_mtime_ns
        site.write_text("# a new first line\n" + SITE)  # means the same, so nothing is stale
        self.resolve()
        lines = site.read_text().splitlines()
        self.assertEqual(copy.read_text().splitlines()[:len(lines)], lines)
        self.assertIn("# This was the text of configs/sites/office.toml; QUERY adds:\n", copy.read_text())
        self.assertEqual(copy.stat().st_mtime_ns, time_ns)
        site.write_bytes(SITE.encode() + b"# B\xfcro\n")
        self.assertRegex(self.resolve(code=2).stderr, r"office\.toml: .*not UTF-8 text")
        site.write_text(SITE)

    def test_a_query_whose_name_is_not_text_is_refused(self):
        for name in (b"\xff.jpg", b"a\nb.jpg"):
            path = os.path.join(os.fsencode(self.folder), name)
            open(path, "wb").close()
            result = self.resolve("--query", shlex.quote(os.fsdecode(name)), code=2)
            self.assertIn("rename it", result.stderr)

    def test_query_adds_pictures_to_the_site_for_one_run(self):
        self.picture("start.jpg")
        self.picture("data/office/extra/my goal.jpg")
        self.resolve()
        self.assertEqual(self.site(), tomllib.loads(SITE))
        copies = [self.folder / f"maps/office/config/{part}/office.toml" for part in ("site", "queries")]
        before = [copy.stat().st_mtime_ns for copy in copies]
        self.resolve("--query", "start.jpg 'data/office/extra/my goal.jpg'", "--fov-deg", "60")
        expected = [{"layout": "pictures", "pictures": path, "horizontal_fov_deg": 60.0}
                    for path in ("../../start.jpg", "extra/my goal.jpg")]
        self.assertEqual(self.site(), tomllib.loads(SITE) | {"query": expected})
        after = [copy.stat().st_mtime_ns for copy in copies]
        self.assertEqual([new == old for new, old in zip(after, before)], [True, False])
        self.resolve()
        self.assertEqual(self.site(), tomllib.loads(SITE))
        self.resolve("--query", "start.jpg", "--camera", "phone", "--preview", "maps/office/.preview")
        self.assertEqual(self.site(".preview")["query"][0]["camera"], "phone")
        self.assertEqual(self.site(), tomllib.loads(SITE))

    def test_query_is_found_through_a_data_folder_that_is_a_link(self):
        picture = self.picture("photos/start.jpg")
        (self.folder / "disk").mkdir()
        (self.folder / "data").rename(self.folder / "disk/recordings")
        (self.folder / "data").symlink_to("disk/recordings")
        self.resolve("--query", "photos/start.jpg")
        path = os.path.normpath(os.path.join("office", self.site()["query"][0]["pictures"]))
        self.assertTrue((self.folder / "data" / path).samefile(picture))
        self.resolve("--query", str(picture))
        self.assertFalse(os.path.isabs(self.site()["query"][0]["pictures"]))

    def test_query_is_found_from_a_data_folder_beside_the_working_folder(self):
        picture = self.picture("photos/start.jpg")
        with tempfile.TemporaryDirectory(dir=self.folder.parent) as beside:
            for folder in (pathlib.Path(beside), pathlib.Path(beside) / "data"):
                shutil.copytree(self.folder / "data", folder, dirs_exist_ok=True)
                self.resolve("--query", "photos/start.jpg", "--data", str(folder))
                path = os.path.normpath(os.path.join("office", self.site()["query"][0]["pictures"]))
                self.assertTrue((folder / path).samefile(picture), path)

    def test_a_changed_picture_of_a_query_is_noticed(self):
        """And of a recording that synthesize makes nothing else, since it is not there at first."""
        self.picture("photos/a.jpg")
        self.picture("photos/b.jpg")
        (self.folder / "list.txt").write_text("# two\nphotos/a.jpg\n\n")
        pictures = self.folder / "maps/office/config/pictures"
        for query in ("photos", "photos/a.jpg", "list.txt"):
            for synthetic in ([], ["--synthetic"]):
                arguments = ["--query", query, *synthetic]
                with self.subTest(arguments):
                    result = self.resolve(*arguments)
                    self.assertEqual(result.stdout.split(), ["recordings=maps/office/config/recordings", "pictures=maps/office/config/pictures"])
                    before = pictures.read_text()
                    self.picture("other/c.jpg")
                    self.resolve(*arguments)
                    self.assertEqual(pictures.read_text(), before)
                    with open(self.folder / "photos/a.jpg", "ab") as file:
                        file.write(b"more")
                    self.resolve(*arguments)
                    self.assertNotEqual(pictures.read_text(), before)
                    before = pictures.read_text()
                    folder = self.folder / ("" if query == "list.txt" else "photos")
                    (folder / "cameras.csv").write_text("picture\n")
                    self.resolve(*arguments)
                    self.assertNotEqual(pictures.read_text(), before)
                    (folder / "cameras.csv").unlink()

    def test_mistakes_in_a_query_exit_with_2(self):
        self.picture("a.jpg")
        for arguments, message in [(["--query", "nowhere.jpg"], "QUERY: nowhere.jpg does not exist"),
                                   (["--query", "a.jpg", "--fov-deg", "wide"], "give a number of degrees"),
                                   (["--camera", "phone"], "CAMERA and FOV_DEG describe the pictures of QUERY"),
                                   (["--query", "'a.jpg"], "quotation")]:
            with self.subTest(arguments):
                self.assertIn(message, self.resolve(*arguments, code=2).stderr)
        self.write("sites/office.toml", SITE + '[query]\nlayout = "pictures"\npictures = "a.jpg"\n')
        self.assertIn("must be written as [[query]]", self.resolve(code=2).stderr)

    def test_imports_little(self):
        """It runs whenever make does. Imports are nearly all of its time, and their number is no matter of load."""
        self.resolve()
        self.assertLess(self.resolve(options=["-X", "importtime"]).stderr.count("import time:"), 100)


if __name__ == "__main__":
    unittest.main()
