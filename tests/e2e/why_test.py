#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Jobs that `make why` names are those that the next make runs, in every profile, after a change of each stage's options and
of the site's config. The programs are stubs."""
import shutil
import unittest

from nightly import some_of
from stub_site import SITE, StubSite
from workspace import REPOSITORY, SiteTest, told_by_why
from nightmap_site.declaration import profiles  # workspace finds the scripts

# Profiles, each with what its sites may import.
VARIANTS = [variant for variant in (
            ("default", ()), ("ceiling", ()), ("imported", ("trajectory",)), ("imported", ("map",)), ("labels", ("model",)),
            ("laser", ()), ("laser", ("trajectory",)), ("laser", ("map",)), ("laser", ("objects",)), ("moving", ()),
            ("moving", ("model",)), ("published_ceiling", ()), ("published_laser", ()), ("published_people", ("model",)),
            ("published_rgbd", ()), ("wheels", ())) if (REPOSITORY / "configs" / variant[0]).is_dir()]  # fmt: skip
GOALS = ("map", "localize", "plan", "drive")
SCAN_QUERY = '\n[[query]]\nscans = "wake.log"\nnear_m = [3.5, -2]\nturn = "none"\n'


class WhyTest(SiteTest):
    def setUp(self):
        self.work = self.site = StubSite()
        self.addCleanup(self.site.remove)
        self.config = self.site.folder / f"configs/sites/{SITE}.toml"

    def use(self, profile, imported):
        self.pipeline = self.site.use_profile(profile, imported)
        of_goals = {job.goal for job in self.pipeline.jobs.values()}
        self.goals = [goal for goal in GOALS if goal in of_goals]
        self.others = {job.name for job in self.pipeline.jobs.values() if job.goal not in self.goals}
        self.make(*self.goals)

    def named(self, *change):
        """The rules of the goals that `why` says will run, and those that may."""
        return [rules - self.others for rules in told_by_why(self.make("why", *self.goals, *change))]

    def is_told(self, *change, changes=""):
        """Runs what `why` names after a change; returns the rules that ran. changes: whether what keeps its time changes."""
        will, may = self.named(*change)
        self.make("-q", *self.goals, *change, code=1 if will else 0)
        self.make(*self.goals, *change, changes=changes)
        ran = set(self.site.ran()) - self.others
        self.assertEqual(ran, will | may if changes else will)
        self.assertTrue(ran)
        self.make("-q", *self.goals, *change)
        return ran

    def test_all_profiles_are_tried(self):
        self.assertEqual(sorted({profile for profile, _ in VARIANTS}), profiles(str(REPOSITORY / "configs")))

    def test_it_names_what_runs_after_a_change_of_an_option(self):
        for number, (profile, imported) in enumerate(VARIANTS):
            self.use(profile, imported)
            names = sorted({job.options for job in self.pipeline.jobs.values() if job.options and job.name not in self.others})
            for options in some_of(names[number % 6:] + names[:number % 6], one_in=6):
                change = self.site.change_of(options, profile)
                with self.subTest(f"{profile} {imported}: {change}"):
                    if change:
                        self.is_told(f"SET={change}", changes="1")
                        self.is_told()

    def edited(self, old, new, changes):
        text = self.config.read_text()
        self.assertEqual(text.count(old), 1, old)
        self.config.write_text(text.replace(old, new))
        return self.is_told(changes=changes)

    def test_it_names_what_runs_after_a_change_of_a_scanner_and_of_a_query(self):
        self.use("laser", ())
        tables = (REPOSITORY / "configs/sites/demo_laser.toml").read_text().partition("[[sensor]]")
        self.config.write_text(f'root = "{SITE}"\nprofile = "laser"\n\n{"".join(tables[1:])}{SCAN_QUERY}')
        for name in ("robot.log", "robot_groundtruth.txt", "wake.log"):
            (self.site.folder / "data" / SITE / name).write_text("as a robot writes it\n")
        self.make(*self.goals)
        for old, new in (("max_range_m = 30", "max_range_m = 29"), ("scan_duration_s = 0.0133", "scan_duration_s = 0.02"),
                         ("robot_from_sensor = [0.0,", "robot_from_sensor = [0.1,")):  # fmt: skip
            with self.subTest(new):
                self.assertLess({"frames", "odometry", "grid", "localize"}, self.edited(old, new, changes="1"))
                self.assertEqual(self.edited(new, old, changes="") & {"frames", "odometry", "grid"}, {"frames"})
        for old, new in (("near_m = [3.5, -2]", "near_m = [3.5, 2]"), ('turn = "none"', 'turn = "left"')):
            with self.subTest(new):
                self.assertEqual(self.edited(old, new, changes="1") & {"frames", "queries", "localize"}, {"queries", "localize"})

    def test_things_follow_the_voxels_that_are_written_beside_an_octree(self):
        """Under -j, too, and when a plan alone is asked for."""
        self.use("labels", ("model",))
        self.site.path("voxel_labels/voxels.h5").unlink()
        self.make("-q", "map", code=1)
        self.make("-j4", "map")
        self.assertIn("things", self.site.ran())
        for change, goal in (("voxel_labels.keyframe_stride=2", "plan"), ("voxel_labels.keyframe_stride=1", "map")):
            self.make("-j4", goal, f"SET={change}", changes="1")
            self.assertLess({"voxel_labels_0_0", "join_labels", "things"}, set(self.site.ran()))
            self.make("-q", goal, f"SET={change}")

    def test_a_job_that_goes_first_and_fails_costs_no_other(self):
        self.use("labels", ("model",))
        shutil.rmtree(self.site.path(""))
        self.make("map", code=2, fails="join_labels")
        self.assertLess({"grid", "landmarks", "join_labels"}, set(self.site.ran()))


if __name__ == "__main__":
    unittest.main()
