# SPDX-License-Identifier: Apache-2.0
"""Section of the report on the cameras: as given, and as the adjustment of the map found them."""

from nightmap_eval import html
from nightmap_site.checked_reading import NUMBER, check, read_object

COLOR = dict.fromkeys(("fx", "fy", "cx", "cy"), NUMBER)
CAMERAS = {"cameras": [{"camera_id": str, "color": COLOR}]}
REPORT = {"?bundle_rms_px": NUMBER, "?calibrations": (list, str), "?depth_offsets": (list, str)}  # a text: not estimated
FOUND = {"calibrations": [{"?rolling_shutter_readout_s": NUMBER}], "depth_offsets": [{"offset_m": NUMBER, "sigma_m": NUMBER}]}


def calibration_section(site):
    """None on a site whose map adjusted no camera."""
    before, after = site.made("frames", "cameras"), site.made("adjust", "cameras")
    if not (before and after and site.made("adjust", "report")):
        return None
    given, found = (read_object(path, CAMERAS)["cameras"] for path in (before, after))
    report, path = read_object(site.made("adjust", "report"), REPORT), site.made("adjust", "report")
    rows = [row for i, (one, other) in enumerate(zip(given, found)) for row in _rows(one, other, report, i, path)]
    said = [html.paragraph(f"Features lie {report['bundle_rms_px']:.2f} px (RMS) from where the map says.", "note")] if "bundle_rms_px" in report else []
    return html.section("Calibration", html.table(("camera", "", "as given", "as found", "change"), rows), *said)


def _rows(given, found, report, number, path):
    name = given["camera_id"]
    for key in COLOR:
        before, after = given["color"][key], found["color"][key]
        change = f"{100 * (after / before - 1):+.2f} %" if before and after != before else "-"
        yield name, f"{key} (px)", f"{before:.2f}", f"{after:.2f}", change
    readout_s = _found(report, "calibrations", number, path).get("rolling_shutter_readout_s")
    if readout_s is not None:
        yield name, "readout of the rolling shutter (ms)", "-", f"{1000 * readout_s:.1f}", "-"
    offset = _found(report, "depth_offsets", number, path)
    if offset:
        yield name, "offset of depth (cm)", "-", f"{100 * offset['offset_m']:.2f} ± {100 * offset['sigma_m']:.2f}", "-"


def _found(report, name, number, path):
    """Values that the adjustment estimated of a camera; empty where it estimated none."""
    entries = report.get(name, "")
    if isinstance(entries, str) or number >= len(entries):
        return {}
    check(entries, FOUND[name], f"{path}: {name}")
    return entries[number]
