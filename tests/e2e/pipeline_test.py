# SPDX-License-Identifier: Apache-2.0
"""The rules of a site, with programs that are stubs: what runs, what `why` and -q say of it, a second make at the same
time, what a failed run leaves."""
import os
import random
import re
import shutil
import signal
import subprocess
import time

from browser import shown_text
from nightly import IS_NIGHT, some_of
from stub_site import SITE, StubSite, StubTest
from workspace import PIPELINE, environment

from nightmap_site.declaration import import_keys, profiles
from nightmap_site.pipeline import closure

OF_MAP = closure(PIPELINE, ["map"]) & set(PIPELINE.jobs)
ASKED = ("map", "plan", "drive")


def jobs(names):
    """Names of jobs, of rules of which some are per shard or tile."""
    known = sorted(PIPELINE.jobs, key=len, reverse=True)
    return {next(job for job in known if name == job or name.startswith(f"{job}_")) for name in names}


class RulesTest(StubTest):
    def test_every_job_of_the_map_runs_once_and_then_none(self):
        self.make("map")
        ran = self.site.ran()
        self.assertEqual(len(ran), len(set(ran)))
        self.assertEqual(jobs(ran), OF_MAP)
        self.assertEqual(len([name for name in ran if name.startswith("features_")]), 3)
        self.make("map")
        self.assertEqual(self.site.ran(), [])
        self.make("-q", "map")

    def test_a_table_says_what_was_made(self):
        lines = self.make("map").splitlines()
        titles = next(line for line in lines if line.startswith("job "))
        for title in ("time (s)", "memory (MB)", "warnings", "counts"):
            self.assertIn(title, titles)
        self.assertRegex("\n".join(lines), r"features +3 of 3 +0\.3 +0\.3")
        self.assertNotIn("time (s)", self.make("map"))

    def test_strict_refuses_a_map_that_is_not_to_be_used(self):
        declaration = self.site.folder / "configs/dense/pipeline.toml"
        declaration.write_text(declaration.read_text().replace("[grid]\n", '[grid]\nsection.verdict = "height.py"\n'))
        (self.site.folder / "height.py").write_text(
            "from nightmap_eval.verdict.verdict import check\n\n\ndef checks(site):\n"
            "    yield check('height', 9.0, 'm', (0, 1), 'reason', 'measure it again', usable=(0, 2))\n")  # fmt: skip
        said = self.make("map")
        self.assertRegex(said, r"verdict: do not use\n  do not use: height 9 m \(0 to 1 m\): measure it again\n")
        for _ in "made", "up to date":
            said = self.make("map", "STRICT=1", code=2)
            self.assertIn("the verdict on the map of demo is: do not use (STRICT=1)", said)
            self.assertIn("Error 3", said)
        self.make("map", "STRICT=maybe", code=2)

    def test_why_names_the_option_that_changed(self):
        self.make("map")
        self.assertIn("grid: options of grid changed: margin_m 0.25 -> 0.4", self.make("why", "SET=grid.margin_m=0.4"))

    def test_appended_shards_rerun_what_they_reach(self):
        self.make("map")
        self.site.new_recording()
        self.make("map", num_shards=5)
        ran = self.site.ran()
        for job in ("features", "matches", "odometry"):
            self.assertEqual([name for name in ran if name.startswith(f"{job}_")], [f"{job}_0003", f"{job}_0004"])
        self.assertIn("vocabulary", ran)
        self.assertFalse(any(name.startswith("point_cloud_") for name in ran))
        clean = StubSite().removed_after(self)
        clean.make("map", num_shards=5)
        self.assertEqual(self.site.hashes(), clean.hashes())

    def test_a_shorter_recording_leaves_nothing_of_the_rest(self):
        self.make("map", num_shards=5)
        self.site.new_recording()
        self.make("map", num_shards=3)
        self.assertIn("vocabulary", self.site.ran())  # its inputs are fewer, and none is newer
        self.assertFalse(list(self.site.path("features").glob("*_0003.*")))
        self.make("-q", "map", num_shards=3)

    def test_rules_are_flat_and_long_lists_are_in_files(self):
        self.make("map", num_shards=300)
        rules = self.site.path("graph.mk").read_text()
        self.assertFalse("$(eval" in rules or "$(call" in rules)
        self.assertLess(max(map(len, rules.splitlines())), 2000)
        self.assertEqual(len(self.site.path("lists/features.features.txt").read_text().splitlines()), 300)
        self.make("-q", "map")

    def test_a_value_that_is_set_and_taken_back_reruns_nothing(self):
        """Each program gets a, b, which stops before it runs, and a again; programs may share a folder."""
        for program in some_of(PIPELINE.programs(), one_in=6):
            with self.subTest(program):
                self.make(*ASKED)
                self.make(*ASKED, f"SET={self.site.change_of(program)}", code=2, fails=program)
                self.make("-q", *ASKED)

    def test_a_value_of_a_profile_that_is_set_and_taken_back_reruns_nothing(self):
        for profile in sorted({*profiles(str(self.site.folder / "configs"))} - {"default"}):
            programs, goals = self.use_profile(profile)
            self.make(*goals)
            for program in some_of(programs, one_in=6):
                change = self.site.change_of(program, profile)
                with self.subTest(f"{profile}: {program}"):
                    self.assertEqual(change is None, program == "import_grid")  # it has no option
                    if change:
                        self.make(*goals, f"SET={change}", code=2, fails=program)
                    self.make("-q", *goals)

    def use_profile(self, profile):
        """Gives the site the profile and the files that its jobs import; returns the programs that the profile adds, and
        the goals: those of ASKED that it has jobs of, and a file of each job that other goals run."""
        imported = import_keys(str(self.site.folder / "configs"), profile)
        pipeline = self.site.use_profile(profile, imported)
        programs = set(pipeline.programs()) - set(PIPELINE.programs())
        self.assertEqual(not programs, profile == "published_rgbd")  # which has other values of options alone
        others = [job for job in pipeline.jobs.values() if job.program in programs and job.goal not in (*ASKED, "localize")]
        asked = [goal for goal in ASKED if goal in {job.goal for job in pipeline.jobs.values()}]
        return sorted(programs), asked + [f"maps/{SITE}/{job.folder}/{next(iter(job.outputs.values()))}" for job in others]

    def test_a_job_that_failed_runs_once_more_and_not_twice(self):
        self.make("map")
        self.make("localize", code=2, fails="localize")
        output = self.make("localize")
        self.assertEqual(output.splitlines().count("== localize"), 1, output)

    def test_results_inside_the_recording_are_no_part_of_it(self):
        site = self.site.folder / "configs/sites/demo.toml"
        site.write_text(site.read_text().replace("synthetic = true", "synthetic = false"))
        maps = "MAPS=data/demo/maps"
        for name in ("queries", "rgb"):
            (self.site.folder / "data/demo" / name).mkdir()
        (self.site.folder / "data/demo/queries/groundtruth.txt").touch()
        (self.site.folder / "data/demo/groundtruth.txt").touch()
        self.make("map", maps)
        self.make("-q", "map", maps)
        self.assertNotIn("== ", self.make("map", maps))
        (self.site.folder / "data/demo/rgb/1.png").touch()
        self.make("-q", "map", maps, code=1)

    def test_looking_changes_nothing(self):
        self.make("map")
        before = {path: path.stat().st_mtime_ns for path in self.site.folder.rglob("*") if ".preview" not in path.parts}
        for command in (["why", "SET=grid.margin_m=0.4"], ["-n", "map", "SET=grid.margin_m=0.4"]):
            self.make(*command)
        self.make("-q", "map", "SET=grid.margin_m=0.4", code=1)
        after = {path: path.stat().st_mtime_ns for path in self.site.folder.rglob("*") if ".preview" not in path.parts}
        before.pop(self.site.path("")), after.pop(self.site.path(""))  # which has the preview's folder
        self.assertEqual(before, after)


class TwoMakesTest(StubTest):
    def test_two_at_once_end_in_the_bytes_of_one(self):
        self.make("map")
        expected, draw = self.site.hashes(), random.Random(5)
        for attempt in range(20 if IS_NIGHT else 4):
            shutil.rmtree(self.site.path(""))
            runs = []
            for _ in range(2):
                runs.append(subprocess.Popen(self.site.command("map"), cwd=self.site.folder, env=environment(), text=True,
                                             stdout=subprocess.PIPE, stderr=subprocess.STDOUT))  # fmt: skip
                time.sleep(draw.uniform(0, 0.4))
            outputs = [run.communicate()[0] for run in runs]
            with self.subTest(attempt):
                self.assertEqual([run.returncode for run in runs], [0, 0], outputs)
                self.assertEqual(self.site.hashes(), expected)

    def test_the_second_names_the_first_and_waits(self):
        self.make("map")
        holder = subprocess.Popen(["/usr/bin/python3", "-c", "import fcntl, os, sys; f = open(sys.argv[1], 'w');"
                                   "fcntl.flock(f, fcntl.LOCK_EX); f.write(f'{os.getpid()} on this machine'); f.flush();"
                                   "print('held', flush=True); sys.stdin.read()", self.site.path(".lock")],
                                  stdin=subprocess.PIPE, stdout=subprocess.PIPE)  # fmt: skip
        self.addCleanup(holder.stdout.close)
        holder.stdout.readline()
        second = subprocess.Popen(self.site.command("map"), cwd=self.site.folder, env=environment(), text=True,
                                  stdout=subprocess.PIPE, stderr=subprocess.STDOUT)  # fmt: skip
        self.addCleanup(second.stdout.close)
        said = ""
        while "is being made" not in said and (line := second.stdout.readline()):
            said += line
        self.assertIn(f"is being made by process {holder.pid} on this machine", said)
        self.assertIsNone(second.poll())
        holder.stdin.close()
        self.assertEqual((second.wait(), holder.wait()), (0, 0))

    def test_the_lock_of_a_killed_make_is_free(self):
        self.make("map")
        first = subprocess.Popen(self.site.command("map", "SET=features.num_features=900"), cwd=self.site.folder,
                                 env=environment(), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                                 start_new_session=True)  # fmt: skip
        time.sleep(0.15)
        os.killpg(first.pid, signal.SIGKILL)
        first.wait()
        self.assertNotIn("is being made", self.make("map"))
        self.make("-q", "map")


class FailureTest(StubTest):
    def test_the_page_names_what_failed_and_what_is_out_of_date(self):
        declaration = self.site.folder / "configs/plan/pipeline.toml"  # without the job whose script reads grids, which no stub writes
        declaration.write_text(re.sub(r"\[floor_plan\]\n(?:(?!\[).*\n)*", "", declaration.read_text()))
        self.make(*ASKED, "export")
        for job in PIPELINE.jobs.values():
            if not job.program:
                continue
            with self.subTest(job.name):
                option = next(self.site.folder.glob(f"configs/*/default/{job.program}.toml")).read_text()
                self.assertTrue(option)
                for path in self.site.path(job.folder).glob("re*.json"):
                    path.unlink()
                if job.folder == "RECORDING":
                    (self.site.folder / "data/demo/synthesize.json").unlink()
                output = self.make(*ASKED, "export", code=2, fails=job.program)
                self.assertIn("report/index.html", output)
                page = self.site.path("report/index.html").read_text()
                self.assertIn(f"{job.name}", page)
                self.assertIn(f"error {job.program}: made to fail", page)
                self.assertIn("are out of date or were never made", page)
                self.make(*ASKED, "export")
                self.assertFalse(self.site.path("logs/failure.json").exists())

    def test_a_browser_shows_the_page_of_a_failed_run(self):
        self.make("map")
        self.make("map", "SET=octree.resolution_m=0.1", code=2, fails="octree")
        page = shown_text(self, self.site.path("report/index.html"))
        self.assertRegex(page, r"octree_\d+_0: exit code 1")
        self.assertIn("error octree: made to fail", page)
        self.assertRegex(page, r"(?m)^\d+ runs of jobs are out of date or were never made:\n")
        self.assertIn("join_octrees: maps/demo/octree/tile_0_0.ot will be remade", page)

    def test_outputs_of_the_last_good_run_stay(self):
        self.make("map")
        before = self.site.hashes()
        self.make("map", "SET=grid.margin_m=0.4", code=2, fails="grid")
        self.assertEqual(self.site.hashes(), before)
        self.assertIn("grid: exit code 1", self.make("status"))

    def test_the_make_after_makes_what_it_names(self):
        self.make("map")
        self.make("map", "SET=grid.margin_m=0.4", code=2, fails="grid")
        self.make("map", "SET=grid.margin_m=0.4")
        self.assertEqual(self.site.ran(), ["grid", "verdict"])
        self.make("-q", "map", "SET=grid.margin_m=0.4")

    def test_a_run_that_a_signal_ends_is_told_at_any_moment(self):
        self.make("map")
        draw = random.Random(6)
        for attempt in range(40 if IS_NIGHT else 8):
            shutil.rmtree(self.site.path(""))
            run = subprocess.Popen(self.site.command("map"), cwd=self.site.folder, env=environment(), text=True, stdout=subprocess.PIPE,
                                   stderr=subprocess.STDOUT, start_new_session=True)  # fmt: skip
            try:
                run.wait(draw.uniform(0.3, 1.5))
            except subprocess.TimeoutExpired:
                os.killpg(run.pid, signal.SIGTERM)
            said, _ = run.communicate()
            with self.subTest(attempt):
                self.assertNotIn("Traceback", said)
                self.assertNotIn("No such process", said)
                self.make("map")
                self.make("-q", "map")

    def test_a_run_that_goes_on_is_told_by_status(self):
        self.make("map")
        change, shut = "SET=octree.resolution_m=0.1", self.site.folder / "shut"
        journal = self.site.path("logs/journal.txt")
        journal.unlink()  # so that what it says next is the second run's
        shut.touch()
        wait = "LAUNCH=sh -c 'while [ -e shut ]; do sleep 0.02; done; exec \"$$0\" \"$$@\"'"
        run = subprocess.Popen(self.site.command("map", change, wait), cwd=self.site.folder, env=environment(), stdout=subprocess.DEVNULL)
        try:
            while not journal.exists() or "octree_0_0 begin" not in journal.read_text():
                self.assertIsNone(run.poll())
                time.sleep(0.02)
            said = self.make("status", change)
        finally:
            shut.unlink()
        self.assertRegex(said, r"make map goes on since .*, by process \d+ on .*: 0 jobs done, 1 run, \d+ wait")
        self.assertRegex(said, r"\n  octree_0_0 +\d+ s of about 0 s\nleft: about \d+ s, by earlier runs")
        self.assertEqual(run.wait(), 0)
        self.make("-q", "map", change)
        self.assertIn("ended with exit code 0", self.make("status", change))

    def test_a_killed_run_is_told_by_status(self):
        self.make("map")
        journal = self.site.path("logs/journal.txt")
        journal.write_text("1 make begin map\n2 features_0000 begin\n")
        status = self.make("status")
        self.assertIn("the last run, make map, was killed", status)
        self.assertIn("features_0000: did not come to its end", status)
        self.assertIn("features_0000", self.site.path("report/index.html").read_text())
