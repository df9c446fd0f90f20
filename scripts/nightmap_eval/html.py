# SPDX-License-Identifier: Apache-2.0
"""Small pieces of HTML, and the page of them. Every function escapes the text it is given."""

import base64
import html
import re
from pathlib import Path

PAGE = Path(__file__).parent / "page"


class Raw(str):
    """Text that is already HTML."""


class Section(Raw):
    """A part of the page that opens; `title` is its name in the contents."""

    title = ""


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


def data_uri(data, media_type="image/png"):
    return f"data:{media_type};base64,{base64.b64encode(data).decode()}"


def image(data, alt, css_class="", media_type="image/png"):
    return Raw(f'<img class="{css_class}" alt="{html.escape(alt)}" src="{data_uri(data, media_type)}">')


def section(title, *parts, is_open=False):
    state = " open" if is_open else ""
    made = Section(f'<details class="section" id="{anchor(title)}"{state}><summary><h2>{escape(title)}</h2></summary>'
                   + "".join(map(escape, parts)) + "</details>")  # fmt: skip
    made.title = title
    return made


def anchor(title):
    return re.sub(r"[^a-z0-9]+", "-", title.lower()).strip("-")


def paragraph(text, css_class=""):
    return Raw(f'<p class="{css_class}">{escape(text)}</p>')


def bullets(items):
    return Raw('<ul class="plain">' + "".join(f"<li>{escape(item)}</li>" for item in items) + "</ul>")


def folded(title, content):
    return Raw(f"<details><summary>{escape(title)}</summary>{escape(content)}</details>")


def preformatted(text):
    return Raw(f"<pre>{escape(text)}</pre>")


def script(*names):
    """Scripts of files beside the page's, in a scope of their own; nothing in them depends on the site."""
    text = "\n".join((PAGE / name).read_text(encoding="utf-8") for name in names)
    return Raw(f"<script>(() => {{\n{text}\n}})();</script>")


def page(title, first, sections):
    """The whole page: `first` is the screen that it opens with."""
    links = "".join(f'<a href="#{anchor(part.title)}">{escape(part.title)}</a>' for part in sections)
    return (
        '<!doctype html>\n<html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>{escape(title)}</title><style>{(PAGE / 'page.css').read_text(encoding='utf-8')}</style></head><body>"
        f'<nav aria-label="Sections">{links}</nav>\n<main>\n{escape(first)}\n'
        + "\n".join(map(escape, sections))
        + f"\n</main>{script('page.js')}</body></html>\n"
    )
