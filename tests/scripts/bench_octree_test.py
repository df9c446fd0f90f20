# SPDX-License-Identifier: Apache-2.0
"""bench_octree.py: who is compared with whom, and what is told of it."""

import fake_site
from folder_case import FolderTest

# Stands for the program: OctoMap takes 100 ms, 50 discretized, ours 8 or 4 by the threads; the
# first run of each is ten times slower. The reference must have been written.
PROGRAM = """#!/usr/bin/python3
import json, sys
from pathlib import Path
options = dict(zip(sys.argv, sys.argv[1:]))
octomap = options.get("--builder") == "octomap"
ms = (50 if "--discretize" in sys.argv else 100) if octomap else 8 / int(options["--threads"])
seen = Path(__file__).with_name("-".join(a for a in sys.argv[1:] if "/" not in a))
if not seen.exists():
    ms *= 10
    seen.touch()
result = {"wall_ms": ms, "cpu_ms": 2 * ms, "peak_mib": 12.3, "ray_agreement": 0.5, "num_frames": 4,
          "points_per_frame": 1000}
if "--out" in options:
    Path(options["--out"]).touch()
else:
    assert Path(options["--reference"]).exists()
    result |= {"iou_occupied": 0.98, "iou_free": 0.96}
assert options["--stride"] == "10" and options["--poses"] == "trajectory"
print(json.dumps(result))
"""


class BenchOctreeTest(FolderTest):
    def setUp(self):
        self.program(PROGRAM)

    def program(self, text):
        path = self.write("bench_octree", text)
        path.chmod(0o755)

    def run_bench(self, *arguments):
        return fake_site.run(
            "bench_octree.py", "maps/office:trajectory:10", "--data", self.folder, "--build", self.folder, *arguments
        )

    def test_a_row_for_each_builder_of_its_shortest_run(self):
        result = self.run_bench("--voxels_cm", 4, 2.5, "--repeats", 2)
        self.assertEqual(result.returncode, 0, result.stderr)
        rows = [[cell.strip() for cell in line.strip("|\n").split("|")] for line in result.stdout.splitlines()]
        rows = [dict(zip(rows[0], row)) for row in rows[2:]]
        self.assertEqual([row["voxel (cm)"] for row in rows], ["4"] * 4 + ["2.5"] * 4)
        self.assertEqual([row["ms/frame"] for row in rows], ["100.0", "50.0", "8.0", "4.0"] * 2)
        self.assertEqual([row["times OctoMap"] for row in rows], ["1.0", "2.0", "12.5", "25.0"] * 2)
        self.assertEqual([row["times its discretize"] for row in rows[:4]], ["0.5", "1.0", "6.2", "12.5"])
        self.assertEqual([row["IoU free"] for row in rows[:4]], ["1.000", "0.960", "0.960", "0.960"])
        self.assertEqual({row["site"] for row in rows}, {"office (4 x 1,000 points)"})
        self.assertEqual({row["rays (%)"] for row in rows}, {"50.00"})

    def test_the_table_goes_into_the_page(self):
        page = self.write("figures.md", "a\n<!-- bench_octree:begin -->\nold\n<!-- bench_octree:end -->\nb\n")
        self.assertEqual(self.run_bench("--repeats", 1, "--page", page).returncode, 0)
        self.assertIn("| batched, 2 threads |", page.read_text())
        self.assertNotIn("old", page.read_text())

    def test_failures_are_told(self):
        self.program("#!/bin/sh\necho no poses\nexit 1\n")
        self.check_failed(self.run_bench(), "no poses")
        self.assertEqual(self.run_bench("--repeats", 0).returncode, 2)
