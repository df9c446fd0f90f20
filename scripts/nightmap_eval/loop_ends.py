# SPDX-License-Identifier: Apache-2.0
"""Loops of a site as pairs of places, to draw them."""

from nightmap_eval.artifacts import Frames
from nightmap_eval.loop_accuracy import read_loops
from nightmap_eval.trajectory import read_tum
from nightmap_site.checked_reading import REMEDY
from nightmap_site.script_errors import DataError


def loop_ends(site, estimate):
    """(accepted, rejected) loops: pairs of positions (2, 3) in the map frame; none of a loop with an end that the estimate lacks.

    loops.csv numbers the frames of a camera, and else the poses of pose_graph."""
    path, poses = site.made("pose_graph", "loops_csv"), site.made("pose_graph", "trajectory")
    if not path or not (site.has_camera() or poses):
        return [], []
    row_of_time = {int(time_ns): row for row, time_ns in enumerate(estimate.times_ns)}
    row_of_frame = _of_frames(site, row_of_time) if site.has_camera() else None
    times_ns = None if site.has_camera() else read_tum(poses).times_ns
    loops = {True: [], False: []}
    for number, row in enumerate(read_loops(path), 2):
        ends = row["frame_a"], row["frame_b"]
        if row_of_frame is None and not all(0 <= end < len(times_ns) for end in ends):
            raise DataError(f"{path}:{number}: pose {max(ends, key=abs)} of {len(times_ns)} in {poses}; {REMEDY}")
        rows = [row_of_time.get(int(times_ns[end])) if row_of_frame is None else row_of_frame.get(end) for end in ends]
        if None not in rows:
            loops[row["status"] == "accepted"].append(estimate.positions_m[rows])
    return loops[True], loops[False]


def _of_frames(site, row_of_time):
    frames = Frames(site)
    return {int(idx): row_of_time.get(int(time_ns)) for idx, time_ns in zip(frames.frame_idxs, frames.times_ns)}
