# SPDX-License-Identifier: Apache-2.0
"""Section of the report on loop closures: how many were accepted or rejected, why, and each of them."""

from collections import Counter

from nightmap_eval import html
from nightmap_eval.artifacts import read_csv

MAX_ROWS = 200


def loop_section(site):
    path = site.made("pose_graph", "loops_csv")
    if not path:
        return html.section("Loop closures", html.paragraph("The pose_graph stage did not run.", "note"))
    rows = read_csv(path, ("status", "reason"))
    if not rows:
        return html.section("Loop closures", html.paragraph("No loop was proposed.", "note"))
    counts = Counter((row["status"], row["reason"]) for row in rows)
    parts = [html.table(("status", "reason", "loops"), [(*key, counts[key]) for key in sorted(counts)])]
    shown = html.table(tuple(rows[0]), [list(row.values()) for row in rows[:MAX_ROWS]])
    title = f"Each loop (first {MAX_ROWS} of {len(rows)})" if len(rows) > MAX_ROWS else "Each loop"
    parts.append(html.folded(title, shown))
    return html.section("Loop closures", *parts)
