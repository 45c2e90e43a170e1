"""The columns of a sweep's table, and its files."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import Final

from crackgrow.case.model import Case
from crackgrow.results.declarations import Column, File

_FIRST: Final = (
    Column("run", "", "number of the run, from 0", int),
    Column("folder", "", "folder of the run", str),
)
_PARAMETER: Final = Column(
    "PARAMETER", "as in the base case", "a column for each parameter, its values as the sweep file has them, under the "
    "last part of its key, or more of it where a column has that name (`growth.steps`)",
)  # fmt: skip
_ENDING: Final = (
    Column("status", "", "as in `summary.json`; or `refused`: no case, `failed`: why, `waiting`: not run yet", str),
    Column("reason", "", "why the run ended, was refused or failed", str),
)
_COSTS: Final = (
    Column("steps", "", "number of the last step", int),
    Column("load_factor", "", "at the last step"),
    Column("n_dofs", "", "unknowns of the last step", int),
    Column("seconds", "s", "wall time of the run"),
    Column("peak_memory_mb", "MB", "memory of the run's process; of this run alone on Linux"),
    Column("energy_error_percent", "%", "the run's own estimate of its error in the energy norm"),
    Column("K_spread_percent", "%", "spread of K over the discs of its integral"),
)
_TIPS: Final = (
    Column("K_I_first", "Pa sqrt(m)", "at the first step"),
    Column("K_II_first", "Pa sqrt(m)", "at the first step"),
    Column("K_I_last", "Pa sqrt(m)", "at the last step; no value where the tip has met something before"),
    Column("K_II_last", "Pa sqrt(m)", "at the last step; no value where the tip has met something before"),
    Column("x", "m", "where the tip's path ends"),
    Column("y", "m", "where the tip's path ends"),
)

KINDS: Final = {column.name: column.kind for column in (*_FIRST, *_ENDING, *_COSTS)}
FIRST: Final = tuple(column.name for column in _FIRST)
ENDING: Final = tuple(column.name for column in _ENDING)
COSTS: Final = tuple(column.name for column in _COSTS)
TAKEN: Final = frozenset({*FIRST, *ENDING, *COSTS})  # no parameter can be called so
OF_TIPS: Final = tuple(column.name for column in _TIPS)
"""After CRACK.TIP."""

FILES: Final = (
    File(
        "sweep.csv",
        "a row for each run, written anew as each run ends: whole at any time",
        (*_FIRST, _PARAMETER, *_ENDING, *_COSTS, *(replace(tip, name=f"CRACK.TIP.{tip.name}") for tip in _TIPS)),
    ),
    File("sweep.parquet", "the same table, its columns with their types"),
    File("sweep.png", "responses over the parameters (heat maps where there are two), and all paths"),
)
"""Files of a sweep, beside the folders of its runs."""


def tip_columns(case: Case) -> list[str]:
    """Columns of all ends that can grow."""
    ends = [(crack, end) for crack in case.cracks for end in ("start", "end") if getattr(crack, f"tip_at_{end}")]
    return [f"{crack.name}.{end}.{what}" for crack, end in ends for what in OF_TIPS]


def response_columns(cases: Iterable[Case]) -> list[str]:
    """All columns with numbers that runs of these cases may have."""
    return list(dict.fromkeys([*COSTS, *(name for case in cases for name in tip_columns(case))]))
