"""Frictional crack growth in rock by MLS-NMM (moving least squares, numerical manifold method).

The rooms of the package, from the ground up, what each holds and which file has which equation: README.md beside this
file. Each room imports only from those before it.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from crackgrow.api import Solution, SolvedRun, run_case, solve
    from crackgrow.case import load_case
    from crackgrow.case.model import Case
    from crackgrow.errors import CaseError, CrackgrowError, GeometryError, SolveError
    from crackgrow.results.atomic import FolderError, OccupiedError, OutputError
    from crackgrow.results.export import export
    from crackgrow.results.folder import open_run
    from crackgrow.results.run import Run
    from crackgrow.run.loop import grow
    from crackgrow.study.compare import compare_paths
    from crackgrow.study.fit import fit, plan_fit
    from crackgrow.study.sweep import plan_sweep, sweep
    from crackgrow.study.trade import trade
    from crackgrow.study.trade_plan import plan_trade

__version__ = "0.1.0"

__all__ = [
    "Case",
    "CaseError",
    "CrackgrowError",
    "FolderError",
    "GeometryError",
    "OccupiedError",
    "OutputError",
    "Run",
    "Solution",
    "SolveError",
    "SolvedRun",
    "__version__",
    "compare_paths",
    "export",
    "fit",
    "grow",
    "load_case",
    "open_run",
    "plan_fit",
    "plan_sweep",
    "plan_trade",
    "run_case",
    "solve",
    "sweep",
    "trade",
]

# Loaded on first use: importing crackgrow stays cheap, and the command line can set thread limits before numpy.
_HOMES = {
    "api": "Solution SolvedRun run_case solve",
    "case": "load_case",
    "case.model": "Case",
    "errors": "CaseError CrackgrowError GeometryError SolveError",
    "results.atomic": "FolderError OccupiedError OutputError",
    "results.export": "export",
    "results.folder": "open_run",
    "results.run": "Run",
    "run.loop": "grow",
    "study.compare": "compare_paths",
    "study.fit": "fit plan_fit",
    "study.sweep": "plan_sweep sweep",
    "study.trade": "trade",
    "study.trade_plan": "plan_trade",
}


def __getattr__(name: str) -> object:
    for home, names in _HOMES.items():
        if name in names.split():
            return getattr(import_module(f"crackgrow.{home}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
