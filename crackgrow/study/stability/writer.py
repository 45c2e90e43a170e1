"""The files of a study of extremes."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from crackgrow.results.atomic import write_text
from crackgrow.study.stability.picture import draw
from crackgrow.study.stability.table import csv_text, markdown_text
from crackgrow.study.stability.trial import Row


def write_stability(folder: Path, rows: Sequence[Row]) -> None:
    """Write stability.csv, stability.md and stability.png into a folder, made where it is missing.

    Raises OutputError.
    """
    write_text(folder / "stability.csv", csv_text(rows))
    write_text(folder / "stability.md", markdown_text(rows))
    draw(folder / "stability.png", rows)
