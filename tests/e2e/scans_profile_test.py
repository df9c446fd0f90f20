# SPDX-License-Identifier: Apache-2.0
"""A site without a camera: a profile leaves out its jobs and brings one of its own, with a section of the page and figures of
its own. Evaluation and report show these, and no section of what the site has not. The programs are stubs."""
import json
import re

from stub_site import StubTest
from workspace import PIPELINE

KEPT = ("synthesize", "frames", "evaluate", "report")
PROFILE = """
[scan_map]
purpose = "a map from laser scans"
in.scans = "frames.scans"
out.map = "map.txt"
section.report = "stages/scan_map/report.py"
section.evaluation = "stages/scan_map/evaluation.py"
"""
REPORT = """
from nightmap_eval import html


def sections(site, metrics):
    count = metrics["sections"]["scan_map"]["num_bytes"]
    return [html.section("Laser map", html.paragraph(f"{count} bytes of {site.path('scan_map', 'map').name}"))]
"""
EVALUATION = """
def evaluate(site):
    return {"num_bytes": site.made("scan_map", "map").stat().st_size}
"""


class ScansTest(StubTest):
    def setUp(self):
        super().setUp()
        folder = self.site.folder
        (folder / "configs/scans/default").mkdir(parents=True)
        left_out = "".join(f"[{name}]\nleave_out = true\n" for name in PIPELINE.jobs if name not in KEPT)
        (folder / "configs/scans/pipeline.toml").write_text(left_out + PROFILE)
        (folder / "configs/scans/default/scan_map.toml").write_text("size = 1\n")
        (folder / "stages/scan_map").mkdir(parents=True)
        self.report, self.evaluation = folder / "stages/scan_map/report.py", folder / "stages/scan_map/evaluation.py"
        self.report.write_text(REPORT)
        self.evaluation.write_text(EVALUATION)
        self.site.add_program("scan_map")
        config = folder / "configs/sites/demo.toml"
        config.write_text(f'profile = "scans"\n{config.read_text()}')

    def test_the_page_has_its_sections_and_none_of_a_camera(self):
        self.make("map", "evaluate", "report")
        metrics = json.loads(self.site.path("evaluate/metrics.json").read_text())
        self.assertEqual(metrics["sections"], {"scan_map": {"num_bytes": len("scan_map\n")}})
        self.assertEqual((metrics["has_ground_truth"], "coverage" in metrics), (False, False))
        page = self.site.path("report/index.html").read_text()
        titles = re.findall(r"<summary><h2>([^<]*)</h2>", page)
        self.assertEqual(titles, ["Laser map", "Time and memory", "Skipped items", "Configs", "Files"])
        self.assertIn("9 bytes of map.txt", page)
        self.make("-q", "map", "evaluate", "report")
        self.assertIn("2 receipts", self.make("verify"))  # of frames and of its own job
        self.assertIn("scan_map", self.make("why", "SET=scan_map.size=2"))

    def test_a_changed_section_is_shown(self):
        self.make("report")
        self.evaluation.write_text(EVALUATION.replace(".st_size", ".st_size + 1"))
        self.make("report")
        self.assertIn("10 bytes of map.txt", self.site.path("report/index.html").read_text())

    def test_a_section_that_is_lost_is_named(self):
        self.report.unlink()
        output = self.make("report", code=2)
        self.assertIn("stages/scan_map/report.py", output)
