# SPDX-License-Identifier: Apache-2.0
"""Errors of a trajectory by known relations between pairs of its poses.

The metric of Kuemmerle et al., On measuring the accuracy of SLAM algorithms (Autonomous Robots 2009): an error far back
does not count again in all that follows, and the frame of the map does not matter. A relation is one line,
`time1 time2 x y z roll pitch yaw`: first_from_second at the two times, in seconds, metres and radians; the rotation is
Rz(yaw) Ry(pitch) Rx(roll). `#` starts a comment.
"""

from dataclasses import dataclass

import numpy as np

from nightmap_eval.trajectory import MAX_POSITION_M, MAX_TIME_NS, angles_deg, interpolated, parse_time_ns
from nightmap_site.checked_reading import read_text
from nightmap_site.script_errors import DataError

MAX_GAP_NS = 500_000_000  # between the poses around a relation's time
REMEDY = "correct the relations of the site config, from which it is made, and run make again"


@dataclass
class Relations:
    times_ns: np.ndarray  # (n, 2) int64
    rotations: np.ndarray  # (n, 3, 3), first_from_second
    translations_m: np.ndarray  # (n, 3)

    def __len__(self):
        return len(self.times_ns)


def euler_rotations(roll_rad, pitch_rad, yaw_rad):
    """Rz(yaw) Ry(pitch) Rx(roll) (n, 3, 3)."""
    (a, b, c), (s, t, u) = (f(np.array([yaw_rad, pitch_rad, roll_rad], dtype=float)) for f in (np.cos, np.sin))
    rows = [[a * b, a * t * u - s * c, a * t * c + s * u],
            [s * b, s * t * u + a * c, s * t * c - a * u],
            [-t, b * u, b * c]]  # fmt: skip
    return np.moveaxis(np.array(rows), 2, 0)


def _parse_line(line):
    """Two times and six values. Raises ValueError with the reason."""
    words = line.split()
    if len(words) != 8:
        raise ValueError(f"{len(words)} columns, not 8: time1 time2 x y z roll pitch yaw")
    try:
        times_ns, values = [parse_time_ns(word) for word in words[:2]], [float(word) for word in words[2:]]
    except (ValueError, OverflowError):
        raise ValueError(f"not a number in: {line.strip()[:200]}") from None
    if not np.all(np.isfinite(values)):
        raise ValueError("NaN or infinity in a relation")
    if max(map(abs, times_ns)) > MAX_TIME_NS or max(map(abs, values)) > MAX_POSITION_M:
        raise ValueError(f"a time or length out of range: {line.strip()[:200]}")
    return times_ns, values


def read_relations(path):
    """The Relations of a file, in its order. Raises DataError naming file and line, and when there is none."""
    times_ns, values = [], []
    for number, line in enumerate(read_text(path, REMEDY).splitlines(), 1):
        line = line.split("#")[0]
        if line.strip():
            try:
                both, six = _parse_line(line)
            except ValueError as error:
                raise DataError(f"{path}:{number}: {error}; {REMEDY}") from None
            times_ns.append(both)
            values.append(six)
    if not values:
        raise DataError(f"{path}: no relation; {REMEDY}")
    values = np.array(values)
    return Relations(np.array(times_ns, dtype=np.int64), euler_rotations(*values[:, 3:].T), values[:, :3])


def relation_errors(relations, estimate, max_gap_ns=MAX_GAP_NS):
    """Translation (m) and rotation (degrees) error of each relation that the estimate has both poses of, and how many it has not.

    The error is relation^-1 * (first^-1 * second) of the estimate, whose poses are interpolated to the times of the relation."""
    rows, poses = zip(*(interpolated(estimate, relations.times_ns[:, end], max_gap_ns) for end in (0, 1)))
    _, in_first, in_second = np.intersect1d(*rows, return_indices=True)
    first, second = poses[0].select(in_first), poses[1].select(in_second)
    both = rows[0][in_first]
    inverse = np.transpose(first.rotations(), (0, 2, 1))
    step_m = np.einsum("nij,nj->ni", inverse, second.positions_m - first.positions_m)
    back = np.transpose(relations.rotations[both], (0, 2, 1))
    translation_m = np.linalg.norm(step_m - relations.translations_m[both], axis=1)
    return translation_m, angles_deg(back @ inverse @ second.rotations()), len(relations) - len(both)


def _mean_and_std(values, name, unit):
    """Mean, and standard deviation of the sample, of errors and of their squares, as the paper has them."""
    figures = {}
    for kind, numbers, suffix in (("", values, unit), ("squared_", np.square(values), f"{unit}2")):
        figures[f"{name}_{kind}mean_{suffix}"] = float(np.mean(numbers))
        figures[f"{name}_{kind}std_{suffix}"] = float(np.std(numbers, ddof=1)) if len(numbers) > 1 else None
    return figures


def relation_metrics(relations, estimate, max_gap_ns=MAX_GAP_NS):
    """Figures of the errors; relations without poses are counted as missing and in no mean."""
    translation_m, rotation_deg, num_missing = relation_errors(relations, estimate, max_gap_ns)
    figures = {"num_relations": len(relations), "num_missing": num_missing}
    if num_missing == len(relations):
        return figures
    figures |= _mean_and_std(translation_m, "translation", "m")
    figures |= _mean_and_std(rotation_deg, "rotation", "deg")
    return figures | {"translation_max_m": float(np.max(translation_m)), "rotation_max_deg": float(np.max(rotation_deg))}
