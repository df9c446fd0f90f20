# SPDX-License-Identifier: Apache-2.0
"""The way of the camera or the robot in the map, and the loops that join its places."""

from nightmap_eval.artifacts import Frames
from nightmap_eval.loop_accuracy import read_loops
from nightmap_eval.trajectory import read_tum
from nightmap_site.checked_reading import REMEDY
from nightmap_site.script_errors import DataError


def way_of(site):
    """The trajectory of the last job that made one; None without any, and of none that is empty."""
    paths = (site.made(job, "trajectory") for job in ("map_frame", "adjust", "odometry"))
    way = next((read_tum(path) for path in paths if path), None)
    return way if way is not None and len(way) else None


def loop_ends(site, way):
    """(accepted, rejected) loops: pairs of positions (2, 3) in the map frame; none of a loop with an end that has no pose."""
    path = site.made("pose_graph", "loops_csv")
    if not path:
        return [], []
    row_of_time = {int(time_ns): row for row, time_ns in enumerate(way.times_ns)}
    row_of_end = {end: row_of_time.get(time_ns) for end, time_ns in _times_of_ends(site).items()}
    loops = {True: [], False: []}
    for number, row in enumerate(read_loops(path), 2):
        ends = row["frame_a"], row["frame_b"]
        if not site.has_camera() and not all(end in row_of_end for end in ends):
            raise DataError(f"{path}:{number}: joins {ends[0]} and {ends[1]}, one of which the site has not; {REMEDY}")
        rows = [row_of_end.get(end) for end in ends]
        if None not in rows:
            loops[row["status"] == "accepted"].append(way.positions_m[rows])
    return loops[True], loops[False]


def _times_of_ends(site):
    """Number in loops.csv -> time: of frames, or on a site without a camera, of the poses of pose_graph."""
    if site.has_camera():
        frames = Frames(site)
        return dict(zip(frames.frame_idxs.tolist(), frames.times_ns.tolist()))
    poses = site.made("pose_graph", "trajectory")
    return dict(enumerate(read_tum(poses).times_ns.tolist())) if poses else {}
