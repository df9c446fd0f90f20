# SPDX-License-Identifier: Apache-2.0
"""Checks of the cloud: whether measurements that made no part of it agree with it."""

import math

from nightmap_eval.verdict.verdict import check, unknown
from nightmap_eval.verdict.verdict_recording import largest_fixed_part
from nightmap_site.checked_reading import NUMBER, read_object
from nightmap_site.job_results import StageResult

CLOUD = {"?held_out_rays_agreeing_percent": NUMBER, "?held_out_rays_blocked_percent": NUMBER, "?num_points": int}


def checks(site):
    report = read_object(site.path("join_clouds", "report"), CLOUD)
    fixed = site.has("survey") and largest_fixed_part(site)
    in_picture = "a part of the robot is in the picture, see there" if fixed else "much of the picture moves (profile moving)"
    reason = "depth of every tenth keyframe ends on the cloud of the others, where both see the same place"
    if "held_out_rays_agreeing_percent" not in report:
        yield unknown("held-out rays", reason, "too few keyframes, or none that see the same place")
    else:
        yield check("held-out rays", report["held_out_rays_agreeing_percent"], "%", (85, 100), reason,
                    f"only {{value:.0f}} % of the held-out depth ends on the cloud: the way is wrong, or {in_picture}", usable=(60, 100))  # fmt: skip
    figures = StageResult(site.folder_of("point_cloud")).figures()
    kept = 100 * figures.get("num_points", report.get("num_points", 0)) / max(1, figures.get("num_voxels", 0))
    yield check("voxels that make the cloud", kept, "%", (20, math.inf), "of those that depth fell into: the rest no second keyframe saw",
                "only {value:.0f} % of the voxels with depth are in the cloud: the keyframes do not agree about them", usable=(3, math.inf))  # fmt: skip
