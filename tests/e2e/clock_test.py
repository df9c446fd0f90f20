# SPDX-License-Identifier: Apache-2.0
"""Results with times in the future, as after a clock was set back: make notices them, keeps their order, and reruns what a
change reaches."""
import os
import shutil
import time

from workspace import CopiedSiteTest

YEAR_NS = 365 * 24 * 3600 * 10**9
CHANGE = "SET=grid.robot_height_m=1.3"
REACHED = {"grid", "plan"}


class ClockTest(CopiedSiteTest):
    made = ("map", "plan")

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.base.make("map", "plan")  # which writes the list of floors for make
        cls.changed = cls.base.copy().removed_after(cls)
        cls.changed.output("map", "plan", CHANGE)

    def set_clock_back(self, *folders):
        """By a year, after everything below the folders was made."""
        for folder in folders:
            for path in (self.work.folder / folder).rglob("*"):
                if path.is_file():
                    time_ns = path.stat().st_mtime_ns + YEAR_NS
                    os.utime(path, ns=(time_ns, time_ns))

    def files(self):
        return [path for path in self.work.path("").rglob("*") if path.is_file() and ".preview" not in path.parts]

    def times(self):
        return {path: path.stat().st_mtime_ns for path in self.files()}

    def assert_none_in_future(self):
        now_ns = time.time_ns()
        self.assertEqual([path for path, time_ns in self.times().items() if time_ns > now_ns], [])

    def ran(self):
        """Jobs that ran, but for the verdict: a script has no receipt, and runs again when the clock was set back."""
        lines = [line.split() for line in self.work.path("logs/journal.txt").read_text().splitlines()]
        return {words[1] for words in lines if words[2] == "begin"} - {"make", "verdict"}

    def test_what_did_not_change_runs_not_again(self):
        self.set_clock_back("maps", "data")
        before = self.times()
        self.make("-q", "map", "plan", code=1)  # the verdict
        self.assertIn("times in the future", self.make("why"))
        self.assertEqual(self.times(), before)  # looking changes nothing
        said = self.make("map", "plan")
        self.assertIn("warning: files of maps/small have times in the future, up to 365 days ahead", said)
        self.assertEqual(self.ran(), set())
        self.assert_none_in_future()
        after = {path: time_ns for path, time_ns in self.times().items()
                 if path in before and not {"logs", "slots", "verdict"} & set(path.parts)}  # fmt: skip
        self.assertEqual(sorted(after, key=lambda path: (after[path], path)), sorted(after, key=lambda path: (before[path], path)))
        self.assertNotIn("future", self.make("map", "plan"))
        self.assertEqual(self.work.hashes(), self.base.hashes())

    def test_a_changed_option_reruns_what_it_reaches(self):
        self.set_clock_back("maps", "data")
        before = self.times()
        self.make("-q", "map", "plan", CHANGE, code=1)
        self.assertIn("== grid", self.make("-n", "map", "plan", CHANGE).replace("scripts/run_job.sh maps/small ", "== "))
        self.assertIn("grid: options of grid changed: robot_height_m 1.5 -> 1.3", self.make("why", CHANGE))
        self.assertEqual(self.times(), before)
        self.make("map", "plan", CHANGE)
        self.assertEqual(self.ran(), REACHED)
        self.assert_none_in_future()
        self.make("-q", "map", "plan", CHANGE)
        self.assertEqual(self.work.hashes(), self.changed.hashes())
        self.make("map", "plan")  # and back
        self.assertNotIn("future", self.make("map", "plan"))
        self.assertEqual(self.work.hashes(), self.base.hashes())

    def test_a_change_that_a_make_took_before_reaches_the_results_too(self):
        self.set_clock_back("maps/small/grid", "maps/small/plan")
        shutil.copy(self.changed.path("config/grid.toml"), self.work.path("config/grid.toml"))
        self.make("-q", "map", CHANGE, code=1)
        self.make("map", "plan", CHANGE)
        self.assertEqual(self.ran(), REACHED)
        self.assertEqual(self.work.hashes(), self.changed.hashes())

    def test_another_program_reruns_its_job(self):
        build = self.work.folder / "build"
        target = build.resolve()
        build.unlink()
        (build / "run").mkdir(parents=True)
        for program in (target / "run").iterdir():
            shutil.copy2(program, build / "run")
        (build / "programs.mk").touch()
        self.set_clock_back("maps", "data")
        with open(build / "run/grid", "ab") as program:
            program.write(b"another")
        os.utime(build / "run/grid", (10**9, 10**9))
        self.make("-q", "map", code=1)
        self.make("map", "plan")
        self.assertLessEqual({"grid"}, self.ran())
        self.assertLessEqual(self.ran(), REACHED)
        self.assertEqual(self.work.hashes(), self.base.hashes())
