"""A run's folder: what its files are called, and the one place where they are read."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from crackgrow.case import load_case
from crackgrow.case.model import Case
from crackgrow.results.atomic import FolderError, damaged
from crackgrow.results.declarations import RUN
from crackgrow.results.run import Columns, Run
from crackgrow.results.units import spans_text

if TYPE_CHECKING:
    import pyvista

REPORT, SUMMARY, LOG, CASE, HISTORY = "report.html", "summary.json", "run.log", "case.yaml", "history.csv"
FRAME, FACES, CHECKPOINT = "frames/step_NNNN.vtu", "cracks/step_NNNN.vtp", "checkpoint/step_NNNN.npz"
PICTURE = "render/FIELD/step_NNNN.png"
OWN: Final = (*(file.name for file in RUN if not file.name.startswith("export/")), "render/FIELD/animation.mp4")
"""Names of all that a run writes, and of what is drawn of it; what is exported is the user's."""

OF_STEPS = ("tips.csv", "contact.csv", "reactions.csv", "interface_tips.csv", HISTORY)
"""Tables that may have rows of a step that a run was killed in: they count where steps.csv has the step."""

SUMMARY_KEYS = ("case", "title", "status", "stop_reason", "n_solves", "version", "git_commit", "git_modified", "n_dofs",
                "wall_seconds", "peak_memory_mb", "error_estimate", "warnings")  # fmt: skip


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


class RunFolder(Run):
    """A run as its files tell it. A file is read when it is asked for, and once.

    Everything raises FolderError where a file is missing or no longer whole, `case` also CaseError where case.yaml is
    not of this version.
    """

    def __init__(self, path: str | Path) -> None:
        self.folder = Path(path)

    def __repr__(self) -> str:
        return f"<Run in {self.folder}: {self.status or 'no run'}>"

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

    @cached_property
    def case_text(self) -> str:
        """case.yaml: the case as it ran."""
        return self.text(CASE)

    @cached_property
    def case(self) -> Case:  # type: ignore[override]  # it can be set, too
        """The case as it ran, under its own name."""
        self.text(CASE)  # where it is missing, FolderError says so
        case = load_case(self.folder / CASE)
        return replace(case, name=str(self.found_summary.get("case", case.name)))

    def read(self, name: str) -> Columns:
        """A table; without rows of a step in which a run was killed, which some tables may have."""
        table = Columns.of_text(self.folder / f"{name}.csv", self.text(f"{name}.csv"))
        return table.of_steps(self.solved) if table.path.name in OF_STEPS and table.n_rows else table

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


def _gaps(span: range, found: Iterable[int]) -> list[range]:
    """What of a range of steps is not among those found, which are in order."""
    edges = [span.start - 1, *(step for step in found if step in span), span.stop]
    return [range(before + 1, after) for before, after in pairwise(edges) if before + 1 < after]
