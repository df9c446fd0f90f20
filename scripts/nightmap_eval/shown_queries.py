# SPDX-License-Identifier: Apache-2.0
"""The queries of a site that the report shows, and their pictures."""

from nightmap_eval.artifacts import read_csv, to_ints
from nightmap_eval.pictures import jpeg, open_picture

THUMBNAIL_PX = (300, 200)


def query_rows(site, metrics):
    """One dictionary per query, with its errors if known; None when localize did not run."""
    path, errors = site.made("localize", "queries"), {row["query_idx"]: row for row in metrics.get("queries", {}).get("rows", [])}
    if not path:
        return list(errors.values()) or None
    rows = read_csv(path, ("query_idx", "color_path", "status", "reason"))
    return [row | {"query_idx": int(idx)} | errors.get(int(idx), {}) for row, idx in zip(rows, to_ints(rows, "query_idx", path))]


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
