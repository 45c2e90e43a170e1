"""A run as one reads it: how it ended and its tables, whether they are in memory or in its folder; m, Pa."""

from __future__ import annotations

import csv
import html
import io
from collections.abc import Collection, Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from crackgrow.arrays import Floats
from crackgrow.case.model import Case
from crackgrow.errors import CrackgrowError
from crackgrow.results.atomic import damaged
from crackgrow.results.declarations import FILES

if TYPE_CHECKING:
    import pandas as pd
    import pyvista

FINISHED: Final = ("completed", "arrested", "broke_through")
"""How a run ends that has done what it was asked."""

TYPES: Final[Mapping[type, type]] = {str: object, int: np.int64, float: float}


class Columns(dict[str, NDArray[Any]]):
    """A table: its columns (n,) by name, of the kinds that `columns.yaml` declares; FolderError for one that is not."""

    def __init__(self, path: Path, columns: Mapping[str, NDArray[Any]]) -> None:
        """`path` is that of its file."""
        super().__init__(columns)
        self.path = path

    @classmethod
    def of_cells(cls, path: Path, cells: Mapping[str, Sequence[Any]]) -> Columns:
        """The table of values, or of their texts in a file; raises FolderError for a text that is no such value."""
        kinds = {column.name: column.kind for column in FILES[path.name].columns}
        found: dict[str, NDArray[Any]] = {}
        for name, values in cells.items():
            kind = kinds.get(name, float)  # of the columns that are named by the case
            try:
                if kind is bool:
                    found[name] = np.array([value in (True, "true") for value in values], dtype=bool)
                else:
                    found[name] = np.array(values, dtype=TYPES[kind])
            except ValueError as error:
                if name in kinds:
                    raise damaged(path, f"{name}: {error}") from error
                found[name] = np.array(values, dtype=object)  # somebody's own words
        return cls(path, found)

    @classmethod
    def of_text(cls, path: Path, text: str) -> Columns:
        """The table of a CSV text; raises FolderError where it is none, or rows are unlike the header."""
        try:
            header, *rows = list(csv.reader(io.StringIO(text, newline=""))) or [[]]
        except csv.Error as error:
            raise damaged(path, str(error)) from error
        for number, row in enumerate(rows, 1):
            if len(row) != len(header):
                raise damaged(path, f"row {number} has {len(row)} values, the header has {len(header)}")
        return cls.of_cells(path, {name: [row[index] for row in rows] for index, name in enumerate(header)})

    def __missing__(self, name: str) -> NDArray[Any]:
        raise damaged(self.path, f"it has no column {name}; its columns are {', '.join(self) or 'none'}")

    @property
    def n_rows(self) -> int:
        """The number of rows."""
        return len(next(iter(self.values()), ()))

    def rows(self, which: Any) -> Columns:
        """Some rows, by their numbers or by which of all (n,) they are."""
        return Columns(self.path, {name: values[which] for name, values in self.items()})

    def of_steps(self, steps: Collection[int]) -> Columns:
        """The rows of these steps."""
        return self.rows(np.isin(self["step"], list(steps)))

    def records(self) -> list[dict[str, Any]]:
        """The rows, each with its values by name."""
        return [dict(zip(self, row, strict=True)) for row in zip(*(of.tolist() for of in self.values()), strict=True)]

    def by(self, *names: str) -> dict[tuple[Any, ...], Columns]:
        """The rows by what they have in some columns, in the order in which that comes."""
        numbers: dict[tuple[Any, ...], list[int]] = {}
        for number, key in enumerate(zip(*(self[name].tolist() for name in names), strict=True)):
            numbers.setdefault(key, []).append(number)
        return {key: self.rows(some) for key, some in numbers.items()}


class TableOf:
    """A table as a DataFrame, under its name, with the meaning that `columns.yaml` gives it."""

    def __set_name__(self, owner: type, name: str) -> None:
        self._name = name
        self.__doc__ = f"{name}.csv: {FILES[f'{name}.csv'].doc}"

    def __get__(self, tables: Tables | None, owner: type) -> pd.DataFrame:
        if tables is None:
            return self  # type: ignore[return-value]  # the class has itself
        import pandas as pd  # here: the program itself needs none of it

        return pd.DataFrame(dict(tables.table(self._name)))


class Tables:
    """Tables with columns, units and values as in the CSV files of a run."""

    case: Case

    steps, tips, paths, contact = TableOf(), TableOf(), TableOf(), TableOf()
    reactions, history, events, interface_tips = TableOf(), TableOf(), TableOf(), TableOf()

    def read(self, name: str) -> Columns:
        """A table from where it is."""
        raise NotImplementedError

    @cached_property
    def _found(self) -> dict[str, Columns]:
        return {}

    def table(self, name: str) -> Columns:
        """A table such as `tips`, which is read once."""
        if name not in self._found:
            self._found[name] = self.read(name)
        return self._found[name]

    def path(self, crack: str) -> Floats:
        """Vertices (n, 2) m of a crack at the end, from its start to its end; raises KeyError if there is none."""
        cracks = self.table("paths").by("crack")
        if (crack,) not in cracks:
            raise KeyError(f"no crack {crack!r}; the cracks are {', '.join(name for (name,) in cracks) or 'none'}")
        return np.stack([cracks[(crack,)][axis] for axis in "xy"], axis=1)

    def _html(self, words: str, warnings: Sequence[str], step: int) -> str:
        """The case, a line, the warnings and the tips of a step, for notebooks."""
        lines = [words, *(f"warning: {warning}" for warning in warnings)]
        shown = self.tips.loc[self.table("tips")["step"] == step, ["crack", "tip", "x", "y", "K_I", "K_II"]]
        head = f"<b>{html.escape(self.case.name)}</b>: {html.escape(self.case.title)}"
        return f"<div>{'<br>'.join([head, *map(html.escape, lines)])}{shown.to_html(index=False)}</div>"


class Run(Tables):
    """A run: in memory, as `run_case` gives it, or in the folder that `open_run` reads."""

    @property
    def summary(self) -> dict[str, Any]:
        """What summary.json says: how the run ended, what it cost, how good it is at its worst."""
        raise NotImplementedError

    @property
    def found_summary(self) -> dict[str, Any]:
        """The same as far as it is there."""
        return self.summary

    @property
    def status(self) -> str:
        """How it ended: completed, arrested, broke_through, failed, interrupted or running; empty if not told."""
        return str(self.found_summary.get("status", ""))

    @property
    def reason(self) -> str:
        """Why it ended, in words; empty if not told."""
        return str(self.found_summary.get("stop_reason", ""))

    @property
    def finished(self) -> bool:
        """Whether it has ended as runs should."""
        return self.status in FINISHED

    @property
    def warnings(self) -> tuple[str, ...]:
        """What is unsure in the run, and why, one sentence a cause; empty if nothing is."""
        return tuple(self.summary["warnings"])

    @cached_property
    def solved(self) -> list[int]:
        """Numbers of the steps that were solved, in order."""
        return [int(step) for step in self.table("steps")["step"]]

    @property
    def places(self) -> list[int]:
        """The steps that can be shown: those solved, and one more where the last advance was not solved any more."""
        latest = int(self.table("paths")["step"].max(initial=0))
        solved = self.solved
        return [*solved, latest] if not solved or latest > solved[-1] else solved

    def mesh(self, step: int) -> pyvista.UnstructuredGrid:
        """The specimen in a step, with displacement and stress; m, Pa."""
        raise NotImplementedError

    def _repr_html_(self) -> str | None:
        """Nothing where files are missing: then notebooks show the words of `repr`."""
        try:
            last = max(self.solved, default=0)
            return self._html(f"{self.status}: {self.reason}; tips of step {last}:", self.warnings, last)
        except CrackgrowError:
            return None
