"""Rows of the table, and the table as CSV, which is read again to go on where a study has stopped."""

from __future__ import annotations

import math
import statistics
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from crackgrow.case import Case
from crackgrow.errors import CaseError
from crackgrow.results import tables
from crackgrow.results.declarations import PHASES
from crackgrow.results.folder import FINISHED, FolderError, RunFolder, table_of
from crackgrow.study.setting import Setting
from crackgrow.study.timed_run import Cost
from crackgrow.study.trade.columns import COLUMNS, ENERGY
from crackgrow.study.trade.plan import KEYS

REFERENCE = "reference"  # the name of its row


@dataclass(frozen=True, slots=True, eq=False)
class Row:
    """A row of trade.csv: text by column, SI; empty where there is no value."""

    cells: Mapping[str, str]

    @property
    def name(self) -> str:
        """The setting, by which rows are told apart."""
        return self.cells["setting"]

    @property
    def preset(self) -> str:
        """The preset, empty where the row is none."""
        return self.cells["preset"]

    @property
    def solved(self) -> bool:
        """Whether the run ended as runs should."""
        return self.cells["status"] in FINISHED

    def number(self, column: str) -> float:
        """The value in a column, nan where there is none."""
        return float(self.cells[column] or math.nan)


@dataclass(frozen=True, slots=True)
class Run:
    """A run that has ended, whatever came of it, with its results."""

    setting: Setting
    case: Case | None  # None where the setting is no case at all
    cost: Cost
    folder: Path
    repeats: int = 1

    def with_note(self, note: str) -> Run:
        """The same run with something to say after the reason of its end."""
        return replace(self, cost=replace(self.cost, reason=f"{self.cost.reason}; {note}"))


def row_of(run: Run, errors: Mapping[str, float] | None = None) -> Row:
    """The row of a run with its errors, by column."""
    setting, case, cost = run.setting, run.case, run.cost
    values: dict[str, Any] = {
        "setting": setting.name,
        "preset": setting.preset,
        **{axis: None if case is None else _value(case.resolved, key.split(".")) for axis, key in KEYS.items()},
        "status": cost.status,
        "reason": " ".join(cost.reason.split()),
        "repeats": run.repeats,
    }
    if cost.cpu_steps:
        summary = RunFolder(run.folder).summary
        by_phase = summary["wall_seconds"]["by_phase"]
        values |= {"steps": summary["steps_done"], "n_dofs": summary["n_dofs"]["first"]}
        values |= {f"wall_{phase}": float(by_phase.get(phase, 0.0)) for phase in PHASES}
        values |= errors or {}
        static = case is not None and case.growth is None  # errors are those of the last step, the last load factor
        estimate = summary["error_estimate"]["energy_norm_percent"]["last" if static else "first"]
        values["error_estimate"] = None if estimate is None else estimate / 100.0
        values |= {"cpu_first_step": cost.cpu_steps[0], "wall_first_step": cost.wall_steps[0]}
        values |= {"cpu_step": _mean(cost.cpu_steps[1:]), "wall_step": _mean(cost.wall_steps[1:])}
    values |= {name: getattr(cost, name) for name in ("cpu_seconds", "wall_seconds", "peak_memory_mb")}
    return Row({column: str(tables.or_empty(values.get(column))) for column in COLUMNS})


def csv_text(rows: Sequence[Row]) -> str:
    """All rows."""
    return tables.csv_text(COLUMNS, ([row.cells[column] for column in COLUMNS] for row in rows))


def read_rows(path: Path) -> list[Row]:
    """The rows of a table; raises CaseError where it is not one that this version writes."""
    try:
        table = table_of(path.read_text(encoding="utf-8"), path)
    except FolderError:
        table = None
    if table is None or tuple(table.columns) != COLUMNS:
        raise CaseError.at(path, "has other columns than this version writes; leave out --resume")
    return [Row(row) for row in table.rows()]


def trade_line(row: Row) -> str:
    """A row on a line of the terminal."""
    if not row.solved:
        return f"{row.name:48} {row.cells['status']}: {row.cells['reason']}"
    names = ("K_error", "path_hausdorff", "pressure_error", "slip_error", *ENERGY)
    shown = " ".join(f"{name.removesuffix('_error')} {row.number(name):.2g}" for name in names if row.cells[name])
    return f"{row.name:48} {row.cells['n_dofs']:>7} dofs {row.number('cpu_seconds'):8.2f} s  {shown}".rstrip()


def _value(mapping: Any, key: Sequence[str]) -> Any:
    """The value at a key of nested mappings; None where there is none."""
    for part in key:
        mapping = mapping.get(part) if isinstance(mapping, dict) else None
    return mapping


def _mean(seconds: Sequence[float]) -> float:
    return statistics.fmean(seconds) if seconds else math.nan
