# SPDX-License-Identifier: Apache-2.0
"""Checks of the times of a sensor's samples: rate, and stamps that are no times of measuring."""

import math

import numpy as np

from nightmap_eval.verdict.verdict import check
from nightmap_site.checked_reading import NUMBER

GAP_INTERVALS, GAP_S = 5, 3.0
FAR_SHORTER = 0.1
FEW = 10  # samples


def intervals_s(times_ns):
    return np.diff(times_ns) / 1e9


def usual_interval_s(times_ns):
    """The mean of the intervals that are no gaps: of batches it is still that of measuring."""
    steps_s = intervals_s(times_ns)
    return float(np.mean(steps_s[steps_s <= max(GAP_S, GAP_INTERVALS * np.quantile(steps_s, 0.75))]))


def gap_steps(times_ns):
    """Indices of the samples after which a gap begins."""
    if len(times_ns) < FEW:
        return np.zeros(0, int)
    return np.flatnonzero(intervals_s(times_ns) > max(GAP_S, GAP_INTERVALS * usual_interval_s(times_ns)))


def time_checks(samples, what, report):
    if len(samples.times_ns) < FEW:
        yield check(f"number of {what}", len(samples.times_ns), "", (FEW, math.inf), "a map needs more", "only {value:.0f}: is `file` of the "
                    "[[signal]] the whole log, and `message` right?")  # fmt: skip
        return
    usual_s = usual_interval_s(samples.times_ns)
    yield check(f"rate of {what}", 1 / usual_s, "Hz", (0.2, 1e4), "in 5 s a robot drives out of one room and into another",
                "{value:.2g} samples per second are few: record more, or drive slower")  # fmt: skip
    short = 100 * float(np.mean(intervals_s(samples.times_ns) < FAR_SHORTER * usual_s))
    counted = report.get("num_times_in_line_order", {}).get(samples.sensor_id, 0)
    num_right = counted if isinstance(counted, NUMBER) else 0
    yield check(f"times of {what}", short, "% of the steps", (0, 30), "are below a tenth of the usual step: such times are not of measuring, "
                "but of writing batches, or went back and were put right",
                f"{{value:.0f}} % of the times lie close after the one before, and {num_right} went back: stamp samples when they are measured, "
                "not when they are written")  # fmt: skip
