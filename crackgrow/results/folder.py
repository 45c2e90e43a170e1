"""What a result folder holds, as far as a report needs it."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crackgrow.case import load_case
from crackgrow.case.model import Case
from crackgrow.errors import CrackgrowError

Floats = NDArray[np.float64]


class FolderError(CrackgrowError):
    """A folder that holds no results, or not those that are wanted; the message says what is missing."""

    exit_code = 3


@dataclass(frozen=True, slots=True, eq=False)
class TextTable:
    """A CSV file: its columns by name, as text."""

    columns: dict[str, list[str]]

    def __len__(self) -> int:
        return len(next(iter(self.columns.values())))

    def words(self, name: str) -> list[str]:
        """A column as it stands."""
        return self.columns[name]

    def numbers(self, name: str) -> Floats:
        """A column (n,) as numbers; nan where it says so."""
        return np.array(self.columns[name], dtype=float)

    def steps(self) -> NDArray[np.int64]:
        """The column `step` (n,)."""
        return np.array(self.columns["step"], dtype=np.int64)


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

    Raises FolderError where one is missing or no longer whole, CaseError where case.yaml is not of this version.
    """
    summary = json.loads(_text(folder, "summary.json"))
    case_text = _text(folder, "case.yaml")
    tables = [_table(folder, f"{name}.csv") for name in ("steps", "tips", "contact", "paths", "events")]
    return RunFolder(folder, summary, load_case(folder / "case.yaml"), case_text, *tables)


def _text(folder: Path, name: str) -> str:
    try:
        return (folder / name).read_text(encoding="utf-8")
    except OSError as error:
        raise FolderError(
            f"{folder} is not a folder of results: {name} cannot be read ({error.strerror}); give the folder that "
            "`crackgrow run` wrote, such as outputs/compression30"
        ) from error


def _table(folder: Path, name: str) -> TextTable:
    header, *rows = csv.reader(io.StringIO(_text(folder, name), newline=""))
    return TextTable({column: _column(rows, index) for index, column in enumerate(header)})


def _column(rows: Sequence[Sequence[str]], index: int) -> list[str]:
    return [row[index] for row in rows]
