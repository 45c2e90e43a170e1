"""The columns of a sweep's table, its files, and what a run's folder tells for its row."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Final

from crackgrow.case.model import Case
from crackgrow.results.declarations import columns_of, declared
from crackgrow.results.folder import SUMMARY, RunFolder

FILES: Final = declared(columns_of("study")["sweep"])
"""Files of a sweep, beside the folders of its runs."""

KINDS: Final = {column.name: column.kind for column in FILES[0].columns}
FIRST: Final = ("run", "folder")
ENDING: Final = ("status", "reason")
OF_TIPS: Final = tuple(name.removeprefix("CRACK.TIP.") for name in KINDS if name.startswith("CRACK."))
"""After CRACK.TIP."""

COSTS: Final = tuple(name for name in KINDS if name not in (*FIRST, *ENDING, "PARAMETER") and "." not in name)
TAKEN: Final = frozenset({*FIRST, *ENDING, *COSTS})  # no parameter can be called so

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
