# SPDX-License-Identifier: Apache-2.0
"""Logs of laser scanners as drivers write them: angles that the format fixes, scans of different numbers of beams, what stands for no
hit, units and tables. A robot drives once through two rooms; each case writes the drive as another log, with a site config of few
lines. Its map is right, or reading it ends with the reason and what to write."""
import json
import math
import re

import h5py
import numpy as np

from workspace import SiteTest, Workspace

# Walls and furniture: rectangles x0 y0 x1 y1 (m). A wall between the rooms has a door.
RECTANGLES = ((0, 0, 9, 6), (4.4, 0, 4.5, 2.4), (4.4, 3.5, 4.5, 6), (0.4, 0.5, 1.3, 1.0), (2.6, 4.9, 3.9, 5.5), (6.2, 0.4, 7.4, 1.1),
              (7.9, 4.4, 8.5, 5.6), (1.0, 3.9, 1.3, 4.2))  # fmt: skip
ROUTE = ((1.8, 2.2), (2.6, 3.0), (6.4, 3.0), (7.0, 2.2), (6.0, 4.4), (6.4, 3.0), (2.6, 3.0), (1.8, 2.2))
STEP_M, STEP_RAD, RATE_HZ, REACH_M, NOISE_M = 0.1, 0.12, 5, 5.0, 0.01
MAX_ATE_M = 0.03
ODOMETRY = '[[sensor]]\nid = "wheels"\nkind = "odometry"\n[[signal]]\nsensor = "wheels"\nformat = "csv"\nfile = "odometry.csv"\n'


def drive():
    """Poses x y heading (n, 3)."""
    poses = [(*ROUTE[0], 0.0)]
    for x, y in ROUTE[1:]:
        x0, y0, heading = poses[-1]
        turn = math.remainder(math.atan2(y - y0, x - x0) - heading, 2 * math.pi)
        num_turns, num_moves = math.ceil(abs(turn) / STEP_RAD), math.ceil(math.hypot(x - x0, y - y0) / STEP_M)
        poses += [(x0, y0, heading + turn * (i + 1) / num_turns) for i in range(num_turns)]
        shares = [(i + 1) / num_moves for i in range(num_moves)]
        poses += [(x0 + (x - x0) * share, y0 + (y - y0) * share, heading + turn) for share in shares]
    return np.array(poses)


def exact_ranges_m(pose, angles_rad):
    """To the nearest wall; infinite beyond the scanner's reach."""
    corners = [np.array([(x0, y0), (x1, y0), (x1, y1), (x0, y1)]) for x0, y0, x1, y1 in RECTANGLES]
    starts = np.concatenate(corners)
    sides = np.concatenate([np.roll(four, -1, axis=0) - four for four in corners])
    beams = np.stack([np.cos(angles_rad + pose[2]), np.sin(angles_rad + pose[2])], axis=1)
    to_start = starts - pose[:2]
    with np.errstate(divide="ignore", invalid="ignore"):
        across = beams[:, None, 0] * sides[:, 1] - beams[:, None, 1] * sides[:, 0]
        along = (to_start[:, 0] * sides[:, 1] - to_start[:, 1] * sides[:, 0]) / across
        share = (to_start[:, 0] * beams[:, None, 1] - to_start[:, 1] * beams[:, None, 0]) / across
    ranges_m = np.where((along > 0) & (share >= 0) & (share <= 1), along, np.inf).min(axis=1)
    return np.where(ranges_m < REACH_M, ranges_m, np.inf)


class Recording:
    """The drive, and the scans of a scanner with these angles (rad): of all scans, or a function of the scan's index."""

    def __init__(self, angles_rad):
        self.poses, rng = drive(), np.random.default_rng(3)
        self.times_s = 100 + np.arange(len(self.poses)) / RATE_HZ
        self.scans_m = []
        for i, pose in enumerate(self.poses):
            exact_m = exact_ranges_m(pose, angles_rad(i) if callable(angles_rad) else angles_rad)
            self.scans_m.append(exact_m + NOISE_M * rng.normal(size=len(exact_m)))

    def text(self, none="inf", scale=1.0, form="{:.3f}", after=lambda i: ""):
        """Lines `time ranges`."""
        lines = [f"{time:.6f} " + " ".join(none if np.isinf(range_m) else form.format(scale * range_m) for range_m in ranges) + after(i)
                 for i, (time, ranges) in enumerate(zip(self.times_s, self.scans_m))]
        return "\n".join(lines) + "\n"

    def robot_laser(self, start_rad, step_rad):
        """Lines ROBOTLASER1, whose angles each line states."""
        lines = [f"ROBOTLASER1 0 {start_rad:.6f} {step_rad * len(ranges):.6f} {step_rad:.6f} {REACH_M} 0.01 0 {len(ranges)} "
                 + " ".join(f"{min(range_m, REACH_M):.3f}" for range_m in ranges) + f" 0 0 0 0 0 0 0 0 0 0.2 0.2 0 {time:.6f} h {time:.6f}"
                 for time, ranges in zip(self.times_s, self.scans_m)]
        return "\n".join(lines) + "\n"

    def table(self):
        head = "time_s, " + ", ".join(f"r{i}" for i in range(len(self.scans_m[0]))) + "\n"
        return head + self.text(none="-1").replace(" ", ", ")

    def odometry(self, separator=",", scales=(1, 1, 1), later_s=0, reset=False):
        """`reset`: its driver starts again in the middle of the drive."""
        lines, poses = [separator.join(("time_s", "x_m", "y_m", "heading_rad"))], self.poses
        if reset:
            start = poses[len(poses) // 2]
            poses = np.concatenate([poses[: len(poses) // 2], [seen_from(start, pose) for pose in poses[len(poses) // 2 :]]])
        lines += [separator.join(f"{value:.6f}" for value in (time + later_s, *pose * scales)) for time, pose in zip(self.times_s, poses)]
        return "\n".join(lines) + "\n"

    def odometry_of_quaternions(self):
        lines = [f"{time:.6f},{x:.6f},{y:.6f},0,0,{math.sin(heading / 2):.9f},{math.cos(heading / 2):.9f}"
                 for time, (x, y, heading) in zip(self.times_s, self.poses)]
        return "\n".join(["time_s,x_m,y_m,qx,qy,qz,qw", *lines]) + "\n"

    def truth(self):
        return "".join(f"{time:.6f} {x:.6f} {y:.6f} 0 0 0 {math.sin(heading / 2):.9f} {math.cos(heading / 2):.9f}\n"
                       for time, (x, y, heading) in zip(self.times_s, self.poses))


def seen_from(start, pose):
    x, y = pose[:2] - start[:2]
    cos, sin = math.cos(start[2]), math.sin(start[2])
    return np.array([cos * x + sin * y, cos * y - sin * x, pose[2] - start[2]])


def full_circle(count):
    return -np.pi + 2 * np.pi * np.arange(count) / count


def half_circle(count, step_deg):
    return np.radians(-90 + step_deg * np.arange(count))


def circle_of_another_count(index):
    return full_circle(170 + (index * 7) % 21)


FULL = "start_angle_deg = -180\nangle_step_deg = 2\n"


class LaserLogsTest(SiteTest):
    given = ("SITE=lab",)

    @classmethod
    def setUpClass(cls):
        cls.work = Workspace().removed_after(cls)

    def write(self, recording, log, sensor, signal='format = "text"', odometry=None, columns="time_s,x_m,y_m,heading_rad", more=""):
        site = "lab"
        folder = self.work.folder / "data" / site
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "scan.txt").write_text(log)
        (folder / "odometry.csv").write_text(odometry or recording.odometry())
        (folder / "truth.tum").write_text(recording.truth())
        text = f'profile = "laser"\nroot = "{site}"\n[[sensor]]\nid = "laser"\nkind = "scan"\n{sensor}'
        text += f'[[signal]]\nsensor = "laser"\nfile = "scan.txt"\n{signal}\n{ODOMETRY}columns = "{columns}"\n'
        (self.work.folder / f"configs/sites/{site}.toml").write_text(f'{text}[robot_truth]\ntrajectory = "truth.tum"\n{more}')

    def artifact(self, name):
        return self.work.folder / "maps/lab" / name

    def scans(self):
        """value (n, 3) of frames/scans.h5."""
        self.make("maps/lab/frames/shards.txt")
        with h5py.File(self.artifact("frames/scans.h5")) as file:
            return file["value"][:]

    def assert_right(self):
        self.make("map", "evaluate")
        metrics = json.loads(self.artifact("evaluate/metrics.json").read_text())
        figures = metrics["sections"]["grid"]["trajectory"]
        self.assertLessEqual(figures["se3"]["ate_rmse_m"], MAX_ATE_M)
        self.assertEqual(json.loads(self.artifact("verdict/verdict.json").read_text())["verdict"], "good")

    def test_the_map_is_right(self):
        full = Recording(full_circle(180))
        cases = {
            "beams that share the circle, whatever their number": (
                Recording(circle_of_another_count), {}, "start_angle_deg = -180\nmax_range_m = 5\n", {}),
            "a stated step that only the mean scan has": (Recording(circle_of_another_count), {}, FULL + "max_range_m = 5\n", {}),
            "a range that stands for no hit and is not stated": (full, {"none": "5.000"}, FULL, {}),
            "quaternions, and -1 for no hit": (full, {"none": "-1"}, FULL, {
                "odometry": full.odometry_of_quaternions(), "columns": "time_s,x_m,y_m,qx,qy,qz,qw"}),
            "millimetres that are stated": (full, {"scale": 1000, "form": "{:.0f}", "none": "0"}, FULL + 'range_unit = "mm"\n', {}),
        }  # fmt: skip
        for name, (recording, text, sensor, more) in cases.items():
            with self.subTest(name):
                self.write(recording, recording.text(**text), sensor, **more)
                self.assert_right()

    def test_the_angles_are_those_of_the_format(self):
        half = {count: Recording(half_circle(count, step_deg)) for count, step_deg in ((180, 1), (181, 1), (361, 0.5))}
        for count, recording in half.items():
            with self.subTest(count):
                self.write(recording, recording.text(), "max_range_m = 5\n")
                np.testing.assert_allclose(self.scans()[:, :2], np.radians([[-90, 1 if count < 200 else 0.5]] * len(recording.poses)))
        stated = half[181].robot_laser(math.radians(-45), math.radians(0.5))
        carmen = 'format = "carmen"\nmessage = "ROBOTLASER1"'
        self.write(half[181], stated, "", carmen)
        np.testing.assert_allclose(self.scans()[0], [*np.radians([-45, 0.5]), REACH_M], atol=1e-5)
        self.write(half[181], stated, "start_angle_deg = -90\nangle_step_deg = 1\nmax_range_m = 7\n", carmen)
        np.testing.assert_allclose(self.scans()[0], [*np.radians([-90, 1]), 7])

    def test_a_scan_that_lacks_a_beam_keeps_the_stated_step(self):
        recording = Recording(lambda i: full_circle(180)[: 179 if i % 10 == 3 else 180])
        self.write(recording, recording.text(), FULL)
        np.testing.assert_allclose(self.scans()[:, 1], math.radians(2))

    def test_tables_with_blanks(self):
        recording = Recording(full_circle(90))
        self.write(recording, recording.table(), FULL.replace("2", "4"), 'format = "csv"\ncolumns = "time_s"', recording.odometry(", "))
        self.assertEqual(len(self.scans()), len(recording.poses))
        with h5py.File(self.artifact("frames/odometry.h5")) as file:
            np.testing.assert_allclose(file["value"][:], recording.poses, atol=1e-5)
        with h5py.File(self.artifact("frames/scans.h5")) as file:
            exact = np.concatenate(recording.scans_m)
            np.testing.assert_allclose(np.ravel(file["range_m"]), np.where(np.isinf(exact), 0, exact), atol=1e-3)

    def test_what_cannot_be_is_refused_with_the_remedy(self):
        recording = Recording(full_circle(180))
        intensities = recording.text(after=lambda i: " 17" * 180)
        cases = {
            "intensities": (intensities, FULL, r"360 beams 2 deg apart span 718 deg, more than a circle: .* intensities"),
            "millimetres": (recording.text(scale=1000), FULL + "max_range_m = 5\n", r'scan\.txt: half of the ranges .* range_unit = "mm"'),
            "no view": (recording.text(), "start_angle_deg = 0\n", r"lab\.toml:3: start_angle_deg = 0 .*add angle_step_deg"),
            "columns": (recording.table(), FULL, r"lab\.toml:\d+: columns = .* must name the time alone",
                        'format = "csv"\ncolumns = "time_s,r0"'),
        }  # fmt: skip
        for name, (log, sensor, reason, *signal) in cases.items():
            with self.subTest(name):
                self.write(recording, log, sensor, *signal)
                output = self.make("map", code=2)
                self.assertRegex(output, reason)
                self.assertNotIn("delete it", output)

    def test_odometry_of_other_units_and_clocks_is_refused_with_the_remedy_that_helps(self):
        recording = Recording(full_circle(180))
        odometry = '[[sensor]]\nid = "wheels"\nkind = "odometry"\n'
        signal = '[[signal]]\nsensor = "wheels"\n'
        degrees = math.degrees(1)
        cases = {
            "millimetres": ({"scales": (1000, 1000, 1)}, r'odometry\.csv: .* (position_unit = "mm") in its \[\[sensor\]\], where that is 0\.\d+ m/s',
                            odometry),
            "degrees": ({"scales": (1, 1, degrees)}, r'odometry\.csv: .* look like degrees: write (heading_unit = "deg")', odometry),
            "clock": ({"later_s": -90}, r'lab\.toml:\d+: odometry and scans have no moment in common: .* write (time_offset_s = 90\.0+) ', signal),
        }  # fmt: skip
        site = self.work.folder / "configs/sites/lab.toml"
        for name, (changes, reason, table) in cases.items():
            with self.subTest(name):
                self.write(recording, recording.text(), FULL + "max_range_m = 5\n", odometry=recording.odometry(**changes))
                output = self.make("map", code=2)
                self.assertRegex(output, reason)
                self.assertNotIn("delete it", output)
                site.write_text(site.read_text().replace(table, f"{table}{re.search(reason, output).group(1)}\n"))
                self.make("maps/lab/frames/shards.txt")
                with h5py.File(self.artifact("frames/odometry.h5")) as file:
                    np.testing.assert_allclose(file["value"][:], recording.poses, atol=1e-5)
                    np.testing.assert_allclose(np.ravel(file["time_ns"]) * 1e-9, recording.times_s, atol=1e-5)

    def test_odometry_that_hardly_covers_the_scans_is_said(self):
        recording = Recording(full_circle(180))
        later_s = 0.7 * len(recording.poses) / RATE_HZ
        self.write(recording, recording.text(), FULL, odometry=recording.odometry(later_s=later_s))
        self.make("maps/lab/frames/shards.txt")
        self.assertRegex(self.artifact("logs/frames.log").read_text(), r"odometry covers only (29|30|31) % of the scans: .* time_offset_s")

    def test_a_driver_that_starts_again_and_stamps_that_go_back_do_no_harm(self):
        recording = Recording(full_circle(180))
        late = recording.times_s.copy()
        late[9::20] -= 0.25
        stamps = dict(zip([f"{time:.6f}" for time in recording.times_s], [f"{time:.6f}" for time in late]))
        log = "".join(stamps[line.split()[0]] + line[len(line.split()[0]):] + "\n" for line in recording.text().splitlines())
        self.write(recording, log, FULL + "max_range_m = 5\n", odometry=recording.odometry(reset=True))
        self.assert_right()
        with h5py.File(self.artifact("frames/scans.h5")) as file:
            np.testing.assert_allclose(np.ravel(file["time_ns"]) * 1e-9, recording.times_s, atol=0.051)

    def test_a_range_of_no_hit_that_is_not_stated_is_said(self):
        recording = Recording(full_circle(180))
        self.write(recording, recording.text(none="5.000"), FULL)
        self.assertTrue((self.scans()[:, 2] == 5).all())
        self.assertEqual(json.loads(self.artifact("frames/report.json").read_text())["range_of_no_hit_m"], {"laser": 5})
        self.assertIn("write max_range_m = 5", self.artifact("logs/frames.log").read_text())

    def test_the_robot_in_its_scans_is_left_out(self):
        recording, rng = Recording(full_circle(180)), np.random.default_rng(5)
        for ranges_m in recording.scans_m:
            ranges_m[:22] = 0.25 + 0.005 * rng.normal(size=22)
            ranges_m[-22:] = 0.25 + 0.005 * rng.normal(size=22)
        sensor = FULL + "max_range_m = 5\n"
        self.write(recording, recording.text(), sensor)
        output = self.make("check")
        self.assertRegex(output, "verdict: good\n.*not known: the robot in its scans")
        self.assert_right()
        body = json.loads(self.artifact("frames/report.json").read_text())["robot_body"]["laser"]
        self.assertEqual((body["sectors_deg"], body["is_left_out"]), ([135, 223], True))
        proposed = re.search(r"Write (min_range_m = [0-9.]+) in the \[\[sensor\]\]", output)[1]
        self.assertIn("the robot itself, which is left out; write " + proposed, self.artifact("logs/frames.log").read_text())
        for lines in (proposed, "blind_deg = [135, -135]"):
            self.write(recording, recording.text(), sensor + lines + "\n")
            output = self.make("check")
            self.assertIn("verdict: good", output)
            self.assertNotIn("the robot in its scans", output)
            self.assert_right()
        self.write(recording, recording.text(), sensor + "min_range_m = 0.1\n")
        self.assertIn("look at this: the robot in its scans", self.make("check"))

    def test_keys_of_import_that_nothing_reads_are_refused(self):
        recording = Recording(full_circle(90))
        for key, remedy in (("trajectry", "no such key: write trajectory"), ("shape", "the keys are map, objects, trajectory")):
            with self.subTest(key):
                self.write(recording, recording.text(), FULL, more=f'[import]\n{key} = "lab/truth.tum"\n')
                self.assertRegex(self.make("map", code=2), rf"lab\.toml: \[import\] {key}: .*{remedy}")
