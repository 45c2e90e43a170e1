"""What the files of a run tell of it, in one row."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from crackgrow.results.folder import SUMMARY, RunFolder, TextTable

Values = dict[str, str | float | int | None]
"""Cells of the table by column, SI; None where there is no value."""


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
    all_tips = run.table("tips")
    tips, met = _by_tip(all_tips), all_tips.steps().tolist()
    for name, table in tips.items():
        for end, step in (("first", met[0]), ("last", met[-1])):
            of_end = table.of_steps([step])
            found |= {f"{name}.{K}_{end}": float(of_end.numbers(K)[0]) for K in ("K_I", "K_II") if len(of_end)}
    return found | _path_ends(run.table("paths"), tips)


def _by_tip(tips: TextTable) -> dict[str, TextTable]:
    """The rows of each tip, by CRACK.TIP, in the order in which tips come."""
    names = [f"{crack}.{tip}" for crack, tip in zip(tips.words("crack"), tips.words("tip"), strict=True)]
    return {name: tips.where([other == name for other in names]) for name in dict.fromkeys(names)}


def _path_ends(paths: TextTable, tips: Iterable[str]) -> Values:
    """Where the tips are at the end."""
    found: Values = {}
    cracks = paths.words("crack")
    for name in tips:
        crack, tip = name.rsplit(".", 1)
        own = paths.where([other == crack for other in cracks])
        if len(own):
            end = 0 if tip == "start" else -1
            found |= {f"{name}.{axis}": float(own.numbers(axis)[end]) for axis in ("x", "y")}
    return found
