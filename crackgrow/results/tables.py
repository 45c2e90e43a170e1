"""The CSV tables: one header, rows that grow with the steps, numbers in full precision."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np

from crackgrow.results.atomic import GrowingFile
from crackgrow.results.declarations import FILES, PHASES, RUN, File
from crackgrow.results.run import Columns
from crackgrow.run.result import STATE_NAMES, CrackPath, Event, History, RunEnd, StepResult

Value = str | bool | int | float
Row = tuple[Value, ...]

COMPONENTS: Final = ("xx", "yy", "xy")

HEADERS: Final = {file.name.removesuffix(".csv"): file.header for file in RUN if ".csv" in file.name}
"""Columns of the tables by name."""


class Table(GrowingFile):
    """A table in a run's folder, its rows in memory and on disk: the file is complete after every `write`."""

    def __init__(self, folder: Path, name: str, columns: Sequence[str] = ()) -> None:
        """`columns` are those of the name, unless they are given."""
        super().__init__(folder / f"{name}.csv", ",".join(columns or HEADERS[name]))

    def extend(self, rows: Iterable[Sequence[Value]]) -> None:
        """Append rows, values in the order of the columns."""
        self.lines.extend(",".join(format_value(value) for value in row) for row in rows)

    def __len__(self) -> int:
        return len(self.lines) - 1

    def drop_from(self, step: int) -> None:
        """Take over what the file has of the steps before one, and drop the rest; raises OutputError."""
        self.lines = lines_before(self.path, step)
        self.n_written = 0
        self.write()


def lines_before(path: Path, step: int) -> list[str]:
    """The header and the rows, as far as they are whole, that a table had before a step was added.

    Raises ValueError where it is no table that this version goes on with, OSError where it can't be read.
    """
    header, *rows = path.read_text(encoding="utf-8").split("\n")[:-1]  # a last row without an end was cut off
    if path.name != "history.csv" and header.split(",") != list(HEADERS[path.stem]):
        raise ValueError(f"another header: {header}")
    return [header, *(row for row in rows if int(row.partition(",")[0]) < step)]


def format_value(value: Value) -> str:
    """One cell: the shortest text that reads back to the same float; true and false; text quoted where it must be."""
    if isinstance(value, str):
        return '"' + value.replace('"', '""') + '"' if any(sign in value for sign in ',"\n\r') else value
    if isinstance(value, bool):
        return "true" if value else "false"
    return repr(float(value)) if isinstance(value, float) else str(int(value))


def csv_text(columns: Sequence[str], rows: Iterable[Iterable[Value | None]]) -> str:
    """A whole table, as studies write theirs: empty where there is no value, and for nan."""
    lines = [columns, *(["" if value is None or value != value else value for value in row] for row in rows)]
    return "".join(",".join(format_value(value) for value in line) + "\n" for line in lines)


def _row(file: File, sources: Sequence[object], given: Mapping[str, Any]) -> Row:
    """A value for each column: the one given, or else what the first source has that has anything of its name."""
    return tuple(
        column.kind(given[name] if name in given else next(getattr(of, name) for of in sources if hasattr(of, name)))
        for column, name in zip(file.columns, file.header, strict=True)
    )


def _place(point: Iterable[Any]) -> dict[str, Any]:
    return dict(zip("xy", point, strict=True))


def path_rows(cracks: Iterable[CrackPath]) -> list[Row]:
    """Rows of paths.csv: vertices from start to end, m, with the step whose advance made them."""
    return [
        (crack.name, vertex, x, y, step)
        for crack in cracks
        for vertex, ((x, y), step) in enumerate(zip(crack.points.tolist(), crack.steps.tolist(), strict=True))
    ]


def contact_rows(result: StepResult) -> list[Row]:
    """Rows of contact.csv: m and Pa, state as a word."""
    contact = result.contact
    given = _place(contact.points.T) | {"step": [result.step] * len(contact.crack)}
    given["state"] = [STATE_NAMES[state] for state in contact.state.tolist()]
    columns = [
        (column.kind, given.get(column.name, getattr(contact, column.name, ())))
        for column in FILES["contact.csv"].columns
    ]
    return list(zip(*([kind(value) for value in values] for kind, values in columns), strict=True))


def history_columns(history: History) -> tuple[str, ...]:
    """Columns of history.csv, those of the case's own points and reactions among them."""
    return ("step", "increment", "load_factor", *history.columns)


def history_rows(result: StepResult) -> list[Row]:
    """Return the rows of history.csv: one for each state on the way of a step, and at last the step's own; or none."""
    history = result.history
    if history is None:
        return []
    rows = zip(history.load_factor.tolist(), history.values.tolist(), strict=True)
    return [(int(result.step), number, factor, *values) for number, (factor, values) in enumerate(rows)]


def event_rows(events: Iterable[Event]) -> list[Row]:
    """Rows of events.csv, places in m."""
    return [_row(FILES["events.csv"], (event,), _place(event.point)) for event in events]


def end_rows(end: RunEnd) -> list[Row]:
    """Rows of events.csv of the end of a run, with what has parted the rock last."""
    events, nowhere = list(end.events), np.full(2, np.nan)
    if end.status == "broke_through":
        step = max((int(crack.steps.max()) for crack in end.cracks), default=0)
        events.append(Event(step, "parted", "", "", nowhere, end.reason))
    return event_rows(events)


def step_row(result: StepResult, seconds_frames: float = 0.0) -> Row:
    """The row of steps.csv; `seconds_frames` is what writing the step's frames took, added to the output phase."""
    seconds = {f"seconds_{phase}": float(result.seconds.get(phase, 0.0)) for phase in PHASES}
    seconds["seconds_output"] += seconds_frames
    energy = result.energy
    energies = {
        "work": energy.work,
        "strain_energy": energy.strain,
        "dissipation": energy.dissipated,
        "released_energy": energy.released,
        "energy_error": energy.error,
    }
    means = {"mean_stress": result.mean_stress, "mean_strain": result.mean_strain}
    parts = {f"{name}_{xx}": part for name, of in means.items() for xx, part in zip(COMPONENTS, of, strict=True)}
    return _row(FILES["steps.csv"], (result,), seconds | energies | parts)


GROWING: Final[Mapping[str, Callable[[StepResult], list[Row]]]] = {
    "tips": lambda of: [_row(FILES["tips.csv"], (tip, of), _place(tip.point)) for tip in of.tips],
    "interface_tips": lambda of: [
        _row(FILES["interface_tips.csv"], (tip, of), _place(tip.point)) for tip in of.interface_tips
    ],
    "contact": contact_rows,
    "reactions": lambda of: [
        (int(of.step), one.where, *one.force, one.pressure, float(of.load_factor)) for one in of.reactions
    ],
    "history": history_rows,
    "steps": lambda of: [step_row(of)],
    "events": lambda of: event_rows((*of.events, *of.emissions)),
}
"""What a step adds to the tables that grow with the steps."""


def table_of(name: str, results: Sequence[StepResult], cracks: Sequence[CrackPath], events: Sequence[Row]) -> Columns:
    """A table of some steps in memory, with the cracks at their end and what has happened then.

    `seconds_output` of the steps is without the writing of frames.
    """
    columns = HEADERS[name]
    if name == "history":
        columns = next((history_columns(result.history) for result in results if result.history), ())
    rows = path_rows(cracks) if name == "paths" else [row for result in results for row in GROWING[name](result)]
    rows += events if name == "events" else ()
    cells = zip(*rows, strict=True) if rows else ((),) * len(columns)
    return Columns.of_cells(Path(f"{name}.csv"), dict(zip(columns, cells, strict=True)))
