"""The verification table: a row is a quantity that the program computes beside what it should be.

As a plugin of pytest (`-p tests.verification.table`) all rows that were computed are written as CSV, and of each
quantity the worst is printed.
"""

from __future__ import annotations

import csv
import json
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from typing import Any, Literal

import pytest

TABLE = Path("outputs/verification/table.csv")
Measure = Literal["relative", "absolute", "at most", "at least"]
"""How the error is taken: (value - reference)/reference, value - reference, or how far the bound is passed."""

Record = Callable[[str, object], None]
"""Pytest's `record_property`."""


@dataclass(frozen=True, slots=True)
class Row:
    """What is compared, with what, and how far apart the two may be; a reference of zero: the value is an error."""

    scene: str  # the case file or what stands in for one, and what is set there
    quantity: str  # with its unit in brackets
    value: Callable[[], float]  # solves, or finds solved, what it needs
    reference: float
    source: str  # file, paper or formula
    tolerance: float
    measure: Measure = "relative"
    slow: bool = False  # takes a minute or more

    def error(self, value: float) -> float:
        """Signed error of a value in the row's measure."""
        difference = value - self.reference
        match self.measure:
            case "relative":
                return difference / abs(self.reference) if self.reference else difference
            case "absolute":
                return difference
            case "at most":
                return max(difference, 0.0)
            case "at least":
                return min(difference, 0.0)

    def check(self, record: Record) -> None:
        """Compute the row, record it for the table, and fail where its error is beyond the tolerance."""
        value = float(self.value())
        error = self.error(value)
        told = {
            "scene": self.scene,
            "quantity": self.quantity,
            "value": value,
            "reference": self.reference,
            "measure": self.measure,
            "error": error,
            "tolerance": self.tolerance,
            "source": self.source,
        }
        record("row", json.dumps(told))  # processes hand on texts, but no numbers of NumPy
        assert abs(error) <= self.tolerance, f"{value} in place of {self.reference}: {self.source}"


def parameters(*groups: Iterable[Row]) -> list[object]:
    """Rows as the parameters of a test."""
    return [
        pytest.param(row, id=f"{row.scene}, {row.quantity}", marks=[pytest.mark.slow] if row.slow else [])
        for row in chain(*groups)
    ]


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """Write and print what the tests of rows have recorded."""
    rows = []
    for kind in ("passed", "failed"):
        for report in terminalreporter.getreports(kind):
            recorded = dict(getattr(report, "user_properties", ()))
            if "row" in recorded:
                judged = {"pass": "yes" if report.passed else "NO", "seconds": f"{report.duration:.2f}"}
                rows.append(json.loads(recorded["row"]) | judged)
    if not rows:
        return
    TABLE.parent.mkdir(parents=True, exist_ok=True)
    with TABLE.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, list(rows[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    terminalreporter.write_line(f"{worst(rows)}\n{len(rows)} rows: {TABLE}")


def worst(rows: list[dict[str, Any]]) -> str:
    """Of each quantity how many rows there are, and the one that comes closest to its tolerance."""
    lines = ["| quantity | rows | worst | value | reference | error | tolerance |", "|" + "---|" * 7]
    for quantity in dict.fromkeys(row["quantity"] for row in rows):
        mine = [row for row in rows if row["quantity"] == quantity]
        row = max(mine, key=share)
        numbers = [f"{row[name]:.4g}" for name in ("value", "reference", "error", "tolerance")]
        lines.append(f"| {' | '.join([quantity, str(len(mine)), row['scene'], *numbers])} |")
    return "\n".join(lines)


def share(row: dict[str, Any]) -> float:
    """The error over its tolerance; for bounds that may not be passed 0 or infinite."""
    if row["tolerance"]:
        return abs(row["error"]) / row["tolerance"]
    return 0.0 if row["pass"] == "yes" else float("inf")
