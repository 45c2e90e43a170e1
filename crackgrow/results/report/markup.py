"""HTML and SVG as text: whatever comes from a case is escaped on the way in."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from html import escape

SHORT = 12  # characters of a cell that is not broken


class Markup(str):
    """Text that is markup already."""

    __slots__ = ()


def text(value: object) -> Markup:
    """A value as markup: escaped, unless it is markup."""
    return value if isinstance(value, Markup) else Markup(escape(str(value), quote=True))


def tag(name: str, *content: object, **attributes: object) -> Markup:
    """An element; `_` in the name of an attribute is a dash, at the end of it nothing; None leaves it out."""
    words = [f'{key.rstrip("_").replace("_", "-")}="{text(value)}"' for key, value in attributes.items()
             if value is not None]  # fmt: skip
    return Markup(f"<{' '.join([name, *words])}>{join(content)}</{name}>")


def join(parts: Iterable[object], between: str = "") -> Markup:
    """Parts one after another."""
    return Markup(between.join(text(part) for part in parts))


def table(caption: str, header: Sequence[str], rows: Iterable[Sequence[object]]) -> Markup:
    """A table in a box of its own that scrolls where it is too wide."""
    head = tag("tr", *(tag("th", name, scope="col") for name in header))
    cells = ((tag("td", cell, class_="short" if len(str(cell)) <= SHORT else None) for cell in row) for row in rows)
    body = [tag("tr", *row) for row in cells]
    whole = tag("table", tag("caption", caption), tag("thead", head), tag("tbody", *body))
    return tag("div", whole, class_="scroll", tabindex="0", role="region", aria_label=caption)


def json_script(data: object) -> Markup:
    """Data for the scripts of the page, under the id `data`; no text in it can end the element."""
    content = json.dumps(data, ensure_ascii=False, allow_nan=False, separators=(",", ":")).replace("<", "\\u003c")
    return Markup(f'<script type="application/json" id="data">{content}</script>')
