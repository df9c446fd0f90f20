# SPDX-License-Identifier: Apache-2.0
"""The census on the page."""
import json

from nightmap_eval import html


def sections(site, _metrics):
    census = json.loads(site.path("census", "census").read_text(encoding="utf-8"))
    return [html.section("Census", html.paragraph(f"{census['num_keyframes']} keyframes of {census['num_frames']} frames"))]
