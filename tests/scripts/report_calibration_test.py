# SPDX-License-Identifier: Apache-2.0
"""Section on the cameras before and after the adjustment."""

import json
import unittest

from folder_case import SiteFolderTest
from nightmap_eval.camera.report_calibration import calibration_section
from nightmap_site.script_errors import DataError
from nightmap_site.site import Site


class CalibrationTest(SiteFolderTest):
    def section(self, report, scale=0.99):
        for folder, focal in (("frames", 500.0), ("adjust", 500.0 * scale)):
            camera = {"camera_id": "<kinect>", "color": {"fx": focal, "fy": focal, "cx": 320.0, "cy": 240.0}}
            self.write(f"{folder}/cameras.json", json.dumps({"cameras": [camera]}))
        self.write("adjust/report.json", json.dumps(report))
        return calibration_section(Site(self.site_dir))

    def test_each_value_stands_before_and_after(self):
        report = {"bundle_rms_px": 0.5, "calibrations": [{"focal_scale": 0.99, "rolling_shutter_readout_s": 0.0102}],
                  "depth_offsets": [{"offset_m": 0.0207, "sigma_m": 0.0011}]}  # fmt: skip
        section = self.section(report)
        for row in ("<td>&lt;kinect&gt;</td><td>fx (px)</td><td>500.00</td><td>495.00</td><td>-1.00 %</td>", "<td>cx (px)</td><td>320.00</td><td>320.00</td><td>-</td>",
                    "readout of the rolling shutter (ms)</td><td>-</td><td>10.2", "offset of depth (cm)</td><td>-</td><td>2.07 ± 0.11"):  # fmt: skip
            self.assertIn(row, section)

    def test_values_that_were_not_estimated_have_no_row(self):
        section = self.section({"calibrations": "not estimated", "depth_offsets": "not estimated"})
        self.assertNotIn("rolling", section)
        self.assertNotIn("offset", section)

    def test_a_site_without_an_adjustment_has_no_section(self):
        self.site_dir.mkdir(parents=True)
        self.assertIsNone(calibration_section(Site(self.site_dir)))

    def test_damaged_values_are_named(self):
        with self.assertRaisesRegex(DataError, "adjust/report.json: depth_offsets: no 'sigma_m'"):
            self.section({"depth_offsets": [{"offset_m": 0.1}]})


if __name__ == "__main__":
    unittest.main()
