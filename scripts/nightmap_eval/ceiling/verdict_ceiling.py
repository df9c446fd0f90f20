# SPDX-License-Identifier: Apache-2.0
"""Checks of a map of the ceiling: what the filter saw, and whether that fits what it expected."""

from nightmap_eval.verdict.verdict import check
from nightmap_site.checked_reading import NUMBER, read_object

REPORT = {"num_frames": int, "?num_frames_without_landmark": int, "?num_frames_with_slipping_wheels": int,
          "?mean_nis_per_degree_of_freedom": NUMBER}  # fmt: skip


def checks(site):
    report = read_object(site.path("odometry", "report"), REPORT)
    num_frames = max(1, report["num_frames"])
    yield check("frames without a landmark", 100 * report.get("num_frames_without_landmark", 0) / num_frames, "%", (0, 20),
                "there the wheels alone carry the robot, whose heading drifts",
                "{value:.0f} % of the pictures show no landmark: give the camera more light, or a wider lens", usable=(0, 70))  # fmt: skip
    yield check("slipping wheels", 100 * report.get("num_frames_with_slipping_wheels", 0) / num_frames, "%", (0, 5),
                "of the pictures that contradict the wheels",
                "the wheels contradict {value:.0f} % of the pictures: check their scale, the times of both, and the camera's pose on the "
                "robot")  # fmt: skip
    if "mean_nis_per_degree_of_freedom" in report:
        yield check("surprise of the filter", report["mean_nis_per_degree_of_freedom"], "", (0, 1.5), "squared innovations over their "
                    "covariance: 1 where the noise is as declared",
                    "pictures differ from what was expected {value:.1f} times as much as declared: check the camera's calibration, its "
                    "pose on the robot and the noise of the wheels")  # fmt: skip
