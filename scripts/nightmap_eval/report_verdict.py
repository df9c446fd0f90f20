# SPDX-License-Identifier: Apache-2.0
"""The verdict on the map, or before there is one on the recording, for the page."""

from nightmap_eval import html
from nightmap_eval.verdict.verdict import FORM, GOOD
from nightmap_site.checked_reading import read_object


def read_verdict(site):
    """verdict.json of the map, else that of the recording, else None."""
    path = site.made("verdict", "verdict") or site.made("check", "verdict")
    return read_object(path, FORM) if path else None


def verdict_text(site):
    """The beginning of the page's first line."""
    verdict = read_verdict(site)
    return f"Verdict: {verdict['verdict']}. " if verdict else ""


def verdict_section(site):
    verdict = read_verdict(site)
    if verdict is None:
        return None
    failed = [item for item in verdict["checks"] if item["verdict"] != GOOD]
    advice = [html.paragraph(f"{item['name']}: {item['advice']}", "failed") for item in failed]
    rows = [(item["name"], item["verdict"], item.get("value", "not known"), item["unit"], item["limit"], item["reason"]) for item in verdict["checks"]]
    table = html.table(("check", "verdict", "value", "unit", "good", "reason of the limit"), rows)
    return html.section(f"Verdict: {verdict['verdict']}", html.Raw("".join([*advice, table])))
