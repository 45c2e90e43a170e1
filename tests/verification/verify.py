"""The verification table: every row computed and written, the worst of each quantity printed. Exit code 1: a row fails.

python -m tests.verification.verify [--out DIR] [--only SUBJECT ...] [--slow] [--jobs N]
"""

from __future__ import annotations

import argparse
import csv
import importlib
import os
import sys
import time
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

from tests.verification.row import Outcome, Row, evaluate

SUBJECTS = ("tips", "faces", "fields", "limits", "paths", "specimens")
"""Modules of tests.verification.rows; a solved case is kept within its subject."""

COLUMNS = ("scene", "quantity", "value", "reference", "measure", "error", "tolerance", "pass", "source", "failure",
           "seconds")  # fmt: skip


def rows_of(subject: str) -> list[Row]:
    """The rows of a subject."""
    rows: list[Row] = importlib.import_module(f"tests.verification.rows.{subject}").ROWS
    return rows


def outcomes_of(subject: str, slow: bool) -> list[Outcome]:
    """The rows of a subject, computed; those that take minutes where `slow` ones are asked for."""
    return [evaluate(row) for row in rows_of(subject) if slow or not row.slow]


def write(outcomes: Sequence[Outcome], path: Path) -> None:
    """The whole table as CSV."""
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        for found in outcomes:
            row, judged = found.row, "yes" if found.within else "NO"
            writer.writerow([row.scene, row.quantity, found.value, row.reference, row.measure, found.error,
                             row.tolerance, judged, row.source, found.failure, f"{found.seconds:.2f}"])  # fmt: skip


def worst(outcomes: Sequence[Outcome]) -> str:
    """Of each quantity how many rows there are, and the one that comes closest to its tolerance."""
    lines = ["| quantity | rows | worst | value | reference | error | tolerance |", "|" + "---|" * 7]
    for quantity in dict.fromkeys(found.row.quantity for found in outcomes):
        mine = [found for found in outcomes if found.row.quantity == quantity]
        found = max(mine, key=lambda outcome: outcome.share)
        numbers = (found.value, found.row.reference, found.error, found.row.tolerance)
        cells = [quantity, str(len(mine)), found.row.scene, *(f"{number:.4g}" for number in numbers)]
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines)


def main(argv: Sequence[str] | None = None) -> int:
    """Compute, write and print; returns the exit code."""
    parser = argparse.ArgumentParser(prog="verify", description="Compute the verification table.")
    parser.add_argument("--out", type=Path, default=Path("outputs/verification"), metavar="DIR")
    parser.add_argument("--only", nargs="+", choices=SUBJECTS, default=list(SUBJECTS), metavar="SUBJECT")
    parser.add_argument("--slow", action="store_true", help="with the rows that take a minute or more each")
    parser.add_argument("--jobs", type=int, default=min(2, os.cpu_count() or 1), metavar="N", help="processes")
    asked = parser.parse_args(argv)
    started = time.perf_counter()
    asked.out.mkdir(parents=True, exist_ok=True)
    with ProcessPoolExecutor(asked.jobs) as pool:
        subjects = pool.map(outcomes_of, asked.only, [asked.slow] * len(asked.only))
        outcomes = [found for each in subjects for found in each]
    write(outcomes, asked.out / "table.csv")
    print(worst(outcomes))
    missed = [found for found in outcomes if not found.within]
    for found in missed:
        print(f"NO: {found.row.scene}, {found.row.quantity}: {found.failure or found.row.source}")
    print(f"{len(outcomes)} rows in {time.perf_counter() - started:.0f} s: {asked.out}/table.csv")
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
