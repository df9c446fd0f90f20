# SPDX-License-Identifier: Apache-2.0
"""Section of the report on located queries, pictures or laser scans."""

import numpy as np

from nightmap_eval import html
from nightmap_eval.artifacts import Frames
from nightmap_eval.camera.query_pictures import query_pictures
from nightmap_eval.pictures import no_recordings
from nightmap_eval.query_errors import PROTOCOLS, RECALL_THRESHOLDS, WRONG_CM, read_located
from nightmap_eval.shown_queries import choose, query_rows, thumbnail
from nightmap_eval.trajectory import read_tum, rotation_matrices
from nightmap_site.query_results import asked_names

MAX_PICTURES = 12
NUM_NEAREST = 2
DEG_PER_M = 30  # a view that is turned by this shows about as much else as one from a metre away


def _figures(queries):
    has_truth = "num_with_truth" in queries
    yield html.table(("", ""), [
        ("Queries", queries["num_queries"]),
        *((verdict.replace("_", " "), count) for verdict, count in queries["num_by_verdict"].items()),
        *([("With truth", queries["num_with_truth"])] if has_truth else []),
    ])  # fmt: skip
    if not has_truth:
        return
    names = [(f"{title} error ({unit}); a failure counts as infinite", f"{key}_{kind}_error_{unit}")
             for title, key in (("Median", "median"), ("90 %", "p90"))
             for kind, unit in (("translation", "cm"), ("rotation", "deg"))]  # fmt: skip
    names += [(f"Within {max_cm} cm and {max_deg} deg (%)", f"recall_{max_cm}cm_{max_deg}deg_percent")
              for max_cm, max_deg in RECALL_THRESHOLDS]  # fmt: skip
    names.append((f"Located with an error above {WRONG_CM} cm", "num_wrong"))
    rows = [(title, *(html.number(queries[way][key]) for way in PROTOCOLS)) for title, key in names]
    yield html.table(("", "map aligned as a whole", "map aligned around each query"), rows)


def _query_row(row, is_asked):
    status = row["status"]
    name = f"{row['color_path']} (of QUERY)" if is_asked else row["color_path"]
    if status != "located":
        status = html.Raw(f'<span class="failed">{html.escape(status)}</span>')
    errors = [row.get(name) for name in ("translation_error_cm", "rotation_error_deg")]
    shown = [html.number(value) if value is not None else "" for value in errors]
    return [name, status, *_pose(row), *shown, row["reason"]]


def _pose(row):
    """Cells of where a located query is and how sure that is, as far as the rows say it."""
    position = [row.get(f"t{axis}_m") for axis in "xyz"]
    sigmas = [(row.get("position_sigma_m"), 100), (row.get("rotation_sigma_deg"), 1)]
    return [", ".join(f"{float(value):.2f}" for value in position) if all(position) else "",
            *(html.number(scale * float(value)) if value else "" for value, scale in sigmas)]  # fmt: skip


def query_section(site, metrics, data):
    rows = query_rows(site, metrics)
    if rows is None:
        return html.section("Queries", html.paragraph("The localize stage did not run.", "note"))
    parts = list(_figures(metrics["queries"])) if "queries" in metrics else []
    asked, asks = asked_names(site), site.pipeline.asks
    head = (asks.removesuffix("s"), "status", "x, y, z (m)", "sigma (cm)", "sigma (deg)", "error (cm)", "error (deg)", "reason")
    of_query, own = ([row for row in rows if (row["color_path"] in asked) == which] for which in (True, False))
    chosen = [*of_query, *choose(own, MAX_PICTURES)]
    shown = [_query_row(row, row["color_path"] in asked) for row in chosen]
    nearest = nearest_keyframes(site) if asks == "pictures" else None
    if asks == "pictures":
        head = ("", "nearest in the map", *head)
        paths = [nearest.near(*nearest.pose_of(row), NUM_NEAREST) if nearest and row["status"] == "located" else [] for row in chosen]
        beside = [" ".join(html.escape(thumbnail(data, path)) for path in of_row) for of_row in paths]
        shown = [[thumbnail(data, row["color_path"]), html.Raw(f'<span class="side">{pictures}</span>'), *cells]
                 for row, pictures, cells in zip(chosen, beside, shown)]  # fmt: skip
    parts += [no_recordings()] if data is None and asks == "pictures" else []
    parts += [html.table(head, shown), *query_pictures(site, data, chosen, nearest)]
    if len(own) > MAX_PICTURES:
        parts.append(html.paragraph(f"{MAX_PICTURES} of the site's {len(own)} queries: failures, the worst, and an even sample.", "note"))
    return html.section("Queries", *parts)


class NearestFrames:
    """Keyframes of the map by place and direction of view, and the poses of the located queries."""

    def __init__(self, site):
        keyframes, frames = read_tum(site.path("map_frame", "keyframes")), Frames(site)
        path_at = {time_ns: row["color_path"] for time_ns, row in zip(frames.times_ns, frames.rows)}
        self.keyframes = keyframes.select([i for i, time_ns in enumerate(keyframes.times_ns) if int(time_ns) in path_at])
        self.color_paths = [path_at[int(time_ns)] for time_ns in self.keyframes.times_ns]
        self.views = self.keyframes.rotations()[:, :, 2]

        rows, times_ns, self.located = read_located(site.path("localize", "queries"))
        pose_at = {int(time_ns): i for i, time_ns in enumerate(self.located.times_ns)}
        self.pose_of_query = {int(row["query_idx"]): pose_at[int(time_ns)] for row, time_ns in zip(rows, times_ns) if int(time_ns) in pose_at}

    def pose_of(self, row):
        """(position (3,), quaternion (4,)) of a located query."""
        pose = self.pose_of_query[row["query_idx"]]
        return self.located.positions_m[pose], self.located.quaternions[pose]

    def near(self, position_m, quaternion, count):
        """color_path of the `count` keyframes whose place and direction of view are the nearest."""
        return [self.color_paths[i] for i in self._rows_near(position_m, quaternion, count)]

    def times_near(self, position_m, quaternion, count):
        return [int(self.keyframes.times_ns[i]) for i in self._rows_near(position_m, quaternion, count)]

    def _rows_near(self, position_m, quaternion, count):
        distances_m = np.linalg.norm(self.keyframes.positions_m - position_m, axis=1)
        cosines = self.views @ rotation_matrices(quaternion[None])[0][:, 2]
        apart = distances_m + np.degrees(np.arccos(np.clip(cosines, -1, 1))) / DEG_PER_M
        return np.argsort(apart, kind="stable")[:count]


def nearest_keyframes(site):
    """A NearestFrames; None without a map or located queries."""
    return NearestFrames(site) if site.made("localize", "queries") and site.made("map_frame", "keyframes") else None
