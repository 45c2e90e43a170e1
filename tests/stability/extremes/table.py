"""Rows as CSV and as Markdown: a summary axis by axis, then every row."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from itertools import groupby
from typing import Final

from crackgrow.results import tables
from crackgrow.results.declarations import Column, File
from tests.stability.extremes.trial import Row, number

FILE: Final = File(
    "stability.csv",
    "a row for each scene that `make stability` has taken to an extreme; `stability.md` is the same for reading, "
    "`stability.png` draws it",
    (
        Column("axis", "", "what is taken to extremes"),
        Column("value", "", "its value"),
        Column("compared", "", "what is held against what"),
        Column("deviation", "", "how far the result is off"),
        Column("tolerance", "", "how far it may be off, relative"),
        Column("condition", "", "estimate of the condition number of the scaled stiffness"),
        Column("iterations", "", "iterations of the contact solver; -1 where nothing was solved"),
        Column("residual", "", "what equilibrium misses, relative"),
        Column("status", "", "`solved`, `warned` (of more than at the usual value), `refused` or `crashed`"),
        Column("reason", "", "why the scene was refused, or what the program warned of"),
        Column("seconds", "s", "wall time"),
        Column("verdict", "", "`yes`: within the tolerance; `said`: no good or refused, and the program says so; "
               "`NO`: neither"),
    ),
)  # fmt: skip
COLUMNS: Final = FILE.header

LONGEST_REASON = 160  # characters in Markdown; the CSV has all of it

Line = tuple[str, ...]


def csv_text(rows: Sequence[Row]) -> str:
    """All rows; numbers with all their digits, nothing where there is none."""
    return tables.csv_text(COLUMNS, ([getattr(row, name) for name in COLUMNS] for row in rows))


def markdown_text(rows: Sequence[Row]) -> str:
    """The summary and all rows."""
    head: Line = (
        "axis", "value", "held against", "deviation", "tolerance", "condition", "iterations", "residual", "status",
        "seconds", "verdict", "reason",
    )  # fmt: skip
    lines = [
        (
            row.axis, row.value, row.compared, number(row.deviation), number(row.tolerance), number(row.condition),
            str(row.iterations) if row.iterations >= 0 else "", number(row.residual), row.status,
            f"{row.seconds:.1f}", row.verdict, _shortened(row.reason),
        )
        for row in rows
    ]  # fmt: skip
    return f"{summary_text(rows)}\n{_table(head, lines)}"


def summary_text(rows: Sequence[Row]) -> str:
    """One line an axis: how far the results that are good are off, and how the others ended."""
    head: Line = (
        "axis", "values", "largest deviation where good", "tolerance", "largest condition", "largest residual",
        "good", "said no good", "NO",
    )  # fmt: skip
    lines = []
    for axis, group in groupby(rows, key=lambda row: row.axis):
        mine = list(group)
        good = [row for row in mine if row.verdict == "yes"]
        count = Counter(row.verdict for row in mine)
        values = list(dict.fromkeys(row.value for row in mine))
        lines.append(
            (
                axis,
                values[0] if len(values) == 1 else f"{values[0]} ... {values[-1]}",
                _largest([row.deviation for row in good]),
                _range([row.tolerance for row in mine]),
                _largest([row.condition for row in mine]),
                _largest([row.residual for row in mine]),
                str(count["yes"]),
                str(count["said"]),
                str(count["NO"]),
            )
        )
    return _table(head, lines)


def _table(head: Line, lines: Sequence[Line]) -> str:
    cells = [head, tuple("---" for _ in head), *lines]
    return "".join(f"| {' | '.join(cell.replace('|', '/') for cell in line)} |\n" for line in cells)


def _largest(values: Sequence[float]) -> str:
    found = [value for value in values if math.isfinite(value)]
    return number(max(found)) if found else ""


def _range(values: Sequence[float]) -> str:
    low, high = number(min(values)), number(max(values))
    return low if low == high else f"{low} ... {high}"


def _shortened(text: str) -> str:
    return text if len(text) <= LONGEST_REASON else f"{text[:LONGEST_REASON]}..."
