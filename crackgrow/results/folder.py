"""A run's folder: what its files are called, and the one place where they are read."""

from __future__ import annotations

import csv
import io
import json
import re
from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import compress, pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from crackgrow.arrays import Floats
from crackgrow.case import load_case
from crackgrow.case.model import Case
from crackgrow.errors import CrackgrowError
from crackgrow.results.declarations import RUN
from crackgrow.results.tables import RunTables, frame_of
from crackgrow.results.units import spans_text

if TYPE_CHECKING:
    import pandas as pd
    import pyvista

REPORT, SUMMARY, LOG, CASE, HISTORY = "report.html", "summary.json", "run.log", "case.yaml", "history.csv"
FRAME, FACES, CHECKPOINT = "frames/step_NNNN.vtu", "cracks/step_NNNN.vtp", "checkpoint/step_NNNN.npz"
PICTURE = "render/FIELD/step_NNNN.png"
OWN: Final = (*(file.name for file in RUN if not file.name.startswith("export/")), "render/FIELD/animation.mp4")
"""Names of all that a run writes, and of what is drawn of it; what is exported is the user's."""

OF_STEPS = ("tips.csv", "contact.csv", "reactions.csv", "interface_tips.csv", HISTORY)
"""Tables that may have rows of a step that a run was killed in: they count where steps.csv has the step."""

FINISHED: Final = ("completed", "arrested", "broke_through")
"""How a run ends that has done what it was asked."""

SUMMARY_KEYS = ("case", "title", "status", "stop_reason", "n_solves", "version", "git_commit", "git_modified", "n_dofs",
                "wall_seconds", "peak_memory_mb", "error_estimate", "warnings")  # fmt: skip


class FolderError(CrackgrowError):
    """A folder that holds no results, or not those that are wanted; the message says what is missing."""

    exit_code = 3


def series_names(case_name: str) -> tuple[str, str]:
    """Paths of the two time series, of the specimen and of its cracks."""
    return f"{case_name}.pvd", f"{case_name}_cracks.pvd"


def of_step(name: str, step: int) -> str:
    """Path of a step's file, relative to the run's folder, by its declared name."""
    return name.replace("NNNN", f"{step:04d}")


@dataclass(frozen=True, slots=True)
class OwnFile:
    """A file in a run's folder under a name that is the program's."""

    path: Path
    name: str  # as it is declared, such as "frames/step_NNNN.vtu"
    step: int  # -1 where it is not of one
    whole: bool  # else a killed run has left it half written


def own_files(folder: Path, case_name: str = "", names: Iterable[str] = OWN) -> Iterator[OwnFile]:
    """The files in a folder, and in those within, that bear declared names."""
    for name in names:
        within, _, last = name.rpartition("/")
        pattern = re.escape(last).replace("NNNN", r"(\d{4,})").replace("NAME", re.escape(case_name))
        for path in sorted(folder.glob(f"{within}/*".replace("FIELD", "*").removeprefix("/"))):
            half = re.fullmatch(r"\.(.+)\.tmp(\.\w+)", path.name)
            match = re.fullmatch(pattern, f"{half[1]}{half[2]}" if half else path.name)
            if match:
                yield OwnFile(path, name, int(match[1]) if match.groups() else -1, whole=half is None)


@dataclass(frozen=True, slots=True, eq=False)
class TextTable:
    """A CSV file: its columns by name, as text."""

    path: Path
    columns: dict[str, list[str]]

    def __len__(self) -> int:
        return len(next(iter(self.columns.values()), ()))

    def words(self, name: str) -> list[str]:
        """A column as it stands. Raises FolderError where there is none."""
        if name not in self.columns:
            there = ", ".join(self.columns) or "none"
            raise damaged(self.path, f"it has no column {name}; its columns are {there}")
        return self.columns[name]

    def numbers(self, name: str) -> Floats:
        """A column (n,) as numbers; nan where it says so. Raises FolderError where it has other words."""
        return self._of_kind(name, float)

    def steps(self) -> NDArray[np.int64]:
        """The column `step` (n,). Raises FolderError where it has other words."""
        return self._of_kind("step", np.int64)

    def _of_kind(self, name: str, kind: type) -> NDArray[Any]:
        try:
            return np.array(self.words(name), dtype=kind)
        except ValueError as error:
            raise damaged(self.path, f"{name}: {error}") from error

    def rows(self) -> list[dict[str, str]]:
        """The rows, each with its cells by name."""
        return [dict(zip(self.columns, row, strict=True)) for row in zip(*self.columns.values(), strict=True)]

    def where(self, kept: Sequence[bool]) -> TextTable:
        """The rows for which `kept` says so."""
        return TextTable(self.path, {name: list(compress(words, kept)) for name, words in self.columns.items()})

    def by(self, *names: str) -> dict[tuple[str, ...], TextTable]:
        """The rows by what they have in some columns, in the order in which that comes."""
        rows: dict[tuple[str, ...], list[int]] = {}
        for number, key in enumerate(zip(*map(self.words, names), strict=True)):
            rows.setdefault(key, []).append(number)
        columns = self.columns.items()
        return {
            key: TextTable(self.path, {c: [words[k] for k in some] for c, words in columns})
            for key, some in rows.items()
        }

    def of_steps(self, steps: Collection[int]) -> TextTable:
        """The rows of these steps."""
        return self.where(np.isin(self.steps(), list(steps)).tolist())


class RunFolder(RunTables):
    """A run as its files tell it; m, Pa. A file is read when it is asked for, and once.

    Everything raises FolderError where a file is missing or no longer whole, `case` also CaseError where case.yaml is
    not of this version.
    """

    def __init__(self, path: str | Path) -> None:
        self.folder = Path(path)
        self._tables: dict[str, TextTable] = {}

    def __repr__(self) -> str:
        return f"<RunFolder {self.folder}: {self.status or 'no run'}>"

    @cached_property
    def found_summary(self) -> dict[str, Any]:
        """summary.json as far as it is there; empty where it can't be read as a mapping."""
        try:
            found = json.loads(self.text(SUMMARY))
        except (FolderError, ValueError, RecursionError):  # RecursionError: of lists in lists in lists
            return {}
        return found if isinstance(found, dict) else {}

    @cached_property
    def summary(self) -> dict[str, Any]:
        """summary.json: how the run ended, what it cost, how good it is at its worst."""
        path, text = self.folder / SUMMARY, self.text(SUMMARY)
        try:
            summary = json.loads(text)
        except ValueError as error:
            raise damaged(path, str(error)) from error
        if not isinstance(summary, dict):
            raise damaged(path, "it is no mapping")
        if missing := [key for key in SUMMARY_KEYS if key not in summary]:
            raise damaged(path, f"it has no {', '.join(missing)}")
        return summary

    @property
    def status(self) -> str:
        """How the run ended: completed, arrested, broke_through, failed, interrupted or running; empty if not told."""
        return str(self.found_summary.get("status", ""))

    @property
    def reason(self) -> str:
        """Why it ended, in words; empty if not told."""
        return str(self.found_summary.get("stop_reason", ""))

    @property
    def finished(self) -> bool:
        """Whether the run has ended as runs should."""
        return self.status in FINISHED

    @property
    def warnings(self) -> tuple[str, ...]:
        """What is unsure in the run, and why, one sentence a cause."""
        return tuple(self.summary["warnings"])

    @cached_property
    def case_text(self) -> str:
        """case.yaml: the case as it ran."""
        return self.text(CASE)

    @cached_property
    def case(self) -> Case:
        """The case as it ran, under its own name."""
        self.text(CASE)  # where it is missing, FolderError says so
        case = load_case(self.folder / CASE)
        return replace(case, name=str(self.found_summary.get("case", case.name)))

    @cached_property
    def solved(self) -> list[int]:
        """Numbers of the steps that were solved, in order."""
        return [int(step) for step in self.table("steps").steps()]

    @property
    def places(self) -> list[int]:
        """The steps that can be shown: those solved, and one more where the last advance was not solved any more."""
        latest = int(self.table("paths").steps().max(initial=0))
        solved = self.solved
        return [*solved, latest] if not solved or latest > solved[-1] else solved

    def table(self, name: str) -> TextTable:
        """A table such as `tips`; without rows of a step in which a run was killed, which some tables may have."""
        if name not in self._tables:
            table = table_of(self.text(f"{name}.csv"), self.folder / f"{name}.csv")
            self._tables[name] = table.of_steps(self.solved) if table.path.name in OF_STEPS and len(table) else table
        return self._tables[name]

    def n_rows(self, name: str) -> int:
        """How many rows a table has, whole or not; 0 where there is no such file."""
        path = self.folder / f"{name}.csv"
        return max(len(path.read_bytes().splitlines()) - 1, 0) if path.is_file() else 0

    def has(self, name: str) -> bool:
        """Whether there is a file of this name."""
        return (self.folder / name).is_file()

    def text(self, name: str) -> str:
        """A file of the folder as it stands."""
        try:
            return (self.folder / name).read_text(encoding="utf-8")
        except UnicodeDecodeError as error:
            raise damaged(self.folder / name, str(error)) from error
        except OSError as error:
            raise FolderError(
                f"{self.folder} is not a folder of results: {name} cannot be read ({error.strerror}); give the folder "
                "that `crackgrow run` wrote, such as outputs/compression30"
            ) from error

    @cached_property
    def frames(self) -> dict[int, Path]:
        """Files of the frames by step, in order."""
        found = {own.step: own.path for own in own_files(self.folder, names=[FRAME]) if own.whole}
        return dict(sorted(found.items()))  # by number: step_10000 comes before step_9999 by name

    def frames_of(self, steps: Sequence[int | range] | None = None) -> list[int]:
        """The steps among these, or ranges of them, as they are found; all that have frames where none are named.

        Raises FolderError for a step without a frame, and where there are no frames at all.
        """
        if not self.frames:
            raise FolderError(f"{self.folder} has no frames to draw: run the case with output.frames=every_step")
        if steps is None:
            return list(self.frames)
        spans = [step if isinstance(step, range) else range(step, step + 1) for step in steps]
        missing = [gap for span in spans for gap in _gaps(span, self.frames)]
        if missing:
            there = spans_text(range(step, step + 1) for step in self.frames)
            raise FolderError(f"{self.folder} has no frame of step {spans_text(missing)}; it has those of {there}")
        return [step for step in self.frames if any(step in span for span in spans)]

    def mesh(self, step: int | None = None) -> pyvista.UnstructuredGrid:
        """The specimen in a step, of the last one that has a frame where none is named; m, Pa.

        Points are double along cracks. Point data: displacement, stress, sigma_1, sigma_3; cell data: these in the
        middle of cells but for displacement, body, energy_error.
        """
        import pyvista  # here: who reads tables alone needs none of it

        found = self.frames_of(None if step is None else [step])[-1]
        path = self.frames[found]
        grid = pyvista.read(path)
        if not isinstance(grid, pyvista.UnstructuredGrid) or "body" not in grid.cell_data or not grid.n_cells:
            raise damaged(path, "it has no cells of bodies")
        return grid

    def _frame(self, name: str) -> pd.DataFrame:
        return frame_of(self.table(name))


def open_run(path: str | Path) -> RunFolder:
    """The run that `crackgrow run` or `run_case` left in a folder, ended or not.

        >>> import crackgrow, tempfile
        >>> case = crackgrow.load_case("cases/compression30.yaml", ["numerics.spacing=3", "growth.steps=0"])
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     end = crackgrow.run_case(case, folder)
        ...     run = crackgrow.open_run(folder)
        ...     run.status, run.tips["K_II"].round(-4).tolist(), run.mesh(0).n_arrays
        ('completed', [-5750000.0, -5750000.0], 9)

    Raises FolderError where the folder holds none.
    """
    run = RunFolder(path)
    run.text(SUMMARY)
    return run


def table_of(text: str, path: Path) -> TextTable:
    """The table of a CSV text, that of a file at `path`; raises FolderError where rows are unlike the header."""
    try:
        rows = list(csv.reader(io.StringIO(text, newline="")))
    except csv.Error as error:
        raise damaged(path, str(error)) from error
    header = rows.pop(0) if rows else []
    for number, row in enumerate(rows, 1):
        if len(row) != len(header):
            raise damaged(path, f"row {number} has {len(row)} values, the header has {len(header)}")
    return TextTable(path, {column: [row[index] for row in rows] for index, column in enumerate(header)})


def damaged(path: Path, what: str) -> FolderError:
    """The error of a file that can't be read as what it should be."""
    return FolderError(f"{path} is damaged, or of another version: {what}; run the case again")


def _gaps(span: range, found: Iterable[int]) -> list[range]:
    """What of a range of steps is not among those found, which are in order."""
    edges = [span.start - 1, *(step for step in found if step in span), span.stop]
    return [range(before + 1, after) for before, after in pairwise(edges) if before + 1 < after]
