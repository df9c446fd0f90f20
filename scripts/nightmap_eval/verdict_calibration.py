# SPDX-License-Identifier: Apache-2.0
"""Checks of what the adjustment of the map found out about cameras."""

from nightmap_eval.verdict import check
from nightmap_site.checked_reading import NUMBER, read_object

REPORT = {"?bundle_rms_px": NUMBER, "?calibrations": [{"?focal_scale": NUMBER, "?rolling_shutter_readout_s": NUMBER}]}


def checks(site):
    report = read_object(site.path("adjust", "report"), REPORT)
    for number, found in enumerate(report.get("calibrations", [])):
        scale = found.get("focal_scale", 1.0)
        yield check(f"focal length of camera {number}", 100 * (scale - 1), "% off", (-3, 3), "a calibration is good to 1 %, and the "
                    "estimate from the map to about as much",
                    f"the map fits a focal length {scale:.3f} times the given one better: check fx, fy, cx, cy, and that width and height "
                    "are those of the calibrated pictures", usable=(-20, 20))  # fmt: skip
    if "bundle_rms_px" in report:
        yield check("error of features", report["bundle_rms_px"], "px", (0, 1.6), "features are found to about a pixel",
                    "features lie {value:.1f} px from where the map says: check the distortion, and what moves")  # fmt: skip
