# SPDX-License-Identifier: Apache-2.0
"""Trajectories in the TUM format, their association by time, and their alignment.

Poses are target_from_camera: positions in metres, unit quaternions (qx, qy, qz, qw).
"""

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from nightmap_site.checked_reading import REMEDY, read_text
from nightmap_site.script_errors import DataError

MAX_TIME_NS = 2**63 - 1
MAX_POSITION_M = 1e9  # beyond it squared distances lose the millimetres, and then overflow
FRAME_GAP_NS = 20_000_000  # between a frame or a query and its true pose


@dataclass
class Trajectory:
    """Poses sorted by time."""

    times_ns: np.ndarray  # (n,) int64, strictly increasing
    positions_m: np.ndarray  # (n, 3)
    quaternions: np.ndarray  # (n, 4), qx qy qz qw, unit

    def __len__(self):
        return len(self.times_ns)

    def rotations(self):
        return rotation_matrices(self.quaternions)

    def select(self, indices):
        indices = np.asarray(indices, dtype=int)
        return Trajectory(self.times_ns[indices], self.positions_m[indices], self.quaternions[indices])


@dataclass
class Similarity:
    """target_from_source: point_in_target = scale * rotation @ point_in_source + translation."""

    scale: float
    rotation: np.ndarray  # (3, 3)
    translation_m: np.ndarray  # (3,)
    is_unique: bool = True  # False when all points lie on one line

    def apply(self, points_m):
        return self.scale * np.asarray(points_m) @ self.rotation.T + self.translation_m

    def apply_inverse(self, points_m):
        return (np.asarray(points_m) - self.translation_m) @ self.rotation / self.scale


def rotation_matrices(quaternions):
    """Rotation matrices (n, 3, 3) of unit quaternions (n, 4) in the order qx qy qz qw."""
    x, y, z, w = np.asarray(quaternions, dtype=float).T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), 2, 0)


def quaternion(rotation):
    """Unit quaternion (qx, qy, qz, qw), qw >= 0, of a rotation matrix."""
    found = Rotation.from_matrix(rotation).as_quat()
    return found if found[3] >= 0 else -found


def angles_deg(rotations):
    """Angles in [0, 180] of rotation matrices (n, 3, 3), accurate near 0 and near 180."""
    skew = rotations[:, [2, 0, 1], [1, 2, 0]] - rotations[:, [1, 2, 0], [2, 0, 1]]
    trace = np.trace(rotations, axis1=1, axis2=2)
    return np.degrees(np.arctan2(np.linalg.norm(skew, axis=1), trace - 1))


def parse_time_ns(text):
    """Nanoseconds of a decimal number of seconds, exact because no double is involved."""
    whole, _, fraction = text.partition(".")
    negative = whole.startswith("-")
    digits = whole.lstrip("+-") or "0"
    if not (digits + fraction).isdigit():
        return round(float(text) * 1e9)  # exponent notation; ValueError when not a number
    value = int(digits) * 10**9 + int((fraction + "0" * 9)[:9])
    return -value if negative else value


def read_rows(path, remedy, columns, num_times):
    """(place, times in ns, values) of each line of numbers, the first of which are times; `#` starts a comment. Raises DataError naming
    file and line."""
    for number, line in enumerate(read_text(path, remedy).splitlines(), 1):
        words, place = line.split("#")[0].replace(",", " ").split(), f"{path}:{number}"
        if not words:
            continue
        if len(words) != len(columns.split()):
            raise DataError(f"{place}: {len(words)} columns, not {len(columns.split())}: {columns}; {remedy}")
        try:
            times_ns, values = [parse_time_ns(word) for word in words[:num_times]], [float(word) for word in words[num_times:]]
        except (ValueError, OverflowError):
            raise DataError(f"{place}: not a number in: {line.strip()[:200]}; {remedy}") from None
        if not np.all(np.isfinite(values)):
            raise DataError(f"{place}: NaN or infinity; {remedy}")
        if max(map(abs, times_ns)) > MAX_TIME_NS or max(map(abs, values)) > MAX_POSITION_M:
            raise DataError(f"{place}: a time or length out of range: {line.strip()[:200]}; {remedy}")
        yield place, times_ns, values


def read_tum(path, remedy=REMEDY):
    """A Trajectory sorted by time. Raises DataError naming file and line."""
    poses = []
    for place, [time_ns], values in read_rows(path, remedy, "time tx ty tz qx qy qz qw", 1):
        norm = np.linalg.norm(values[3:])
        if not 0.5 < norm < 2:
            raise DataError(f"{place}: the quaternion has norm {norm:.3g}; expected 1; {remedy}")
        poses.append((time_ns, values[:3], np.array(values[3:]) / norm))
    return make_trajectory(poses, path)


def read_truth(path):
    """Like read_tum, for the true poses that the frames stage copied."""
    return read_tum(path, "correct the ground_truth of the site config, from which it is made, and run make again")


def make_trajectory(poses, source):
    """A Trajectory from a list of (time_ns, position, quaternion). `source` names it in messages."""
    poses = sorted(poses, key=lambda pose: pose[0])
    times_ns = np.array([pose[0] for pose in poses], dtype=np.int64)
    repeated = np.flatnonzero(np.diff(times_ns) == 0)
    if len(repeated):
        raise DataError(f"{source}: two poses at time {times_ns[repeated[0]]} ns")
    positions = np.array([pose[1] for pose in poses], dtype=float).reshape(-1, 3)
    quaternions = np.array([pose[2] for pose in poses], dtype=float).reshape(-1, 4)
    return Trajectory(times_ns, positions, quaternions)


def associate(times_ns, reference_times_ns, max_gap_ns):
    """Index pairs (i, j): the nearest reference time of each time, at most max_gap_ns away.

    One to one: if several times share a nearest reference, only the closest stays.
    """
    best = {}
    if len(reference_times_ns) == 0:
        return np.zeros((0, 2), dtype=int)
    after = np.searchsorted(reference_times_ns, times_ns)
    for i, time_ns in enumerate(times_ns):
        near = [j for j in (after[i] - 1, after[i]) if 0 <= j < len(reference_times_ns)]
        gap, j = min((abs(int(time_ns) - int(reference_times_ns[j])), j) for j in near)
        if gap <= max_gap_ns and (j not in best or gap < best[j][0]):
            best[j] = (gap, i)
    return np.array(sorted((i, j) for j, (_, i) in best.items()), dtype=int).reshape(-1, 2)


def interpolated(trajectory, times_ns, max_gap_ns, same_ns=1_000_000):
    """Rows of `times_ns` that have a pose, and these poses, at those times.

    A pose at most same_ns away stands for the time itself: two clocks round alike times differently. Else the pose is
    interpolated between its neighbours, on a straight line and a great circle of quaternions, if these are at
    most max_gap_ns apart. There is no pose before the first and after the last."""
    times_ns, known_ns = np.asarray(times_ns, dtype=np.int64), trajectory.times_ns
    if len(known_ns) == 0 or len(times_ns) == 0:
        return np.zeros(0, dtype=int), trajectory.select([])
    after = np.clip(np.searchsorted(known_ns, times_ns), 0, len(known_ns) - 1)
    before = np.clip(np.searchsorted(known_ns, times_ns, side="right") - 1, 0, None)
    to_before, to_after = times_ns - known_ns[before], known_ns[after] - times_ns  # negative outside
    nearest = np.where(np.abs(to_before) <= np.abs(to_after), before, after)
    is_same = np.abs(times_ns - known_ns[nearest]) <= same_ns
    is_between = (to_before >= 0) & (to_after >= 0) & (to_before + to_after <= max_gap_ns)
    rows = np.flatnonzero(is_same | is_between)
    first = np.where(is_same, nearest, before)[rows]
    second = np.where(is_same, nearest, after)[rows]
    gap_ns = known_ns[second] - known_ns[first]
    share = ((times_ns[rows] - known_ns[first]) / np.where(gap_ns > 0, gap_ns, 1) * (gap_ns > 0))[:, None]
    positions_m = trajectory.positions_m[first] * (1 - share) + trajectory.positions_m[second] * share
    return rows, Trajectory(times_ns[rows], positions_m, _slerp(trajectory.quaternions[first], trajectory.quaternions[second], share))


def _slerp(first, second, share):
    """Quaternions between two (Shoemake, SIGGRAPH 1985); share (n, 1): 0 gives the first, 1 the second."""
    cosine = np.sum(first * second, axis=1, keepdims=True)
    second, cosine = np.where(cosine < 0, -second, second), np.minimum(np.abs(cosine), 1)
    angle = np.arccos(cosine)
    sine = np.sin(angle)
    is_small = sine < 1e-9
    safe = np.where(is_small, 1, sine)
    a = np.where(is_small, 1 - share, np.sin((1 - share) * angle) / safe)
    b = np.where(is_small, share, np.sin(share * angle) / safe)
    mixed = a * first + b * second
    return mixed / np.linalg.norm(mixed, axis=1, keepdims=True)


def _centred(source_m, target_m, least):
    """(source, its mean, target, its mean), both as seen from their means. Raises DataError on fewer points than `least`, and on NaN."""
    source, target = np.asarray(source_m, dtype=float), np.asarray(target_m, dtype=float)
    if len(source) < least:
        raise DataError(f"alignment needs at least {least} matched poses, there are {len(source)}")
    if not (np.all(np.isfinite(source)) and np.all(np.isfinite(target))):
        raise DataError("cannot align positions that are NaN or infinite")
    source_mean, target_mean = source.mean(axis=0), target.mean(axis=0)
    return source - source_mean, source_mean, target - target_mean, target_mean


def umeyama(source_m, target_m, with_scale):
    """target_from_source that minimises the squared distances (Umeyama, PAMI 1991).

    Without scale it is the rigid transform. Raises DataError on fewer than 3 points, on NaN, and
    when the source points are all the same.
    """
    source, source_mean, target, target_mean = _centred(source_m, target_m, 3)
    variance = np.mean(np.sum(source**2, axis=1))
    if variance < 1e-18:
        raise DataError("cannot align positions that are all the same: the camera did not move")
    u, d, vt = np.linalg.svd(target.T @ source / len(source))
    signs = np.array([1.0, 1.0, np.sign(np.linalg.det(u) * np.linalg.det(vt))])
    rotation = u @ np.diag(signs) @ vt
    scale = float(d @ signs / variance) if with_scale else 1.0
    translation = target_mean - scale * rotation @ source_mean
    return Similarity(scale, rotation, translation, bool(d[1] > 1e-9 * d[0]))


def planar_umeyama(source_m, target_m, with_scale):
    """Like umeyama for a robot on a floor: turns about z alone, so that two places are enough and no mirrored path fits."""
    source, source_mean, target, target_mean = _centred(source_m, target_m, 2)
    (x, y), (u, v) = source.T[:2], target.T[:2]
    if np.mean(x * x + y * y) < 1e-18:
        raise DataError("cannot align positions that are all the same: the robot did not move")
    along, across = np.sum(x * u + y * v), np.sum(x * v - y * u)
    size = np.hypot(along, across)
    cos, sin = (along / size, across / size) if size > 0 else (1.0, 0.0)
    rotation = np.array([[cos, -sin, 0], [sin, cos, 0], [0, 0, 1]])
    scale = float(size / np.sum(x * x + y * y)) if with_scale else 1.0
    return Similarity(scale, rotation, target_mean - scale * rotation @ source_mean, bool(size > 0))


def travelled_m(positions_m):
    """Path from the first position to each."""
    return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(positions_m, axis=0), axis=1))])


def path_length_m(positions_m):
    return float(np.sum(np.linalg.norm(np.diff(positions_m, axis=0), axis=1)))
