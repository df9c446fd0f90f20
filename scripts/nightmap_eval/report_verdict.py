# SPDX-License-Identifier: Apache-2.0
"""The verdict on the map, or before there is one on the recording, for the page."""

from nightmap_eval import html
from nightmap_eval.verdict.verdict import FORM, GOOD
from nightmap_site.checked_reading import read_object


def verdict_parts(site):
    """The beginning of the page's first line, and sections, of verdict.json of the map, else that of the recording; nothing without both."""
    path = site.made("verdict", "verdict") or site.made("check", "verdict")
    if not path:
        return "", []
    verdict = read_object(path, FORM)
    failed = [item for item in verdict["checks"] if item["verdict"] != GOOD]
    advice = [html.paragraph(f"{item['name']}: {item['advice']}", "failed") for item in failed]
    rows = [(item["name"], item["verdict"], item.get("value", "not known"), item["unit"], item["limit"], item["reason"]) for item in verdict["checks"]]
    table = html.table(("check", "verdict", "value", "unit", "good", "reason of the limit"), rows)
    return f"Verdict: {verdict['verdict']}. ", [html.section(f"Verdict: {verdict['verdict']}", *advice, table)]
