# SPDX-License-Identifier: Apache-2.0
"""The profile laser: the map of the made-up building by its robot's scans against the exact one, and of real logs against poses
that others corrected; what reruns after a change; logs that end in the middle."""
import gzip
import json
import os
import pathlib
import re
import unittest

from nightly import nightly
from workspace import BUILD, REPOSITORY, Workspace, said_by
from nightmap_site.pipeline import read_pipeline  # workspace finds the scripts

DEMO = "demo_laser"
DATA = pathlib.Path(os.environ.get("NIGHTMAP_DATA", REPOSITORY / "../shared/data")).resolve()
# Bounds for a real log: largest mean error of the motion over 10 m of path. Its truth is right within 10 to 20 cm.
BOUNDS = {
    "intel": {"translation_mean_m": 0.08, "rotation_mean_deg": 0.7},
    "freiburg_079": {"translation_mean_m": 0.08, "rotation_mean_deg": 0.95},
}
# Bounds for the made-up building, whose truth is exact.
MAX_ATE_M = 0.01
MIN_RIGHT_PERCENT = 97
GOALS = ("map", "evaluate", "report", "plan", "drive")
JOBS = read_pipeline(str(REPOSITORY / "configs"), "laser").jobs
SECTIONS_OF_A_CAMERA = ("Accuracy", "Trajectory", "Cloud, without truth", "Queries", "What moves")


def numbers_named(figures, name):
    """All values of a key, at any depth."""
    if isinstance(figures, dict):
        own = [figures[name]] if name in figures else []
        return own + [value for inner in figures.values() for value in numbers_named(inner, name)]
    return [value for inner in figures for value in numbers_named(inner, name)] if isinstance(figures, list) else []


def with_those_after(name, goals=("map",)):
    """A job of the map, and the jobs of some goals that read what it makes."""
    reached = {name}
    for job in JOBS.values():  # each after those that it reads
        if job.goal in goals and reached & set(job.jobs_before()):
            reached.add(job.name)
    return reached


class LaserSite:
    """demo_laser in a workspace of its own."""

    def __init__(self, work=None):
        self.work = work or Workspace()
        self.maps = self.work.folder / "maps" / DEMO
        self.data = self.work.folder / "data" / DEMO

    def make(self, *arguments, code=0):
        return self.work.output(f"SITE={DEMO}", *arguments, code=code)

    def copy(self):
        """The same with a recording that synthesize does not make."""
        other = LaserSite(self.work.copy())
        config = other.config()
        config.write_text(config.read_text().replace("synthetic = true", "synthetic = false"))
        return other

    def config(self):
        return self.work.folder / f"configs/sites/{DEMO}.toml"

    def metrics(self):
        return json.loads((self.maps / "evaluate/metrics.json").read_text())

    def jobs_that_ran(self):
        journal = (self.maps / "logs/journal.txt").read_text().splitlines()
        return {line.split()[1] for line in journal if line.split()[2] == "begin"} - {"make"}


class DemoTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.site = LaserSite()
        cls.addClassCleanup(cls.site.work.remove)
        cls.site.make(*GOALS, "THREADS=4")

    def copy(self):
        other = self.site.copy()
        self.addCleanup(other.work.remove)
        return other

    def test_the_map_is_that_of_the_building(self):
        figures = self.site.metrics()["sections"]["grid"]
        self.assertEqual(figures["num_scans_without_pose"], 0)
        self.assertEqual(figures["trajectory"]["num_missing"], 0)
        self.assertGreater(figures["trajectory"]["truth_path_length_m"], 50)
        self.assertLessEqual(figures["trajectory"]["se3"]["ate_rmse_m"], MAX_ATE_M)
        shares = numbers_named(figures["map"], "seen_right_percent")
        self.assertTrue(shares)
        for share in shares:
            self.assertGreaterEqual(share, MIN_RIGHT_PERCENT)

    def test_the_page_has_the_sections_of_a_laser_and_none_of_a_camera(self):
        page = (self.site.maps / "report/index.html").read_text()
        titles = re.findall(r"<summary><h2>([^<]*)</h2>", page)
        for title in ("The map in space", "Path", "Accuracy of the laser map", "Position error", "Time and memory", "Loops", "Files"):
            self.assertIn(title, titles)
        self.assertEqual([title for title in titles if title in SECTIONS_OF_A_CAMERA], [])
        self.assertNotIn("did not run", page)

    def test_the_path_leads_over_free_floor(self):
        path = json.loads((self.site.maps / "plan/path.json").read_text())
        self.assertGreater(len((self.site.maps / "plan/path.csv").read_text().splitlines()), 2)
        self.assertGreater(min(numbers_named(path, "length_m")), 0.5)
        drive = json.loads((self.site.maps / "drive/drive.json").read_text())
        self.assertGreater(min(numbers_named(drive, "length_m")), 0.5)

    def test_nothing_is_left_to_do_and_all_is_as_written(self):
        self.assertEqual(self.site.make("-q", *GOALS), "")
        self.assertIn("all as written", self.site.make("verify"))

    def test_why_names_the_jobs_after_a_changed_option(self):
        def woken(option):
            return {line.partition(":")[0] for line in self.site.make("why", f"SET={option}").splitlines() if ": " in line}

        scripts = {job.name for job in JOBS.values() if job.script and job.goal not in ("check", "export")}  # these are made by other commands
        for name, option in (("odometry", "min_score=0.4"), ("loops", "min_score=0.6"), ("pose_graph", "max_drift=9"),
                             ("grid", "hit_probability=0.8")):  # fmt: skip
            program = JOBS[name].program  # the grid of the map and that of the test have one
            after = [with_those_after(job.name, ("map", "report", "evaluate")) for job in JOBS.values() if job.program == program]
            self.assertEqual(woken(f"{program}.{option}"), set().union(*after) | scripts)
        self.assertLess(with_those_after("grid"), with_those_after("loops"))
        self.assertNotIn("odometry", with_those_after("loops"))

    def test_a_changed_option_runs_the_jobs_that_why_names(self):
        other = self.copy()
        other.make("map")
        other.make("map", "SET=scan_loops.min_score=0.99")
        self.assertEqual(other.jobs_that_ran(), with_those_after("loops") | {"verdict"})
        self.assertEqual(json.loads((other.maps / "pose_graph/report.json").read_text())["sensors"][0]["num_edges"], 0)

    def test_another_scanner_is_mapped_anew_whatever_goal_comes_first(self):
        other = self.copy()
        other.make("check", "map")
        config = other.config()
        config.write_text(config.read_text().replace('kind = "scan"', 'kind = "scan"\nmin_range_m = 1.5'))
        other.make("check", "map")
        self.assertLess({"frames", "check", "odometry", "grid", "test_localize", "verdict"}, other.jobs_that_ran())
        other.make("-q", "check", "map")

    def test_the_same_bytes_at_any_number_of_threads(self):
        other = LaserSite()
        self.addCleanup(other.work.remove)
        other.make(*GOALS, "THREADS=1")
        first, second = (site.work.hashes(DEMO) for site in (self.site, other))
        self.assertLess({"grid/map.pgm", "map_frame/trajectory.tum", "loops/edges.h5", "objects/objects.yaml", "plan/path.csv"}, set(first))
        self.assertEqual(first, second)
        logs = [(site.data / "robot.log").read_bytes() for site in (self.site, other)]
        self.assertEqual(*logs)

    def test_poses_of_another_system_make_the_grid_alone(self):
        other = self.copy()
        config = other.config()
        config.write_text(config.read_text() + '\n[import]\ntrajectory = "demo_laser/robot_groundtruth.txt"\n')
        other.make("map", "evaluate", "report")
        left_out = JOBS.keys() - read_pipeline(str(REPOSITORY / "configs"), "laser", ("trajectory",)).jobs.keys()
        self.assertEqual(len(left_out), 4)
        self.assertEqual(other.jobs_that_ran() & left_out, set())
        figures = other.metrics()["sections"]["grid"]
        self.assertLess(figures["trajectory"]["se3"]["ate_max_m"], 1e-6)
        self.assertGreaterEqual(min(numbers_named(figures["map"], "seen_right_percent")), MIN_RIGHT_PERCENT)
        for name in left_out:  # results of jobs that the site no longer has are removed
            self.assertFalse(list((other.maps / JOBS[name].folder).glob("*.*")), name)
        given = other.data / "robot_groundtruth.txt"
        given.write_text(given.read_text()[:-20])
        self.assertIn("demo_laser/robot_groundtruth.txt:", other.make("map", code=2))

    def test_a_packed_log_that_ends_in_the_middle_is_refused(self):
        other = self.copy()
        packed = gzip.compress((other.data / "robot.log").read_bytes(), 1)
        config = other.config()
        config.write_text(config.read_text().replace('"robot.log"', '"robot.log.gz"'))
        (other.data / "robot.log.gz").write_bytes(packed[:len(packed) // 2])
        self.assertIn("demo_laser/robot.log.gz", other.make("map", code=2))
        self.assertEqual(self.site.work.hashes(DEMO), other.work.hashes(DEMO))  # the last good map stays
        (other.data / "robot.log.gz").write_bytes(packed)
        other.make("map")
        self.assertEqual((self.site.maps / "grid/map.pgm").read_bytes(), (other.maps / "grid/map.pgm").read_bytes())

    def test_a_text_log_that_ends_in_the_middle_of_a_scan_loses_that_scan(self):
        other = self.copy()
        log = other.data / "robot.log"
        whole = log.read_bytes()
        log.write_bytes(whole[:whole.index(b"FLASER", len(whole) // 2) + 300])
        line = log.read_bytes().count(b"\n") + 1
        self.assertIn(f"demo_laser/robot.log:{line}: ", other.make("map"))
        log.write_bytes(whole[:whole.index(b"FLASER") + 300])  # no scan is left
        self.assertIn("demo_laser/robot.log", other.make("map", code=2))


class RealLogsTest(unittest.TestCase):
    """Maps are kept in <build>/laser, so that a second run costs only what changed."""

    def check(self, name, log):
        if not (DATA / "laser" / log).is_file():
            message = f"{DATA / 'laser' / log} is missing: set NIGHTMAP_DATA"
            if os.environ.get("CI") == "true":
                raise AssertionError(message)
            raise unittest.SkipTest(message)
        command = ["make", "--no-print-directory", f"SITE={name}", f"DATA={DATA}", f"MAPS={BUILD}/laser/maps", f"BUILD={BUILD}"]
        said_by([*command, "map", "evaluate", "report"])
        metrics = json.loads((BUILD / f"laser/maps/{name}/evaluate/metrics.json").read_text())
        loops, trajectory = (metrics["sections"]["grid"][name] for name in ("loops", "trajectory"))
        self.assertGreater(loops["num_accepted"], 100)
        self.assertEqual(loops["num_false_accepted"], 0)
        self.assertEqual(trajectory["num_missing"], 0)
        self.assertGreater(trajectory["truth_path_length_m"], 300)
        for key, bound in BOUNDS[name].items():
            with self.subTest(key):
                self.assertLess(trajectory["relative_10m"][key], bound)

    def test_intel(self):
        self.check("intel", "intel-corrected.log.gz")

    @nightly
    def test_freiburg_079(self):
        self.check("freiburg_079", "freiburg-079-corrected.log.gz")
