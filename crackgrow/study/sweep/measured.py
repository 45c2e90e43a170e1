"""What the files of a run tell of it, in one row."""

from __future__ import annotations

import csv
import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from crackgrow.study.sweep.job import Values

Rows = list[dict[str, str]]


def measured(folder: Path) -> Values:
    """How a run has ended, what it cost, and what its tips bear; nothing where it has not begun.

    Columns of a tip, CRACK.TIP.WHAT: K_I_first and K_II_first at the first step, K_I_last and K_II_last at the last
    one (Pa sqrt(m)), x and y of its end (m). A tip that has met something has no K at the last step.
    """
    try:
        summary: Any = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
    except FileNotFoundError:
        return {}
    estimate = summary["error_estimate"]
    steps, tips = _read(folder / "steps.csv"), _read(folder / "tips.csv")
    found: Values = {
        "status": summary["status"],
        "reason": summary["stop_reason"],
        "steps": summary["steps_done"],
        "load_factor": float(steps[-1]["load_factor"]) if steps else None,
        "n_dofs": summary["n_dofs"]["last"] if summary["n_dofs"] else None,
        "seconds": summary["wall_seconds"]["total"],
        "peak_memory_mb": summary["peak_memory_mb"],
        "energy_error_percent": estimate["energy_norm_percent"]["last"],
        "K_spread_percent": estimate["K_spread_percent"],
    }
    for name in dict.fromkeys(_tip(row) for row in tips):
        own = [row for row in tips if _tip(row) == name]
        ends = {"first": own[0], "last": own[-1]}
        for end, row in ends.items():
            if row["step"] == (tips[0] if end == "first" else tips[-1])["step"]:
                found |= {f"{name}.{K}_{end}": float(row[K]) for K in ("K_I", "K_II")}
    return found | _path_ends(_read(folder / "paths.csv"), [_tip(row) for row in tips])


def _path_ends(paths: Rows, tips: Iterable[str]) -> Values:
    """Where the tips are at the end."""
    found: Values = {}
    for name in dict.fromkeys(tips):
        crack, tip = name.rsplit(".", 1)
        vertices = [row for row in paths if row["crack"] == crack]
        if vertices:
            vertex = vertices[0 if tip == "start" else -1]
            found |= {f"{name}.{axis}": float(vertex[axis]) for axis in ("x", "y")}
    return found


def _tip(row: dict[str, str]) -> str:
    return f"{row['crack']}.{row['tip']}"


def _read(path: Path) -> Rows:
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))
