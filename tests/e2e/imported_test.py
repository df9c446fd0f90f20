# SPDX-License-Identifier: Apache-2.0
"""The profile `imported`: a trajectory of another system fills the slot of the pose graph, a ROS map that of the grid.
Results of the default profile stand for the other system."""
import json
import os
import re
import shutil
import unittest

from workspace import GOALS, PIPELINE, SITE, Workspace, told_by_why

IMPORT = '\nprofile = "imported"\n\n[import]\n{}\n\n'
OLD_S = 1_000_000_000  # 2001
AFTER_MAP = {job.name for job in PIPELINE.jobs.values() if job.goal != "map" or job.script}
LEFT_OUT = ("matches", "loops", "odometry")


def shifted(poses):
    """The same trajectory half a metre away."""
    rows = [line.split() for line in poses.decode().splitlines() if not line.startswith("#")]
    return "".join(f"{row[0]} {float(row[1]) + 0.5:.9f} {' '.join(row[2:])}\n" for row in rows).encode()


class ImportedTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.work = Workspace.made(*GOALS).removed_after(cls)
        given = cls.work.data() / "other"
        given.mkdir()
        shutil.copy(cls.work.path("map_frame/trajectory.tum"), given / "poses.tum")
        for name in ("map.yaml", "map.pgm"):
            shutil.copy(cls.work.path(f"grid/{name}"), given / name)

    def site(self, name, imports):
        """Config of a site of the same recording."""
        sites = self.work.folder / "configs/sites"
        text = (sites / f"{SITE}.toml").read_text().replace("synthetic = true", "synthetic = false")
        head, table = text.split("[[camera]]", 1)
        (sites / f"{name}.toml").write_text(head + IMPORT.format(imports) + "[[camera]]" + table)
        shutil.copytree(sites / SITE, sites / name, dirs_exist_ok=True)
        return self.work.folder / "maps" / name

    def make(self, name, *goals, code=0):
        return self.work.output(*goals, f"SITE={name}", code=code)

    def test_a_given_trajectory_carries_the_whole_map(self):
        maps = self.site("posed", f'trajectory = "{SITE}/other/poses.tum"')
        self.make("posed", *GOALS)
        for job in LEFT_OUT:
            self.assertFalse((maps / job).exists(), job)
        self.make("posed", "-q", *GOALS)
        self.assertIn("all as written", self.make("posed", "verify"))
        self.assertIn(",located,", (maps / "localize/queries.csv").read_text())
        self.make("posed", "report")
        default = json.loads(self.work.path("point_cloud/report.json").read_text())
        metrics = json.loads((maps / "evaluate/metrics.json").read_text())
        self.assertLess(metrics["trajectory"]["se3"]["ate_rmse_m"], 0.05)
        cloud = json.loads((maps / "point_cloud/report.json").read_text())
        self.assertGreater(cloud["num_points"], 0.5 * default["num_points"])

    def test_another_trajectory_reruns_what_it_reaches(self):
        self.site("posed", f'trajectory = "{SITE}/other/poses.tum"')  # that of the test before, so that it is mapped
        self.make("posed", "map")
        given = self.work.data() / "other/poses.tum"
        given.write_text(given.read_text() + "# another\n")
        will, may = told_by_why(self.make("posed", "why"))
        self.assertIn("pose_graph", will)
        self.assertIn("features_0000", may)  # the recordings changed, in which the trajectory lies

    def refused(self, name, change):
        """Answer of `map` to the trajectory with each line's columns changed."""
        lines = (self.work.data() / "other/poses.tum").read_text().splitlines()
        rows = [line.split() for line in lines if not line.startswith("#")]
        given = self.work.data() / f"other/{name}.tum"
        given.write_text("".join(" ".join(row) + "\n" for row in change(rows)))
        site = "third" if name == "third" else "refused"  # which is mapped in the end
        maps = self.site(site, f'trajectory = "{SITE}/other/{name}.tum"')
        said = self.make(site, "map", code=2)
        self.assertIn(f"data/{SITE}/other/{name}.tum: ", said)
        self.assertFalse((maps / "pose_graph/trajectory.tum").exists())
        return said

    def test_millimetres_are_refused(self):
        said = self.refused("mm", lambda rows: [[r[0], *(str(1000 * float(x)) for x in r[1:4]), *r[4:]] for r in rows])
        self.assertRegex(said, r"its lengths are (99\d|100\d)[.\d]* times those that depth shows")

    def test_another_order_of_the_quaternion_is_refused(self):
        said = self.refused("wxyz", lambda rows: [[*r[:4], r[7], *r[4:7]] for r in rows])
        self.assertIn("write them as qx qy qz qw", said)

    def test_a_pose_out_of_reach_is_refused(self):
        def throw(rows):
            rows[50][1] = "1000"
            return rows

        said = self.refused("thrown", throw)
        self.assertIn("1 poses are out of the camera's reach", said)

    def test_every_third_pose_is_refused_and_the_remedy_works(self):
        said = self.refused("third", lambda rows: rows[::3])
        self.assertIn("more are between poses over 0.1 s apart", said)
        remedy = said.split('SET="')[1].split('"')[0]
        self.work.output("map", "SITE=third", f"SET={remedy}")

    def imports(self, name, imports):
        """Changes [import] of a site."""
        path = self.work.folder / f"configs/sites/{name}.toml"
        head, rest = path.read_text().split("[import]\n")
        path.write_text(f"{head}[import]\n{imports}\n\n{rest.split(chr(10), 2)[2]}")

    def given(self, name, change, source="poses.tum"):
        """A file outside of the recording, like a given one, that is older than all results."""
        path = self.work.folder / "data/older" / name
        path.parent.mkdir(exist_ok=True)
        path.write_bytes(change((self.work.data() / "other" / source).read_bytes()))
        os.utime(path, (OLD_S, OLD_S))
        return path

    def woken(self, name, change, *goals):
        """The jobs that run after a change, which `make why` names."""
        change()
        self.make(name, "-q", *goals, code=1)
        will, may = told_by_why(self.make(name, "why"))
        self.make(name, *goals)
        self.make(name, "-q", *goals)
        journal = (self.work.folder / f"maps/{name}/logs/journal.txt").read_text().splitlines()
        ran = {line.split()[1] for line in journal if line.split()[2] == "begin"} - {"make", *AFTER_MAP}
        self.assertLessEqual(will - AFTER_MAP, ran)
        self.assertLessEqual(ran, will | may)
        return ran

    def test_an_older_trajectory_reruns_what_it_reaches_and_going_back_is_free(self):
        first, other = f'trajectory = "{SITE}/other/poses.tum"', 'trajectory = "older/older.tum"'
        self.given("older.tum", shifted)
        self.given("broken.tum", lambda poses: b"broken\n")
        self.site("older", first)
        self.make("older", "map")
        self.imports("older", other)
        self.assertRegex(self.make("older", "why"), r"pose_graph: \[import\] trajectory: \S+poses.tum -> \S+older.tum")
        self.make("older", "-q", "map", code=1)
        self.imports("older", 'trajectory = "older/broken.tum"')
        self.assertNotEqual(self.work.make("map", "SITE=older").returncode, 0)
        self.imports("older", first)
        self.make("older", "-q", "map")
        ran = self.woken("older", lambda: self.imports("older", other), "map")
        self.assertLessEqual({"pose_graph", "map_frame", "landmarks"}, ran)
        self.assertFalse([job for job in ran if job.startswith("features")])
        self.site("clean", other)
        for name in ("older", "clean"):
            self.make(name, "map", "localize")
        self.assertEqual(self.work.hashes("older"), self.work.hashes("clean"))
        (self.work.folder / "data/older/older.tum").touch()
        self.make("older", "-q", "map")  # the same bytes
        ran = self.woken("older", lambda: self.given("older.tum", lambda poses: b"# third\n" + poses), "map")
        self.assertIn("pose_graph", ran)

    def test_an_image_replaced_beside_its_yaml_and_another_profile_are_noticed(self):
        for name in ("older.yaml", "older.pgm"):
            self.given(name, lambda content: content.replace(b"map.pgm", b"older.pgm"), name.replace("older", "map"))
        maps = self.site("slots", "")
        self.make("slots", *GOALS)
        self.assertEqual(self.woken("slots", lambda: shutil.rmtree(maps / "config/slots"), *GOALS), set())  # the receipts know
        self.make("slots", "-q", *GOALS)
        ran = self.woken("slots", lambda: self.imports("slots", 'map = "older/older.yaml"'), "map")
        self.assertEqual(ran, {"grid"})
        ran = self.woken("slots", lambda: self.given("older.pgm", lambda image: image[:-1] + bytes([image[-1] ^ 255]), "map.pgm"), "map")
        self.assertEqual(ran, {"grid"})
        self.make("slots", *GOALS)
        self.assertIn("all as written", self.make("slots", "verify"))
        ran = self.woken("slots", lambda: self.imports("slots", ""), "map")
        self.assertEqual(ran, {"grid"})

    def test_a_ros_map_is_planned_on(self):
        maps = self.site("gridded", f'map = "{SITE}/other/map.yaml"')
        self.make("gridded", *GOALS)
        self.assertTrue((maps / "odometry").exists())
        self.assertEqual((maps / "grid/map.pgm").read_bytes(), self.work.path("grid/map.pgm").read_bytes())
        path = json.loads((maps / "plan/path.json").read_text())
        expected = json.loads(self.work.path("plan/path.json").read_text())
        self.assertEqual(path["length_m"], expected["length_m"])
        shutil.copy(self.work.path("grid/map.pgm"), self.work.data() / "other/map.pgm")

    def test_a_ros_map_of_another_place_is_refused(self):
        other = self.work.data() / "other"
        text = (other / "map.yaml").read_text()
        (other / "turned.yaml").write_text(re.sub(r"origin: .*", "origin: [-30, 40, 1.2]", text))
        maps = self.site("turned", f'map = "{SITE}/other/turned.yaml"')
        said = self.make("turned", "map", code=2)
        self.assertRegex(said, r"other/turned.yaml: none of the \d+ camera poses is in its free or occupied cells")
        self.assertFalse((maps / "grid/map.yaml").exists())

    def test_damaged_files_are_refused_before_anything_runs(self):
        other = self.work.data() / "other"
        (other / "cut.tum").write_text((other / "poses.tum").read_text()[:-30])
        (other / "lost.yaml").write_text((other / "map.yaml").read_text().replace("map.pgm", "lost.pgm"))
        (other / "odd.yaml").write_text((other / "map.yaml").read_text().replace("resolution: ", "resolution: -"))
        for key, name, reason in (("trajectory", "cut.tum", r"cut.tum:\d+: "), ("map", "lost.yaml", "lost.pgm: no such image"),
                                  ("map", "odd.yaml", r"odd.yaml:\d+: resolution")):  # fmt: skip
            with self.subTest(name):
                maps = self.site("damaged", f'{key} = "{SITE}/other/{name}"')
                self.assertRegex(self.make("damaged", "map", code=2), reason)
                self.assertFalse((maps / "frames").exists())

    def test_what_is_not_there_is_asked_for(self):
        self.site("empty", "")
        self.make("empty", "-q", "map", code=1)  # nothing given: the default pipeline
        self.site("lost", 'trajectory = "nowhere.tum"')
        self.assertIn("data/nowhere.tum does not exist", self.make("lost", "map", code=2))
