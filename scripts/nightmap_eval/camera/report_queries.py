# SPDX-License-Identifier: Apache-2.0
"""Section of the report on located queries, pictures or laser scans."""

from nightmap_eval import html
from nightmap_eval.artifacts import read_csv, to_ints
from nightmap_eval.camera.nearest_frames import nearest_frames
from nightmap_eval.pictures import jpeg, open_picture
from nightmap_eval.query_errors import PROTOCOLS, RECALL_THRESHOLDS, WRONG_CM
from nightmap_site.query_results import asked_names

MAX_PICTURES = 12
NUM_NEAREST = 2
THUMBNAIL_PX = (300, 200)


def query_rows(site, metrics):
    """One dictionary per query, with its errors if known; None when localize did not run."""
    if "rows" in metrics.get("queries", {}):
        return metrics["queries"]["rows"]
    path = site.made("localize", "queries")
    if not path:
        return None
    rows = read_csv(path, ("query_idx", "color_path", "status", "reason"))
    return [row | {"query_idx": int(idx)} for row, idx in zip(rows, to_ints(rows, "query_idx", path))]


def choose(rows, count):
    """At most `count` rows: up to half failures, the worst located query, and an even sample of the rest."""
    failed = [row for row in rows if row["status"] != "located"][: count // 2]
    located = [row for row in rows if row["status"] == "located"]
    worst = max(located, key=lambda row: row.get("translation_error_cm", -1.0), default=None)
    others = [row for row in located if row is not worst]
    room = min(len(others), count - len(failed) - (worst is not None))
    spread = [others[i * len(others) // room] for i in range(room)]
    chosen = failed + spread + ([worst] if worst is not None else [])
    return sorted(chosen, key=lambda row: row["query_idx"])


def thumbnail(data, color_path):
    def small():
        with open_picture(data / color_path) as picture:
            picture = picture.convert("RGB")
        picture.thumbnail(THUMBNAIL_PX)
        return picture

    return "" if data is None else jpeg(small, color_path, "thumbnail")


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
