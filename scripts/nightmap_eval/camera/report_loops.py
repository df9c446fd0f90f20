# SPDX-License-Identifier: Apache-2.0
"""Section of the report with pictures of loops: both frames, their matches, and why a loop was rejected."""

from nightmap_eval import html
from nightmap_eval.artifacts import Frames, read_hdf5
from nightmap_eval.camera.picture_pairs import Keypoints, pair_picture
from nightmap_eval.loop_accuracy import read_loops
from nightmap_eval.pictures import no_recordings
from nightmap_site.checked_reading import using

MAX_PER_KIND = 3


def loop_pictures_section(site, data):
    """None on a site without loops of pictures."""
    path = site.made("pose_graph", "loops_csv")
    if not path or not site.has_camera():
        return None
    if data is None:
        return html.section("Loops in pictures", no_recordings())
    frames = Frames(site).by_index()
    rows = [row for row in read_loops(path) if row["frame_a"] in frames and row["frame_b"] in frames]
    shown = [row for kind in sorted({(row["status"], row["reason"]) for row in rows}) for row in _spread(rows, kind)]
    if not shown:
        return None
    keypoints, matches = Keypoints(site), loop_matches(site)
    parts = [html.paragraph("Some of each kind. Lines join what was found to be the same; a loop that was rejected early has none.", "note")]
    for row in shown:
        ends = row["frame_a"], row["frame_b"]
        rows_of = [frames[end] for end in ends]
        said = f"{row['status']}{': ' + row['reason'] if row['reason'] else ''}, frames {ends[0]} and {ends[1]}"
        counts = ", ".join(f"{row[key]} {name}" for key, name in (("num_putative", "matches of descriptors"), ("num_inliers", "agree with one motion")) if key in row)
        points = _points(keypoints, rows_of, ends, matches.get(ends))
        parts += [html.paragraph(f"{said} ({counts})" if counts else said, "" if row["status"] == "accepted" else "failed"),
                  pair_picture(data, [one["color_path"] for one in rows_of], points, said)]  # fmt: skip
    return html.section("Loops in pictures", *parts)


def _spread(rows, kind):
    """Up to MAX_PER_KIND rows of a kind, over the whole recording."""
    of_kind = [row for row in rows if (row["status"], row["reason"]) == kind]
    count = min(MAX_PER_KIND, len(of_kind))
    return [of_kind[i * len(of_kind) // count] for i in range(count)]


def loop_matches(site):
    """(frame_a, frame_b) -> features (n, 2) that are the same, of each verified pair."""
    path = site.made("loops", "loops")
    if not path:
        return {}
    frames, first, matches = read_hdf5(path, "frame", "first_match", "match")
    with using(path):
        first = first.ravel()
        return {(a, b): matches[first[i] : first[i + 1]] for i, (a, b) in enumerate(frames.tolist()) if first[i + 1] > first[i]}


def _points(keypoints, rows, ends, matches):
    if matches is None:
        return None
    found = [keypoints.of(end, int(row["camera_idx"]), row["shard"]) for end, row in zip(ends, rows)]
    if any(one is None or matches[:, side].max() >= len(one) for side, one in enumerate(found)):
        return None
    return [one[matches[:, side]] for side, one in enumerate(found)]
