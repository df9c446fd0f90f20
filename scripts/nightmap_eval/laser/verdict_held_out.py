# SPDX-License-Identifier: Apache-2.0
"""Checks of a map by the scans that were kept out of it: whether they are found where the robot's way says. The map was drawn by the
same way, so a scan that is found elsewhere tells of a place that is drawn twice, or of another that looks like it."""

from nightmap_eval.laser.scan_relocalization import read_scans
from nightmap_eval.query_errors import WRONG_CM, query_summary
from nightmap_eval.verdict.verdict import check, unknown

MIN_LOCATED = 10  # fewer tell nothing
GOOD_WRONG, USABLE_WRONG = 3, 20  # percent; one scan is good, however few there are
MAX_SPREAD_CM = 10
REMEDY = "look at the loops, at the scale of the wheels, and at the angles and the pose of the scanner"


def checks(site):
    queries, truth = site.made("test_localize", "queries"), site.made("test_scans", "truth")
    if queries and truth:
        yield from held_out_checks(read_scans(queries, truth))


def held_out_checks(scans):
    found = "scans kept out and found elsewhere"
    reason = f"of those located, more than {WRONG_CM} cm from where the robot's way says; one may be a look-alike"
    count = len(scans.located)
    if count < MIN_LOCATED:
        yield unknown(found, reason, f"{count} of {len(scans.rows)} scans that were kept out of a second map are located, too few to tell: the "
                      "robot came to few places twice, or they look alike")  # fmt: skip
        return
    figures, one_percent = query_summary(scans.translation_m, scans.rotation_deg, count), 100 / count
    yield check(found, one_percent * figures["num_wrong"], "%", (0, max(GOOD_WRONG, one_percent)), reason, "{value:.0f} % of the scans that "
                "were kept out are found elsewhere than the robot's way says: the map contradicts itself, places are drawn twice, apart: "
                f"{REMEDY}", usable=(0, max(USABLE_WRONG, one_percent)))  # fmt: skip
    yield check("spread of scans kept out", figures["located_median_translation_error_cm"], "cm", (0, MAX_SPREAD_CM), "median distance from "
                "the robot's way; a map that agrees with itself has 1 to 3 cm", "scans that were kept out are found {value:.0f} cm from where "
                f"the robot's way says: the map contradicts itself, the drawings of a place lie apart: {REMEDY}")  # fmt: skip
