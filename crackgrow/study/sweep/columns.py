"""The columns of a sweep's table, its files, and what a run's folder tells for its row."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import Final

from crackgrow.case.model import Case
from crackgrow.results.declarations import Column, File
from crackgrow.results.folder import SUMMARY, RunFolder

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

Values = dict[str, str | float | int | None]
"""Cells of the table by column, SI; None where there is no value."""


def tip_columns(case: Case) -> list[str]:
    """Columns of all ends that can grow."""
    ends = [(crack, end) for crack in case.cracks for end in ("start", "end") if getattr(crack, f"tip_at_{end}")]
    return [f"{crack.name}.{end}.{what}" for crack, end in ends for what in OF_TIPS]


def response_columns(cases: Iterable[Case]) -> list[str]:
    """All columns with numbers that runs of these cases may have."""
    return list(dict.fromkeys([*COSTS, *(name for case in cases for name in tip_columns(case))]))


def measured(folder: Path) -> Values:
    """How a run has ended, what it cost, and what its tips bear; nothing where it has not begun.

    Columns of a tip, CRACK.TIP.WHAT: K_I_first and K_II_first at the first step, K_I_last and K_II_last at the last
    one (Pa sqrt(m)), x and y of its end (m). A tip that has met something has no K at the last step.
    """
    run = RunFolder(folder)
    if not run.has(SUMMARY):
        return {}
    summary, steps = run.summary, run.table("steps")
    estimate = summary["error_estimate"]
    found: Values = {
        "status": run.status,
        "reason": run.reason,
        "steps": summary["steps_done"],
        "load_factor": float(steps.numbers("load_factor")[-1]) if len(steps) else None,
        "n_dofs": summary["n_dofs"]["last"] if summary["n_dofs"] else None,
        "seconds": summary["wall_seconds"]["total"],
        "peak_memory_mb": summary["peak_memory_mb"],
        "energy_error_percent": estimate["energy_norm_percent"]["last"],
        "K_spread_percent": estimate["K_spread_percent"],
    }
    tips = run.table("tips")
    by_tip, steps_met, paths = tips.by("crack", "tip"), tips.steps().tolist(), run.table("paths").by("crack")
    for (crack, tip), table in by_tip.items():
        for end, step in (("first", steps_met[0]), ("last", steps_met[-1])):
            of_end = table.of_steps([step])
            found |= {f"{crack}.{tip}.{K}_{end}": float(of_end.numbers(K)[0]) for K in ("K_I", "K_II") if len(of_end)}
    for crack, tip in by_tip:
        if (crack,) in paths:
            vertex = 0 if tip == "start" else -1
            found |= {f"{crack}.{tip}.{axis}": float(paths[(crack,)].numbers(axis)[vertex]) for axis in ("x", "y")}
    return found
