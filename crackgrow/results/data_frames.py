"""The CSV tables as pandas DataFrames: the same columns, rows and values, in SI units."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from crackgrow.arrays import Floats
from crackgrow.results import tables
from crackgrow.results.declarations import RUN
from crackgrow.results.tables import Row
from crackgrow.run.result import StepResult

if TYPE_CHECKING:
    import pandas as pd

    from crackgrow.results.folder import TextTable


class RunTables:
    """The tables of a run, in its folder or in memory, with columns, units and values as in the CSV files."""

    @property
    def steps(self) -> pd.DataFrame:
        """steps.csv: a row for each step, with load factor, energies, checks, times.

        In memory `seconds_output` is without the writing of frames.
        """
        return self._frame("steps")

    @property
    def tips(self) -> pd.DataFrame:
        """tips.csv: a row for each step and tip, with place (m), K_I and K_II (Pa sqrt(m)), the criterion."""
        return self._frame("tips")

    @property
    def contact(self) -> pd.DataFrame:
        """contact.csv: a row for each step and contact point, with tractions (Pa), opening and slip (m), state."""
        return self._frame("contact")

    @property
    def reactions(self) -> pd.DataFrame:
        """reactions.csv: a row for each step and support, foundation or interface, with its force (N/m)."""
        return self._frame("reactions")

    @property
    def history(self) -> pd.DataFrame:
        """history.csv: a row for each increment, with what `output.points` see; where the case names points."""
        return self._frame("history")

    @property
    def events(self) -> pd.DataFrame:
        """events.csv: tips that have met a crack, a hole, the outline or an interface."""
        return self._frame("events")

    @property
    def paths(self) -> pd.DataFrame:
        """paths.csv: the cracks at the end, a row for each vertex (m) with the step that made it."""
        return self._frame("paths")

    def path(self, crack: str) -> Floats:
        """Vertices (n, 2) m of a crack at the end, from its start to its end; raises KeyError if there is none."""
        paths = self.paths
        if crack not in set(paths["crack"]):
            raise KeyError(f"no crack {crack!r}; the cracks are {', '.join(paths['crack'].unique()) or 'none'}")
        return paths.loc[paths["crack"] == crack, ["x", "y"]].to_numpy(dtype=float)

    def _frame(self, name: str) -> pd.DataFrame:
        raise NotImplementedError


def frame_of_results(name: str, results: Sequence[StepResult], last: Sequence[Row] = ()) -> pd.DataFrame:
    """A table of some steps, with the rows `last` behind theirs."""
    columns = tables.HEADERS[name]
    if name == "history":
        columns = next((tables.history_columns(result.history) for result in results if result.history), ())
    rows = [row for result in results for row in tables.GROWING[name](result)] if name in tables.GROWING else []
    return _frame(columns, [*rows, *last])


def frame_of(table: TextTable) -> pd.DataFrame:
    """A table of a run's folder, with the types that the same table has in memory."""
    import pandas as pd  # here: who reads tables as text needs none of it

    kinds = {column.name: column.kind for file in RUN if file.name == table.path.name for column in file.columns}
    columns: dict[str, object] = {}
    for name, words in table.columns.items():
        kind = kinds.get(name, float)
        if kind is str:
            columns[name] = words
        elif kind is bool:
            columns[name] = [word == "true" for word in words]
        else:
            columns[name] = table.numbers(name).astype(np.int64 if kind is int else float)
    return pd.DataFrame(columns)


def _frame(columns: Sequence[str], rows: Sequence[Row]) -> pd.DataFrame:
    import pandas as pd  # as above

    return pd.DataFrame([list(row) for row in rows], columns=pd.Index(columns))
