# SPDX-License-Identifier: Apache-2.0
"""Small pieces of HTML. Every function escapes the text it is given."""

import base64
import html

STYLE = """
:root { color-scheme: light dark; --line: #d8d8d8; --soft: #f5f6f8; --text: #1d2126;
  --dim: #5d6671; --page: #fff; }
@media (prefers-color-scheme: dark) {
  :root { --line: #3a4048; --soft: #20252b; --text: #e4e7ea; --dim: #9aa4af; --page: #15181c; }
}
body { font: 15px/1.5 system-ui, sans-serif; color: var(--text); background: var(--page);
       max-width: 62rem; margin: 2rem auto; padding: 0 1rem; }
h1 { font-size: 1.6rem; margin: 0; } h2 { font-size: 1.15rem; margin: 2.2rem 0 .6rem; }
p.lead { font-size: 1.05rem; color: var(--dim); margin: .4rem 0 1.2rem; }
table { border-collapse: collapse; font-size: .9rem; margin: .5rem 0; }
th, td { text-align: left; padding: .3rem .8rem .3rem 0; border-bottom: 1px solid var(--line);
         vertical-align: top; font-variant-numeric: tabular-nums; }
th { color: var(--dim); font-weight: 600; } td.number, th.number { text-align: right; }
img { max-width: 100%; height: auto;
      background: #fff; border: 1px solid var(--line); border-radius: 4px; }
img.thumbnail { width: 150px; } .side { white-space: nowrap; } .side img { width: 120px; } .wide { overflow-x: auto; }
details { margin: .35rem 0; } summary { cursor: pointer; }
pre { background: var(--soft); padding: .7rem; overflow-x: auto;
      font-size: .82rem; border-radius: 4px; }
.failed { color: #c0392b; } .note { color: var(--dim); }
"""


class Raw(str):
    """Text that is already HTML."""


def escape(value):
    return value if isinstance(value, Raw) else Raw(html.escape(str(value)))


def number(value, digits=3):
    """A float in few digits, an integer in full, a range of a pair; "n/a" for None."""
    if value is None:
        return "n/a"
    if isinstance(value, tuple):
        return " to ".join(map(number, value))
    if isinstance(value, float):
        return f"{value:.{digits}g}" if abs(value) < 10**digits else f"{value:.0f}"
    return str(value)


def table(header, rows):
    """Aligns cells with numbers to the right."""
    head = "".join(f"<th>{escape(name)}</th>" for name in header)
    body = "".join("<tr>" + "".join(map(_cell, row)) + "</tr>" for row in rows)
    return Raw(f'<div class="wide"><table><tr>{head}</tr>{body}</table></div>')


def _cell(value):
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        return f'<td class="number">{number(value)}</td>'
    return f"<td>{escape(value)}</td>"


def image(data, alt, css_class="", media_type="image/png"):
    encoded = base64.b64encode(data).decode()
    source = f"data:{media_type};base64,{encoded}"
    return Raw(f'<img class="{css_class}" alt="{html.escape(alt)}" src="{source}">')


def section(title, *parts):
    return Raw(f"<section><h2>{escape(title)}</h2>" + "".join(map(escape, parts)) + "</section>")


def paragraph(text, css_class=""):
    return Raw(f'<p class="{css_class}">{escape(text)}</p>')


def folded(title, content):
    return Raw(f"<details><summary>{escape(title)}</summary>{escape(content)}</details>")


def preformatted(text):
    return Raw(f"<pre>{escape(text)}</pre>")


def page(title, lead, sections):
    return (
        '<!doctype html>\n<html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>{escape(title)}</title><style>{STYLE}</style></head><body>"
        f'<h1>{escape(title)}</h1><p class="lead">{escape(lead)}</p>'
        + "\n".join(sections)
        + "</body></html>\n"
    )
