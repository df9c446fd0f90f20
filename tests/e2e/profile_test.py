# SPDX-License-Identifier: Apache-2.0
"""A profile adds a job upstream of the pairs, units and a goal of its own, by its folder alone: everything that goes through the
jobs knows them. The programs are stubs."""
import os
import shutil
import subprocess

from stub_site import SITE, StubTest
from workspace import BUILD, PIPELINE

PROFILE = """
[goals]
rooms = { purpose = "a drawing of each room of SITE", made = "rooms of {site}: {folder}/draw" }

[labels]
purpose = "what is where in each frame"
when = "import.model"
unit = "shard"
in.frames = "frames.shard"
in.model = "import.model"
out.labels = "shard_{unit}.h5"

[matches]
in.labels = "labels.labels of previous and this if made"

[wheels]
purpose = "edges between frames, from the wheels"
in.odometry = "frames.odometry"
out.edges = "edges.h5"

[pose_graph]
in.edges = "wheels.edges"

[rooms]
purpose = "lists the rooms"
goal = "rooms"
lists = "room"
in.floors = "grid.floors"
out.rooms = "rooms.txt"

[draw]
purpose = "draws a room"
goal = "rooms"
unit = "room"
in.rooms = "rooms.rooms"
in.features = "features.features of all"
out.png = "room_{unit}.png"
"""
LISTS_ROOMS = """#!/bin/sh
case " $* " in *" --check-config "*) exit 0 ;; esac
"$(dirname "$0")/stub" "$@"
for word; do case "$word" in rooms=*) printf 'nightmap rooms, version 1, 2 names\\n%s\\nkitchen\\n' "${STUB_ROOM:-hall}" >"${word#*=}" ;; esac; done
for word; do case "$word" in receipt=*) touch "${word#*=}" ;; esac; done
"""


class ProfileTest(StubTest):
    def setUp(self):
        super().setUp()
        configs = self.site.folder / "configs"
        (configs / "rooms/default").mkdir(parents=True)
        (configs / "rooms/pipeline.toml").write_text(PROFILE)
        for program in ("labels", "wheels", "draw", "stub"):
            self.site.add_program(program)
        (self.site.folder / "build/run/rooms").write_text(LISTS_ROOMS)
        (self.site.folder / "build/run/rooms").chmod(0o755)
        for program in ("labels", "wheels", "rooms", "draw"):
            (configs / f"rooms/default/{program}.toml").write_text("size = 1\n")
        site = configs / f"sites/{SITE}.toml"
        self.text = f'profile = "rooms"\n{site.read_text()}\n'
        site.write_text(self.text + '[import]\nmodel = "net.onnx"\n')
        (self.site.folder / "data/net.onnx").write_text("weights")

    def test_an_inserted_job_and_a_goal_of_its_own(self):
        output = self.make("map", "rooms")
        ran = self.site.ran()
        self.assertLess(ran.index("labels_0001"), ran.index("matches_0001"))
        self.assertLess(ran.index("labels_0000"), ran.index("matches_0001"))
        self.assertEqual([name for name in ran if name.startswith("draw_")], ["draw_hall", "draw_kitchen"])
        self.assertIn("rooms of demo: maps/demo/draw", output)  # its own last word
        self.assertRegex(output, r"(?m)^labels +3 of 3 .*(.|\n)*^draw +2 of 2 ")  # the table of the run
        rules = self.site.path("graph.mk").read_text()
        matches = rules.split("# matches_0001:")[1].split("# ")[0]
        self.assertEqual(matches.count("--in labels="), 2)
        self.assertIn("--in-list features=", rules.split("# draw_hall:")[1].split("# ")[0])
        self.make("-q", "map", "rooms")
        self.assertEqual(self.make("map", "rooms").count("== "), 0)

    def test_another_sensor_gives_edges_to_the_pose_graph(self):
        self.make("map")
        rule = self.site.path("graph.mk").read_text().split("# pose_graph:")[1].split("# ")[0]
        self.assertIn("--in edges=maps/demo/wheels/edges.h5", rule)
        self.assertIn("--in-list odometry=", rule)  # what the default pipeline gives stays
        page = subprocess.run([BUILD / "run/pose_graph", "--help"], capture_output=True, text=True, check=True).stdout
        self.assertRegex(page, r"(?m)^  edges ")  # the real program has this port

    def test_the_front_page_names_its_goal(self):
        self.assertRegex(self.make("help"), r"(?m)^  make rooms +a drawing of each room of SITE$")

    def test_why_names_its_jobs(self):
        self.make("map", "rooms")
        self.assertIn("labels_0000: options of labels changed: size 1 -> 2", self.make("why", "SET=labels.size=2"))
        self.assertIn("draw_hall: ", self.make("why", "SET=rooms.size=2"))
        self.make("rooms", "SET=draw.size=3")
        self.assertEqual({name.partition("_")[0] for name in self.site.ran()}, {"draw"})

    def test_page_status_and_verify_show_its_jobs(self):
        self.make("map", "rooms")
        for job in PIPELINE.jobs.values():  # whose stubs write no real files
            if job.folder != "RECORDING":
                shutil.rmtree(self.site.path(job.folder), ignore_errors=True)
        self.make("status")
        page = self.site.path("report/index.html").read_text()
        for job in ("labels", "rooms", "draw"):
            self.assertIn(f"<td>{job}</td>", page)
        (self.site.path("labels") / "receipt_0000.json").write_text("{")
        self.assertIn("labels/receipt_0000.json", self.make("verify", code=2))

    def test_a_site_without_the_key_has_no_such_job(self):
        (self.site.folder / f"configs/sites/{SITE}.toml").write_text(self.text)
        self.make("map")
        self.assertFalse([name for name in self.site.ran() if name.startswith("labels")])
        self.assertFalse(self.site.path("labels").exists())

    def test_a_goal_whose_job_the_site_has_not_says_why(self):
        path = self.site.folder / "configs/rooms/pipeline.toml"
        path.write_text(PROFILE.replace('goal = "rooms"\n', 'goal = "rooms"\nwhen = "import.plan"\n'))
        self.assertIn("make rooms: rooms is for sites with import.plan, which configs/sites/demo.toml has not", self.make("rooms", code=2))

    def test_rooms_that_are_no_more_leave_nothing(self):
        self.make("rooms")
        self.addCleanup(self.site.make, "clean")
        self.site.output("rooms", "SET=rooms.size=2")
        os.environ["STUB_ROOM"] = "cellar"
        self.addCleanup(os.environ.pop, "STUB_ROOM")
        self.make("rooms", "SET=rooms.size=3")
        self.assertEqual(sorted(path.name for path in self.site.path("draw").glob("*.png")), ["room_cellar.png", "room_kitchen.png"])
