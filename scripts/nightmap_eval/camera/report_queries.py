# SPDX-License-Identifier: Apache-2.0
"""Section of the report on located queries, pictures or laser scans."""

import numpy as np

from nightmap_eval import html
from nightmap_eval.artifacts import Frames
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
    return [name, status, *shown, row["reason"]]


def query_section(site, metrics, data):
    rows = query_rows(site, metrics)
    if rows is None:
        return html.section("Queries", html.paragraph("The localize stage did not run.", "note"))
    parts = list(_figures(metrics["queries"])) if "queries" in metrics else []
    asked, asks = asked_names(site), site.pipeline.asks
    head = (asks.removesuffix("s"), "status", "error (cm)", "error (deg)", "reason")
    of_query, own = ([row for row in rows if (row["color_path"] in asked) == which] for which in (True, False))
    chosen = [*of_query, *choose(own, MAX_PICTURES)]
    shown = [_query_row(row, row["color_path"] in asked) for row in chosen]
    if asks == "pictures":
        nearest = nearest_frames(site, NUM_NEAREST)
        head = ("", "nearest in the map", *head)
        beside = [" ".join(html.escape(thumbnail(data, path)) for path in nearest.get(row["query_idx"], [])) for row in chosen]
        shown = [[thumbnail(data, row["color_path"]), html.Raw(f'<span class="side">{pictures}</span>'), *cells]
                 for row, pictures, cells in zip(chosen, beside, shown)]  # fmt: skip
    parts.append(html.table(head, shown))
    if len(own) > MAX_PICTURES:
        parts.append(html.paragraph(f"{MAX_PICTURES} of the site's {len(own)} queries: failures, the worst, and an even sample.", "note"))
    return html.section("Queries", *parts)


class NearestFrames:
    def __init__(self, site):
        keyframes, frames = read_tum(site.path("map_frame", "keyframes")), Frames(site)
        path_at = {time_ns: row["color_path"] for time_ns, row in zip(frames.times_ns, frames.rows)}
        self.keyframes = keyframes.select([i for i, time_ns in enumerate(keyframes.times_ns) if int(time_ns) in path_at])
        self.color_paths = [path_at[int(time_ns)] for time_ns in self.keyframes.times_ns]
        self.views = self.keyframes.rotations()[:, :, 2]

    def near(self, position_m, quaternion, count):
        """color_path of the `count` keyframes whose place and direction of view are the nearest."""
        distances_m = np.linalg.norm(self.keyframes.positions_m - position_m, axis=1)
        cosines = self.views @ rotation_matrices(quaternion[None])[0][:, 2]
        apart = distances_m + np.degrees(np.arccos(np.clip(cosines, -1, 1))) / DEG_PER_M
        return [self.color_paths[i] for i in np.argsort(apart, kind="stable")[:count]]


def nearest_frames(site, count):
    """query_idx -> color_path of the nearest keyframes, of the located pictures; empty without a map."""
    path = site.made("localize", "queries")
    if not path or not site.made("map_frame", "keyframes"):
        return {}
    frames = NearestFrames(site)
    rows, times_ns, located = read_located(path)
    poses = {int(time_ns): i for i, time_ns in enumerate(located.times_ns)}
    found = {}
    for row, time_ns in zip(rows, times_ns):
        pose = poses.get(int(time_ns))
        if pose is not None:
            found[int(row["query_idx"])] = frames.near(located.positions_m[pose], located.quaternions[pose], count)
    return found
