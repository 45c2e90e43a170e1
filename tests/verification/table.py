"""The verification table, as a plugin of pytest (`-p tests.verification.table`): all rows that were computed are
written as CSV, and of each quantity the worst is printed."""

from __future__ import annotations

import csv
import json
from pathlib import Path
from typing import Any

import pytest

TABLE = Path("outputs/verification/table.csv")


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
