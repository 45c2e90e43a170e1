"""Refit the cost model of `crackgrow check`: `python -m tests.benchmarks.cost` measures, fits, writes and tells.

Writes crackgrow/plan/cost.json, the constants, and tests/benchmarks/cost.md, measured and estimated. Every scene runs
in a process of its own, with one BLAS thread; seconds are of CPU, for the first step and the mean of the next ones.
"""

from __future__ import annotations

import json
import resource
import subprocess
import sys
import time
from collections.abc import Sequence
from typing import Any

import numpy as np
from scipy.optimize import nnls

import crackgrow.results.figures
import crackgrow.results.vtk_frames  # noqa: F401  (loaded: a run needs their memory, too)
from crackgrow.case import load_case
from crackgrow.plan.cost import (
    LATER_TERMS,
    MEMORY_TERMS,
    TERMS,
    held_against,
    later_terms_of,
    memory_terms_of,
    probe,
    terms_of,
)
from crackgrow.plan.sizes import sizes_of
from crackgrow.run import grow
from tests.benchmarks.flaw_field import FLAWS, field_case
from tests.benchmarks.paths import ROOT
from tests.benchmarks.scenes import NO_FILES

FIELDS = {f"{n} flaws": n for n in FLAWS}
"""Plates with so many random flaws (`flaw_field`)."""

STEPS_OF_A_FIELD = 2

TARGET, LOWER_TARGET = (("numerics.spacing=auto", f"numerics.accuracy={target}") for target in ("1 %", "3 %"))

SCENES: tuple[tuple[str, tuple[str, ...]], ...] = (
    *(("compression30", (f"numerics.spacing={h}", "growth.steps=3")) for h in (3, 1.5, 0.75, 0.4, 0.2, 0.1)),
    *(("two_flaws", (f"numerics.spacing={h}", "growth.steps=2")) for h in (4, 2, 1)),
    *(("brazilian_disk", (f"numerics.spacing={h}", "growth.steps=2")) for h in (6, 3, 1.5)),
    *(("interface_friction04", (f"numerics.spacing={h}",)) for h in (0.1, 0.05, 0.025)),
    *(("random_flaws", (f"numerics.spacing={h}", "growth.steps=2")) for h in (6, 3)),
    ("cyclic_friction", ("numerics.spacing=2.5", "loading.history=[1]")),
    ("confined30", ("numerics.spacing=2", "growth.steps=2")),
    ("block_foundation", ("numerics.spacing=0.2",)),
    ("en_echelon", ("numerics.spacing=2", "growth.steps=2")),
    ("junction_static", ("numerics.spacing=1.5",)),
    *(("edge_tension", (f"numerics.spacing={h}",)) for h in (2, 0.75)),
    *(("compression30", (f"numerics.accuracy={name}", "growth.steps=4")) for name in ("draft", "standard", "fine")),
    *((name, ("growth.steps=2",)) for name in ("two_flaws", "flaw_and_hole", "brazilian_disk", "tension0")),
    *((name, ()) for name in ("edge_tension", "junction_static")),
    ("random_flaws", ("numerics.spacing=auto", "numerics.accuracy=draft", "growth.steps=1")),
    *((name, ("numerics.accuracy=draft",)) for name in FIELDS),
    *((name, (*TARGET, "growth.steps=3")) for name in ("compression30", "two_flaws", "en_echelon", "brazilian_disk")),
    *((name, TARGET) for name in ("edge_tension", "junction_static")),
    *(("random_flaws", (*target, "growth.steps=0")) for target in (LOWER_TARGET, TARGET)),
)

VALUES = ("first", "later", "memory")

REPEATS = 3
"""Runs of a scene, of which the quickest steps count: others only slow them down."""


def measured(name: str, settings: tuple[str, ...]) -> dict[str, Any]:
    """Sizes, seconds and memory of a scene; each run in a process of its own."""
    command = [sys.executable, "-m", "tests.benchmarks.cost", name, *settings]
    runs: list[dict[str, Any]] = []
    for _ in range(REPEATS):
        done = subprocess.run(command, check=True, capture_output=True, text=True, cwd=ROOT)
        runs.append(json.loads(done.stdout))
    quickest = {key: min(run[key] for run in runs) for key in ("first", "later", "probe") if runs[0][key] is not None}
    return runs[0] | quickest


def measure(name: str, settings: tuple[str, ...]) -> dict[str, Any]:
    """Run a scene here, and count."""
    case = (
        field_case(FIELDS[name], STEPS_OF_A_FIELD)
        if name in FIELDS
        else load_case(ROOT / "cases" / f"{name}.yaml", (*settings, *NO_FILES))
    )
    quick = min(probe() for _ in range(3))
    seconds, steps = [], grow(case)
    start = time.process_time()
    for _ in steps:
        seconds.append(time.process_time() - start)
        start = time.process_time()
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    sizes = sizes_of(case)
    return {
        "first_terms": terms_of(case, sizes).tolist(),
        "later_terms": later_terms_of(case, sizes).tolist(),
        "memory_terms": memory_terms_of(case, sizes).tolist(),
        "held": held_against(case, sizes),
        "n_dofs": sizes.n_dofs,
        "n_contact": sizes.n_contact,
        "first": seconds[0],
        "later": float(np.mean(seconds[1:])) if len(seconds) > 1 else None,
        "memory": memory,
        "probe": quick,
    }


def held(row: dict[str, Any], value: str) -> float:
    """What it takes to hold K against that of other cells, s; of memory it is among the terms."""
    first, later = row["held"]
    plain = float(row["first"]) / (1.0 + first)
    return {"first": first * plain, "later": later * plain}.get(value, 0.0)


def fitted(rows: list[dict[str, Any]], value: str) -> list[float]:
    """Constants, none negative, of least relative error."""
    known = [row for row in rows if row[value] is not None]
    A, b, more = (
        np.array(each)
        for each in zip(*((row[f"{value}_terms"], row[value], held(row, value)) for row in known), strict=True)
    )
    found: list[float] = nnls(A / b[:, None], 1.0 - more / b)[0].tolist()
    return found


def main() -> None:
    """Measure, fit, write."""
    rows = []
    for name, settings in SCENES:
        rows.append(measured(name, settings))
        print(name, *settings, {key: rows[-1][key] for key in ("n_dofs", "first", "later", "memory")}, flush=True)
    table = {
        "terms": TERMS,
        "later_terms": LATER_TERMS,
        "memory_terms": MEMORY_TERMS,
        "probe": float(np.median([row["probe"] for row in rows])),
        **{value: fitted(rows, value) for value in VALUES},
    }
    write(table, rows, SCENES)


def write(table: dict[str, Any], rows: list[dict[str, Any]], scenes: Sequence[tuple[str, tuple[str, ...]]]) -> None:
    """Write the constants, and the table of what they make of the measurements."""
    (ROOT / "crackgrow" / "plan" / "cost.json").write_text(json.dumps(table, indent=1) + "\n", encoding="utf-8")
    lines = [
        "What steps cost, measured, and estimated over measured: `python -m tests.benchmarks.cost`.\n",
        "| scene, spacing | dofs | contact points | first step, s | ratio | later, s | ratio | memory, MiB | ratio |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    for (name, settings), row in zip(scenes, rows, strict=True):
        cells = [f"{name} {_named(settings)}", str(row["n_dofs"]), str(row["n_contact"])]
        for value in VALUES:
            estimate = float(np.dot(row[f"{value}_terms"], table[value])) + held(row, value)
            ratio = None if row[value] is None else estimate / row[value]
            cells += ["", ""] if ratio is None else [f"{row[value]:.3g}", f"{ratio:.2f}"]
        lines.append(f"| {' | '.join(cells)} |")
    (ROOT / "tests" / "benchmarks" / "cost.md").write_text("\n".join(lines) + "\n", encoding="utf-8")
    print("\n".join(lines))


def _named(settings: Sequence[str]) -> str:
    """The spacing or the accuracy of a row."""
    given = [value for key, _, value in (setting.partition("=") for setting in settings) if key.startswith("numerics.")]
    return given[-1] if given else "auto"


if __name__ == "__main__":
    if len(sys.argv) > 1:
        print(json.dumps(measure(sys.argv[1], tuple(sys.argv[2:]))))
    else:
        main()
