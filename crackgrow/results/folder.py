"""What a result folder holds, as far as a report needs it."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Collection
from dataclasses import dataclass
from itertools import compress
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crackgrow.arrays import Floats
from crackgrow.case import load_case
from crackgrow.case.model import Case
from crackgrow.errors import CrackgrowError
from crackgrow.results import tables

COLUMNS = {
    "steps.csv": tables.STEPS,
    "tips.csv": tables.TIPS,
    "contact.csv": tables.CONTACT,
    "paths.csv": tables.PATHS,
    "events.csv": tables.EVENTS,
}
# Columns that runs of earlier versions lack.
LATER = {"tips.csv": ("K_I_spread", "K_II_spread", "cell_size"), "contact.csv": ("mean_opening", "mean_slip")}
SUMMARY_KEYS = ("case", "title", "status", "stop_reason", "n_solves", "version", "git_commit", "git_modified", "n_dofs",
                "wall_seconds", "peak_memory_mb", "error_estimate", "warnings")  # fmt: skip


class FolderError(CrackgrowError):
    """A folder that holds no results, or not those that are wanted; the message says what is missing."""

    exit_code = 3


@dataclass(frozen=True, slots=True, eq=False)
class TextTable:
    """A CSV file: its columns by name, as text."""

    path: Path
    columns: dict[str, list[str]]

    def __len__(self) -> int:
        return len(next(iter(self.columns.values())))

    def words(self, name: str) -> list[str]:
        """A column as it stands."""
        return self.columns[name]

    def numbers(self, name: str) -> Floats:
        """A column (n,) as numbers; nan where it says so. Raises FolderError where it has other words."""
        try:
            return np.array(self.columns[name], dtype=float)
        except ValueError as error:
            raise damaged(self.path, f"{name}: {error}") from error

    def steps(self) -> NDArray[np.int64]:
        """The column `step` (n,). Raises FolderError where it has other words."""
        try:
            return np.array(self.columns["step"], dtype=np.int64)
        except ValueError as error:
            raise damaged(self.path, f"step: {error}") from error

    def of_steps(self, steps: Collection[int]) -> TextTable:
        """The rows of these steps."""
        kept = np.isin(self.steps(), list(steps)).tolist()
        return TextTable(self.path, {name: list(compress(words, kept)) for name, words in self.columns.items()})


@dataclass(frozen=True, slots=True, eq=False)
class RunFolder:
    """A run as its files tell it; m, Pa."""

    path: Path
    summary: dict[str, Any]
    case: Case
    case_text: str
    steps: TextTable
    tips: TextTable
    contact: TextTable
    paths: TextTable
    events: TextTable
    history: TextTable | None = None  # where the case names points

    @property
    def solved(self) -> list[int]:
        """Numbers of the steps that were solved, in order."""
        return [int(step) for step in self.steps.steps()]

    @property
    def places(self) -> list[int]:
        """The steps that can be shown: those solved, and one more where the last advance was not solved any more."""
        latest = int(self.paths.steps().max(initial=0))
        solved = self.solved
        return [*solved, latest] if not solved or latest > solved[-1] else solved


def read_run(folder: Path) -> RunFolder:
    """Read the files of a run.

    A run that was killed while it wrote a step may have left rows of it in some tables: they are left out.

    Raises FolderError where one is missing or no longer whole, CaseError where case.yaml is not of this version.
    """
    summary = _summary(folder)
    case_text = _text(folder, "case.yaml")
    steps, paths, events = (_table(folder, name) for name in ("steps.csv", "paths.csv", "events.csv"))
    solved = steps.steps().tolist()
    tips, contact = (_table(folder, name).of_steps(solved) for name in ("tips.csv", "contact.csv"))
    case = load_case(folder / "case.yaml")
    history = None
    if case.output.points and (folder / "history.csv").is_file():
        history = _read_table(folder, "history.csv").of_steps(solved)
    return RunFolder(folder, summary, case, case_text, steps, tips, contact, paths, events, history)


def damaged(path: Path, what: str) -> FolderError:
    """The error of a file that can't be read as what it should be."""
    return FolderError(f"{path} is damaged, or of another version: {what}; run the case again")


def _summary(folder: Path) -> dict[str, Any]:
    path, text = folder / "summary.json", _text(folder, "summary.json")
    try:
        summary = json.loads(text)
    except ValueError as error:
        raise damaged(path, str(error)) from error
    if not isinstance(summary, dict):
        raise damaged(path, "it is no mapping")
    missing = [key for key in SUMMARY_KEYS if key not in summary]
    if missing:
        raise damaged(path, f"it has no {', '.join(missing)}")
    return summary


def _text(folder: Path, name: str) -> str:
    try:
        return (folder / name).read_text(encoding="utf-8")
    except UnicodeDecodeError as error:
        raise damaged(folder / name, str(error)) from error
    except OSError as error:
        raise FolderError(
            f"{folder} is not a folder of results: {name} cannot be read ({error.strerror}); give the folder that "
            "`crackgrow run` wrote, such as outputs/compression30"
        ) from error


def _table(folder: Path, name: str) -> TextTable:
    """A table whose columns are the same in every run."""
    table = _read_table(folder, name)
    header = list(table.columns)
    earlier = [column for column in COLUMNS[name] if column not in LATER.get(name, ())]
    if header not in (list(COLUMNS[name]), earlier):
        raise damaged(table.path, f"its columns are {', '.join(header) or 'none'}, not {', '.join(COLUMNS[name])}")
    return table


def _read_table(folder: Path, name: str) -> TextTable:
    path = folder / name
    try:
        rows = list(csv.reader(io.StringIO(_text(folder, name), newline="")))
    except csv.Error as error:
        raise damaged(path, str(error)) from error
    header = rows.pop(0) if rows else []
    for number, row in enumerate(rows, 1):
        if len(row) != len(header):
            raise damaged(path, f"row {number} has {len(row)} values, the header has {len(header)}")
    return TextTable(path, {column: [row[index] for row in rows] for index, column in enumerate(header)})
