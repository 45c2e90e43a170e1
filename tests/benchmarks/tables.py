"""Where benchmarks read and write, and their tables."""

from __future__ import annotations

import csv
import math
from collections.abc import Iterable, Sequence
from pathlib import Path

HERE = Path(__file__).parent
ROOT = HERE.parents[1]


def table(header: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A Markdown table."""
    return "".join(f"| {' | '.join(line)} |\n" for line in (header, ["---"] * len(header), *rows))


def number(value: float) -> str:
    """Three digits without an exponent, or nothing where nothing was measured."""
    if math.isnan(value):
        return ""
    return f"{value:.3g}" if 0.001 <= abs(value) < 1000.0 else f"{value:.0f}"


def write_csv(path: Path, header: Sequence[str], rows: Iterable[Sequence[str]], about: str = "") -> None:
    """Write a table; a line about it comes first, as a comment."""
    with path.open("w", encoding="utf-8", newline="") as file:
        if about:
            file.write(f"# {about}\n")
        csv.writer(file, lineterminator="\n").writerows([header, *rows])
