# SPDX-License-Identifier: Apache-2.0
"""Pictures of located queries beside the nearest keyframe, with the landmarks that the keyframe saw: where the found pose puts them in the
query, and where they are in the keyframe. A pose that is right puts them on the same things."""

import numpy as np

from nightmap_eval import html
from nightmap_eval.artifacts import Frames, read_hdf5, read_landmarks, to_ints
from nightmap_eval.camera.picture_pairs import Keypoints, pair_picture
from nightmap_eval.trajectory import rotation_matrices
from nightmap_site.checked_reading import NUMBER, read_csv, read_object, using

LENS = ("k1", "k2", "p1", "p2", "k3")
COLOR = {"width": int, "height": int} | dict.fromkeys(("fx", "fy", "cx", "cy"), NUMBER) | {f"?{name}": NUMBER for name in LENS}
MIN_DEPTH_M = 0.1
MAX_PICTURES = 8


def query_pictures(site, data, chosen, nearest):
    """A folded part of the section on queries; empty where there is nothing to show. chosen: rows of queries.csv; nearest: NearestFrames."""
    located = [row for row in chosen if row["status"] == "located"][:MAX_PICTURES]
    if not located or data is None or nearest is None or not site.made("landmarks", "landmarks"):
        return []
    seen, cameras, frames, keypoints = SeenLandmarks(site), query_cameras(site), Frames(site).by_index(), Keypoints(site)
    parts = [html.paragraph("Lines join a landmark's place in the query, by the found pose, with its place in the nearest keyframe.", "note")]
    for row in located:
        position_m, quaternion = nearest.pose_of(row)
        time_ns = nearest.times_near(position_m, quaternion, 1)[0]
        frame_idx, landmarks_m, features = seen.of(time_ns)
        if frame_idx not in frames or row["query_idx"] not in cameras:
            continue
        frame = frames[frame_idx]
        points = _points(project(cameras[row["query_idx"]], landmarks_m, position_m, quaternion),
                         keypoints.of(frame_idx, int(frame["camera_idx"]), frame["shard"]), features)  # fmt: skip
        said = f"{row['color_path']} and the nearest keyframe, {frame['color_path']}"
        parts += [html.paragraph(said), pair_picture(data, (row["color_path"], frame["color_path"]), points, said)]
    return [html.folded("Located pictures beside the map's", html.Raw("".join(parts)))]


def _points(seen_in_query, keypoints, features):
    if keypoints is None or seen_in_query is None or len(features) == 0 or features.max() >= len(keypoints):
        return None
    shares, is_inside = seen_in_query
    return shares[is_inside], keypoints[features][is_inside]


class SeenLandmarks:
    """Landmarks that each keyframe saw."""

    def __init__(self, site):
        path = site.path("landmarks", "landmarks")
        self.positions_m, offsets, keyframes, features = read_landmarks(
            path, "landmarks/position_in_map_m", "observations/offsets", "observations/keyframe_idx", "observations/feature_idx")
        frame_idxs, times_ns = read_hdf5(path, "keyframes/frame_idx", "keyframes/time_ns")
        with using(path):
            self.keyframes, self.features = keyframes.ravel(), features.ravel()
            self.landmarks = np.repeat(np.arange(len(self.positions_m)), np.diff(offsets.ravel()))
            if not len(self.keyframes) == len(self.features) == len(self.landmarks):
                raise ValueError("observations do not fit each other")
            self.frame_at = {int(time_ns): (k, int(idx)) for k, (time_ns, idx) in enumerate(zip(times_ns.ravel(), frame_idxs.ravel()))}

    def of(self, time_ns):
        """(frame_idx, positions (n, 3), features (n,)) of the keyframe at a time; None and nothing where it has no landmark."""
        k, frame_idx = self.frame_at.get(int(time_ns), (-1, None))
        chosen = self.keyframes == k
        return frame_idx, self.positions_m[self.landmarks[chosen]], self.features[chosen]


def query_cameras(site):
    """query_idx -> its camera as in query_cameras.json."""
    path, table = site.path("queries", "query_cameras"), site.path("queries", "queries")
    cameras = [camera["color"] for camera in read_object(path, {"cameras": [{"color": COLOR}]})["cameras"]]
    rows = read_csv(table, ("frame_idx", "camera_idx"))
    with using(table):
        return {int(idx): cameras[int(camera)] for idx, camera in zip(to_ints(rows, "frame_idx", table), to_ints(rows, "camera_idx", table))}


def project(camera, points_m, position_m, quaternion):
    """(places (n, 2) as shares of the picture's width and height, mask of those in the picture) by OpenCV's five coefficients; None for
    another lens."""
    if camera.get("lens", "pinhole") != "pinhole" or any(camera.get(name) for name in ("k4", "k5", "k6")):
        return None
    in_camera = (points_m - position_m) @ rotation_matrices(np.asarray(quaternion)[None])[0]
    depth_m = np.maximum(in_camera[:, 2], MIN_DEPTH_M)
    x, y = in_camera[:, 0] / depth_m, in_camera[:, 1] / depth_m
    k1, k2, p1, p2, k3 = (camera.get(name, 0.0) for name in LENS)
    r2 = x * x + y * y
    radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3))
    u = camera["fx"] * (x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x)) + camera["cx"]
    v = camera["fy"] * (y * radial + 2 * p2 * x * y + p1 * (r2 + 2 * y * y)) + camera["cy"]
    shares = np.column_stack([(u + 0.5) / camera["width"], (v + 0.5) / camera["height"]])
    return shares, (in_camera[:, 2] > MIN_DEPTH_M) & (shares > 0).all(axis=1) & (shares < 1).all(axis=1)
