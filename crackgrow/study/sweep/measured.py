"""What the files of a run tell of it, in one row."""

from __future__ import annotations

from pathlib import Path

from crackgrow.results.folder import SUMMARY, RunFolder

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
