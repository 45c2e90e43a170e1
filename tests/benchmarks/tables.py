"""Markdown tables, and files of which only marked parts are written."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from pathlib import Path


def table(header: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A Markdown table that is legible as text too."""
    lines = [list(header), *(list(row) for row in rows)]
    widths = [max(len(line[column]) for line in lines) for column in range(len(header))]
    texts = [
        "| " + " | ".join(cell.ljust(width) for cell, width in zip(line, widths, strict=True)) + " |" for line in lines
    ]
    texts.insert(1, "|" + "|".join("-" * (width + 2) for width in widths) + "|")
    return "\n".join(texts) + "\n"


def milliseconds(seconds: float) -> str:
    """Three digits, or nothing where nothing was measured."""
    return number(1e3 * seconds)


def number(value: float) -> str:
    """Three digits without an exponent, or nothing."""
    if math.isnan(value):
        return ""
    return f"{value:.3g}" if 0.001 <= abs(value) < 1000.0 else f"{value:.0f}"


def write_part(path: Path, name: str, text: str) -> None:
    """Replace the part between the marks of `name` in a file; all else in it is written by hand and kept.

    Raises ValueError where the file does not have both marks.
    """
    begin, end = f"<!-- {name}: written by the script -->\n", f"<!-- {name}: end -->"
    before, found_begin, rest = path.read_text().partition(begin)
    _, found_end, after = rest.partition(end)
    if not (found_begin and found_end):
        raise ValueError(f"{path} has no part '{name}'")
    path.write_text(f"{before}{begin}\n{text}\n{end}{after}")
