#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Text of a user is data: no value of a variable, of a site config or name of a goal or folder is executed or written to. A
mistyped variable is refused. clean and distclean remove what nightmap made, and nothing else. The programs are stubs."""
import os
import re
import subprocess
import tempfile
import unittest

from nightly import some_of
from stub_site import SITE, StubSite
from workspace import REPOSITORY, environment

HOSTILE = ("a$(shell touch pwned)b", "a;touch pwned", "`touch pwned`", "$(touch pwned)", "a\ntouch pwned\n", "a'; touch pwned; '",
           'a"; touch pwned; "', "a>pwned", "a & touch pwned", "a|touch pwned", "$$(touch pwned)", "a\\\ntouch pwned")  # fmt: skip
COMMANDS = {"LAUNCH", "PYTHON"}  # a user's own commands
ODD_NAMES = ("a b.tum", "a;b.tum", "a`b.tum", "a'b.tum", "a#b.tum", "a:b.tum", "a|b.tum", "a\\b.tum", "a\nb.tum", "a$b.tum",
             "a$(shell touch pwned)b.tum", "a>x.tum", "a&b.tum", "a%b.tum", "a=b.tum", "a*b.tum", "../a.tum", "/tmp/a.tum")  # fmt: skip


def listed_variables():
    page = subprocess.run(["make", "help"], cwd=REPOSITORY, env=environment(), text=True, capture_output=True).stdout
    lines = page.partition("Variables")[2].splitlines()
    return {word for line in lines for word in re.split(r"\s{2,}", line.strip())[0].split() if re.fullmatch(r"[A-Z][A-Z_]*", word)}


class Site(unittest.TestCase):
    def setUp(self):
        self.site = StubSite()
        self.addCleanup(self.site.remove)
        self.folder = self.site.folder

    def make(self, *arguments, code=None, environment_=()):
        result = subprocess.run(["make", "--no-print-directory", *arguments], cwd=self.folder, text=True, stdin=subprocess.DEVNULL,
                                env=environment() | dict(environment_), stdout=subprocess.PIPE, stderr=subprocess.STDOUT)  # fmt: skip
        self.assertFalse((self.folder / "pwned").exists(), f"{arguments} {environment_}\n{result.stdout}")
        self.assertNotIn("Traceback", result.stdout)
        if code is not None:
            self.assertEqual(result.returncode, code, result.stdout)
        return result.stdout


class VariablesTest(Site):
    def test_the_front_page_lists_the_variables_that_are_taken_as_text(self):
        text = (REPOSITORY / "scripts/variables.mk").read_text()
        self.assertEqual(set(re.findall(r"(?m)^override (\w+) :=", text)), listed_variables())
        self.assertEqual(set(re.search(r"(?m)^export (.*)$", text)[1].split()), listed_variables())

    def test_no_value_is_executed(self):
        for name in sorted(listed_variables() - COMMANDS):
            for value in some_of(HOSTILE, one_in=3):
                goal = {"CASES": "help", "FIGURES": "help", "SANITIZED": "help"}.get(name, "map")
                with self.subTest(f"{name}={value}"):
                    self.make(goal, f"{name}={value}")
                    self.make(goal, environment_={name: value}.items())

    def test_no_value_reaches_the_make_of_a_site(self):
        """The run goes through, since text that only stands in a config is none of Make's business."""
        for name, value in (("SET", "plan.start='a$(shell touch pwned)b'"), ("START", "a$(shell touch pwned)b"), ("GOAL", "`touch pwned`"),
                            ("START", "a\ntouch pwned")):  # fmt: skip
            with self.subTest(f"{name}={value}"):
                self.make("map", "plan", f"{name}={value}", code=0)
                self.make("why", f"{name}={value}", code=0)
        self.make("help", "PROFILE=$(shell touch pwned)", code=0)

    def test_names_of_pictures(self):
        pictures = self.folder / "pictures"
        pictures.mkdir()
        for name in ("a$(shell touch pwned)b.jpg", "`touch pwned`.jpg", "a b.jpg", "a;touch pwned.jpg"):
            (pictures / name).write_bytes(b"x")
            self.make("map", f"QUERY='pictures/{name}'", "FOV_DEG=60", code=0)

    def test_a_goal_is_a_name(self):
        self.make("maps/demo/x;touch pwned", code=2)
        self.make("maps/demo/$(touch pwned)", code=2)

    def test_commands_are_commands(self):
        self.assertIn("it runs", self.make("map", "LAUNCH=env SAID='it runs' sh -c 'echo $$SAID; exec \"$$@\"' -"))

    def test_a_mistyped_variable_is_refused_with_the_nearest_name(self):
        for wrong, nearest in (("GAOL=1,-0.5", "GOAL"), ("SETT=", "SET"), ("quary=a.jpg", "QUERY"), ("MAP=x", "MAPS")):
            with self.subTest(wrong):
                output = self.make("plan", wrong, code=2)
                self.assertIn(f"{wrong.partition('=')[0]}: no such variable; did you mean {nearest}?", output)
        self.assertFalse((self.folder / "maps").exists())
        self.assertIn("no such variable", self.make("help", "XYZZY=1", code=2))
        self.make("help", environment_={"GAOL": "1"}.items(), code=0)  # the environment holds anything

    def test_values_that_cannot_be(self):
        for wrong, said in (("PYTHON=", "PYTHON is empty"), ("THREADS=two", "THREADS=two: give a whole number"), ("THREADS=", "whole number"),
                            ("LOG_LEVEL=loud", "give one of debug"), ("V=2", "give 0 or 1"), ("SITE=..", "must not begin"),
                            ("MAPS=-rf", "must not begin"), ("SITES=a b", "one word")):  # fmt: skip
            with self.subTest(wrong):
                self.assertIn(said, self.make("map", wrong, code=2))
        self.assertFalse((self.folder / "maps").exists())

    def test_why_checks_its_set_as_map_does(self):
        program = self.folder / "build/run/octree"
        program.unlink()
        program.write_text("#!/bin/sh\ncase \"$*\" in *--check-config*) grep -q 'resolution_m = 77.0' \"$3\" || exit 0\n"
                           "echo \"00:00:00 error octree: $3: resolution_m = 77 is out of range\"; exit 2;; esac\n")  # fmt: skip
        program.chmod(0o755)
        for goals in (["map"], ["why"], ["-n", "map"], ["-q", "map"]):
            self.assertIn("resolution_m = 77 is out of range", self.make(*goals, "SET=octree.resolution_m=77", code=2))
        self.make("why", "SET=octree.resolution_m=0.07", code=0)


class SiteConfigTest(Site):
    def write(self, text):
        path = self.folder / f"configs/sites/{SITE}.toml"
        path.write_text(text, encoding="utf-8")

    def test_a_profile_is_a_folder_of_configs(self):
        evil = self.folder / "x/evil"
        evil.mkdir(parents=True)
        (evil / "pipeline.toml").write_text('[report]\nscript = "../x/evil/run.py"\n')
        (evil / "run.py").write_text("open('pwned', 'w')\n")
        for profile in ("../x/evil", f"{evil}", "sites", "pipeline.toml", "", ".", "default/../default"):
            with self.subTest(profile):
                self.write(f"profile = '{profile}'\nsynthetic = true\n")
                output = self.make("report", code=2)
                self.assertIn(f"configs/sites/{SITE}.toml: no profile", output)
                self.assertIn("default, imported", output)
        self.write("synthetic = true\n")
        self.assertIn("PROFILE: no profile", self.make("report", "PROFILE=../x/evil", code=2))

    def test_names_of_imported_files_that_make_would_take_apart(self):
        for key in ("map", "trajectory"):
            for name in ODD_NAMES:
                if "/" not in name:
                    (self.folder / "data" / name).write_text("x")
                with self.subTest(f"{key} = {name}"):
                    text = name.replace("\\", "\\\\").replace("\n", "\\n")
                    self.write(f'profile = "imported"\nsynthetic = true\n[import]\n{key} = "{text}"\n')
                    for goals in (["map"], ["-q", "map"], ["why"]):
                        output = self.make(*goals, code=2)
                        self.assertIn(f"configs/sites/{SITE}.toml: [import] {key}", output)
                        self.assertRegex(output, "rename the file|a path below it")
        self.assertFalse((self.folder / "x.tum").exists())


class CleanTest(Site):
    ODD_FOLDERS = ("demo docs", "x;touch pwned;y", "$(touch pwned)", "$(shell touch pwned)", "-rf", "a'b", "a\nb")

    def test_distclean_removes_what_nightmap_made(self):
        data, maps = self.folder / "data", self.folder / "maps"
        self.make("map", code=0)
        made = [data / SITE, *(data / name for name in self.ODD_FOLDERS)]
        for folder in made:
            folder.mkdir(exist_ok=True)
            (folder / ".made_by_synthesize").touch()
        kept = [data / "docs", data / "demo_of_mine", maps / "notes", data / "x", data / "y"]
        for folder in kept:
            folder.mkdir()
            (folder / "mine.txt").write_text("mine")
        (maps / "mine.txt").write_text("mine")
        output = self.make("distclean", code=0)
        for folder in kept:
            self.assertTrue((folder / "mine.txt").exists(), folder)
        for folder in made:
            self.assertFalse(folder.exists(), folder)
        self.assertIn("removed data/demo docs\n", output)
        self.assertIn("left maps/notes: no results of a site", output)
        self.assertFalse((maps / SITE).exists())
        self.assertFalse((self.folder / "build").exists())

    def test_distclean_of_a_folder_full_of_other_things_leaves_them(self):
        with tempfile.TemporaryDirectory() as home:
            for name in ("photos", "build", "docs"):
                os.mkdir(f"{home}/{name}")
                open(f"{home}/{name}/mine.txt", "w").close()
            self.make("distclean", f"MAPS={home}", f"DATA={home}", f"BUILD={home}/build", code=0)
            self.assertEqual(sorted(os.listdir(home)), ["build", "docs", "photos"])
            self.make("clean", f"MAPS={home}", "SITE=photos", code=0)
            self.assertEqual(os.listdir(f"{home}/photos"), ["mine.txt"])

    def test_a_link_goes_and_its_target_stays(self):
        self.make("map", code=0)
        (self.folder / "disk").mkdir()
        os.rename(self.folder / "maps" / SITE, self.folder / "disk" / SITE)
        (self.folder / "maps" / SITE).symlink_to(self.folder / "disk" / SITE)
        self.assertIn(f"removed maps/{SITE}", self.make("clean", code=0))
        self.assertFalse(os.path.lexists(self.folder / "maps" / SITE))
        self.assertTrue((self.folder / "disk" / SITE / "graph.mk").exists())

    def test_clean_removes_the_site_alone_and_nothing_twice(self):
        self.make("map", code=0)
        self.assertEqual(self.make("clean", code=0), f"removed maps/{SITE}\n")
        self.assertEqual(self.make("clean", code=0), "")


if __name__ == "__main__":
    unittest.main()
