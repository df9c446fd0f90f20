# SPDX-License-Identifier: Apache-2.0
"""Checks of what the adjustment of the map found out about cameras."""

from nightmap_eval.verdict.verdict import check, escaped, unknown
from nightmap_site import checked_reading
from nightmap_site.checked_reading import NUMBER, read_object

REPORT = {"?bundle_rms_px": NUMBER, "?calibrations": (list, str), "?depth_offsets": (list, str)}  # a text: not estimated
CALIBRATIONS = [{"?focal_scale": NUMBER, "?rolling_shutter_readout_s": NUMBER}]
OFFSETS = [{"offset_m": NUMBER, "sigma_m": NUMBER}]
CAMERAS = {"cameras": [{"camera_id": str, "?depth_offset_m": NUMBER}]}
SURE_M = 0.01  # an offset is known whose standard deviation is less


def checks(site):
    path = site.path("adjust", "report")
    report = read_object(path, REPORT)
    for number, found in enumerate(_estimated(report, "calibrations", CALIBRATIONS, path)):
        scale = found.get("focal_scale", 1.0)
        yield check(f"focal length of camera {number}", 100 * (scale - 1), "% off", (-3, 3), "a calibration is good to 1 %, and the "
                    "estimate from the map to about as much",
                    f"the map fits a focal length {scale:.3f} times the given one better: check fx, fy, cx, cy, and that width and height "
                    "are those of the calibrated pictures", usable=(-20, 20))  # fmt: skip
    offsets = _estimated(report, "depth_offsets", OFFSETS, path)
    if offsets:
        yield from _offset_checks(offsets, read_object(site.path("frames", "cameras"), CAMERAS)["cameras"])
    if "bundle_rms_px" in report:
        yield check("error of features", report["bundle_rms_px"], "px", (0, 1.6), "features are found to about a pixel",
                    "features lie {value:.1f} px from where the map says: check the distortion, and what moves")  # fmt: skip


def _estimated(report, name, shape, path):
    found = report.get(name, "")
    if isinstance(found, str):
        return []
    checked_reading.check(found, shape, f"{path}: {name}")
    return found


def _offset_checks(offsets, cameras):
    reason = "depth cameras of rooms are off by up to 3 cm; parallax of the pictures tells by how much"
    for number, (found, camera) in enumerate(zip(offsets, cameras, strict=True)):
        name = f"offset of depth of camera {number}"
        if found["sigma_m"] > SURE_M:
            yield unknown(name, reason, "the camera turns more than it moves, so no parallax tells whether depth is too far or too near")
            continue
        offset_m = camera.get("depth_offset_m", 0.0) + found["offset_m"]
        way = "far" if found["offset_m"] > 0 else "near"
        yield check(name, 100 * found["offset_m"], "cm", (-5, 5), reason,
                    f"depth is {100 * abs(found['offset_m']):.1f} cm too {way} at any distance: set depth_offset_m = {offset_m:.3f} in the "
                    f"[[camera]] {escaped(camera['camera_id'])}", usable=(-8, 8))  # fmt: skip
