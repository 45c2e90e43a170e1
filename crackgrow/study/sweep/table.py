"""The table of a sweep: a row for each run, as CSV and as Parquet, both written whole or not at all."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import pyarrow
from pyarrow import parquet

from crackgrow.case.units import is_number
from crackgrow.results.atomic import write_atomically, write_text
from crackgrow.results.tables import csv_text
from crackgrow.study.sweep.columns import COSTS, ENDING, FIRST, KINDS, Values
from crackgrow.study.sweep.plan import Run, SweepPlan

WAITING: Final = "waiting"
CSV_FILE, PARQUET_FILE = "sweep.csv", "sweep.parquet"


@dataclass(slots=True)
class SweepTable:
    """The rows of all runs; those that are not done are waiting."""

    plan: SweepPlan
    found: dict[int, Values]  # of the runs that have ended, or were refused

    def write(self) -> None:
        """Bring both files up to date; raises OutputError."""
        columns, rows = self.columns(), self.rows()
        lines = ([row.get(name) for name in columns] for row in rows)
        write_text(self.plan.folder / CSV_FILE, csv_text(columns, lines))
        schema = pyarrow.schema([(name, self._kind(name)) for name in columns])
        table = pyarrow.Table.from_pylist([_numbers(row, schema) for row in rows], schema)
        write_atomically(self.plan.folder / PARQUET_FILE, lambda file: parquet.write_table(table, file))

    def columns(self) -> list[str]:
        """Names of all columns: the tips' last, as they were met."""
        names = [*FIRST, *self.plan.parameters, *ENDING, *COSTS]
        return list(dict.fromkeys([*names, *(name for number in sorted(self.found) for name in self.found[number])]))

    def rows(self) -> list[Values]:
        """A row for each run, in the order of the plan."""
        return [self.row(run) for run in self.plan.runs]

    def row(self, run: Run) -> Values:
        """The row of a run."""
        given = dict(zip(self.plan.parameters, run.values, strict=True))
        found = self.found.get(run.number, {"status": WAITING})
        return {"run": run.number, "folder": run.folder.name, **given, **found}

    def numeric(self, parameter: str) -> bool:
        """Whether all values of a parameter are bare numbers."""
        place = self.plan.parameters.index(parameter)
        return all(is_number(run.values[place]) for run in self.plan.runs)

    def _kind(self, column: str) -> pyarrow.DataType:
        word = column in self.plan.parameters and not self.numeric(column)
        kind = str if word else KINDS.get(column, float)
        return pyarrow.string() if kind is str else pyarrow.int64() if kind is int else pyarrow.float64()


def _numbers(row: Values, schema: pyarrow.Schema) -> Mapping[str, object]:
    """The row as its columns want it: parameters that are numbers as such, nan as no value."""
    cells: dict[str, object] = {}
    for field in schema:
        value = row.get(field.name)
        if value is not None and pyarrow.types.is_floating(field.type):
            value = None if math.isnan(float(value)) else float(value)
        cells[field.name] = value
    return cells
