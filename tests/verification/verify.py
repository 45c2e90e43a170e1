"""The verification table: every row computed, printed, written and judged. Exit code 1 if a row fails.

python -m tests.verification.verify [--out DIR] [--only SUBJECT ...] [--jobs N] [--no-pictures]
"""

from __future__ import annotations

import argparse
import csv
import importlib
import io
import os
import sys
import time
from collections.abc import Iterable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict
from pathlib import Path

from tests.verification.row import Outcome, Row, evaluate

SUBJECTS = (
    "interface",
    "block",
    "closed_crack",
    "closed_kink",
    "history",
    "wide_plate",
    "open_crack",
    "t_stress",
    "interacting",
    "branched",
    "convergence",
    "patch",
    "path",
    "confined",
    "automatic_cells",
)
"""Modules of tests.verification.rows, in the table's order; a solved case is kept within its subject."""

LONGEST_FIRST = ("automatic_cells", "confined", "wide_plate", "convergence", "open_crack", "path", "history", "block")
HEADER = ("case", "quantity", "reference", "its kind", "value", "error", "tolerance", "pass")
FAILED = 1


def main(argv: Sequence[str] | None = None) -> int:
    """Compute and write the table; returns the exit code."""
    arguments = _parser().parse_args(argv)
    started = time.perf_counter()
    subjects = [s for s in SUBJECTS if not arguments.only or s in arguments.only]
    first = [s for s in LONGEST_FIRST if s in subjects]
    order = [*first, *(s for s in subjects if s not in first)]
    arguments.out.mkdir(parents=True, exist_ok=True)
    with ProcessPoolExecutor(arguments.jobs) as pool:
        pending = {subject: pool.submit(outcomes_of, subject) for subject in order}
        drawn = None if arguments.no_pictures else pool.submit(draw, arguments.out)
        outcomes = [outcome for subject in subjects for outcome in pending[subject].result()]
        if drawn is not None:
            drawn.result()
    code = report(outcomes, arguments.out)
    print(f"{len(outcomes)} rows in {time.perf_counter() - started:.0f} s, {arguments.out}/table.md")
    return code


def outcomes_of(subject: str) -> list[Outcome]:
    """All rows of a subject, computed."""
    rows: list[Row] = importlib.import_module(f"tests.verification.rows.{subject}").ROWS
    return [evaluate(row) for row in rows]


def draw(folder: Path) -> None:
    """Draw the picture."""
    from tests.verification.pictures import draw_confined_wings  # only now: it loads matplotlib

    draw_confined_wings(folder / "confined_wings.png")


def report(outcomes: Sequence[Outcome], folder: Path) -> int:
    """Print and write the table; 1 if a row failed, else 0."""
    table = markdown(outcomes)
    (folder / "table.md").write_text(table, encoding="utf-8")
    (folder / "table.csv").write_text(comma_separated(outcomes), encoding="utf-8")
    print(table)
    for outcome in outcomes:
        if outcome.failed:
            print(f"NO: {outcome.case}, {outcome.quantity}: {outcome.failure or f'source: {outcome.source}'}")
        if outcome.within and outcome.known:
            print(f"{outcome.case}, {outcome.quantity}: passes by now, take its `known` away")
    return FAILED if any(outcome.failed for outcome in outcomes) else 0


def markdown(outcomes: Iterable[Outcome]) -> str:
    """The table for reading; why a known row is missed stands below it."""
    lines = ["| " + " | ".join(HEADER) + " |", "|" + "---|" * len(HEADER)]
    notes: dict[str, int] = {}
    for outcome in outcomes:
        verdict = outcome.verdict
        if not outcome.within and not outcome.failed:
            verdict = f"missed ({notes.setdefault(outcome.known, len(notes) + 1)})"
        lines.append("| " + " | ".join([*_cells(outcome), verdict]) + " |")
    lines += ["", *(f"({number}) {note}." for note, number in notes.items())]
    return "\n".join(lines).rstrip() + "\n"


def comma_separated(outcomes: Iterable[Outcome]) -> str:
    """The table for programs: all that is known of a row."""
    file = io.StringIO()
    writer = csv.writer(file, lineterminator="\n")
    columns = (
        "case", "quantity", "reference", "kind", "value", "error", "error_is", "tolerance", "pass", "source", "known",
        "failure", "seconds",
    )  # fmt: skip
    writer.writerow(columns)
    for outcome in outcomes:
        fields = {**asdict(outcome), "pass": outcome.verdict, "seconds": f"{outcome.seconds:.2f}"}
        writer.writerow([fields[column] for column in columns])
    return file.getvalue()


def _cells(outcome: Outcome) -> list[str]:
    bound = {"at least": ">= ", "at most": "<= "}.get(outcome.error_is, "")
    if outcome.error_is == "at most" and outcome.reference == 0.0:  # the value is an error itself
        return [
            outcome.case, outcome.quantity, f"0 ({outcome.source})", outcome.kind, _size(outcome.value),
            _size(outcome.value), _size(outcome.tolerance),
        ]  # fmt: skip
    relative = outcome.error_is == "relative"
    return [
        outcome.case, outcome.quantity, f"{bound}{outcome.reference:.6g} ({outcome.source})", outcome.kind,
        f"{outcome.value:.6g}", _percent(outcome.error) if relative else f"{outcome.error:.3g}",
        _percent(outcome.tolerance) if relative else f"{outcome.tolerance:.3g}",
    ]  # fmt: skip


def _percent(value: float) -> str:
    return f"{100.0 * value:.2g} %"


def _size(value: float) -> str:
    return f"{value:.2g}"


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="verify", description="Compute the verification table.")
    parser.add_argument("--out", type=Path, default=Path("outputs/verification"), metavar="DIR")
    parser.add_argument("--only", nargs="+", choices=SUBJECTS, metavar="SUBJECT", help=", ".join(SUBJECTS))
    parser.add_argument("--jobs", type=int, default=min(2, os.cpu_count() or 1), metavar="N", help="processes")
    parser.add_argument("--no-pictures", action="store_true", help="the table alone")
    return parser


if __name__ == "__main__":
    sys.exit(main())
