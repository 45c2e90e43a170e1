"""Frictional crack growth in rock by MLS-NMM (moving least squares, numerical manifold method).

The rooms of the package, from the ground up, what each holds and which file has which equation: README.md beside this
file. Each room imports only from those before it.
"""

from __future__ import annotations

import warnings
from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from crackgrow.api import Run, Solution, run_case, solve
    from crackgrow.case import load_case
    from crackgrow.case.model import Case
    from crackgrow.errors import CaseError, CrackgrowError, GeometryError, SolveError
    from crackgrow.results.atomic import OccupiedError, OutputError
    from crackgrow.results.export import export
    from crackgrow.results.folder import FolderError, RunFolder, open_run
    from crackgrow.run import grow
    from crackgrow.study.compare import compare_paths
    from crackgrow.study.converge.plan import plan_convergence
    from crackgrow.study.converge.runner import converge
    from crackgrow.study.sweep.plan import plan_sweep
    from crackgrow.study.sweep.runner import sweep

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
    "RunFolder",
    "Solution",
    "SolveError",
    "__version__",
    "compare_paths",
    "converge",
    "export",
    "grow",
    "load_case",
    "open_run",
    "plan_convergence",
    "plan_sweep",
    "run_case",
    "solve",
    "sweep",
]

# Loaded on first use: importing crackgrow stays cheap, and the command line can set thread limits before numpy.
_HOMES = {
    "api": "Run Solution run_case solve",
    "case": "load_case",
    "case.model": "Case",
    "errors": "CaseError CrackgrowError GeometryError SolveError",
    "results.atomic": "OccupiedError OutputError",
    "results.export": "export",
    "results.folder": "FolderError RunFolder open_run",
    "run": "grow",
    "study.compare": "compare_paths",
    "study.converge.plan": "plan_convergence",
    "study.converge.runner": "converge",
    "study.sweep.plan": "plan_sweep",
    "study.sweep.runner": "sweep",
}
# Names that were public, and are still found here, with a warning that says where they are.
_MOVED = {
    "case": "dump_case",
    "case.json_schema": "case_schema",
    "plan.overview": "overview",
    "plan.picture": "draw_scene",
    "plan.text": "plan_text",
    "results.render": "find_ffmpeg render write_gif write_mp4",
    "results.report": "write_report",
    "results.resume": "find_resumption",
    "results.view": "view",
    "results.writer": "RunWriter complete_run",
    "run.result": "RunEnd StepResult",
    "study.compare": "Comparison",
    "study.comparison_text": "comparison_csv comparison_text",
    "study.uniqueness": "unique_text",
    "study.sweep.runner": "sweep_line",
    "study.trade.plan": "plan_trade",
    "study.trade.row": "trade_line",
    "study.trade.runner": "trade",
}
_AS_THEY_WERE = ("plan_trade", "render")  # of these, what takes other arguments now: `moved` calls it in the old form


def __getattr__(name: str) -> object:
    for homes in (_HOMES, _MOVED):
        for home, names in homes.items():
            if name in names.split():
                if homes is _MOVED:
                    told = f"crackgrow.{name} is now in crackgrow.{home}, and will not be found here in a later version"
                    warnings.warn(told, DeprecationWarning, stacklevel=2)
                if name in _AS_THEY_WERE:
                    home = "moved"
                return getattr(import_module(f"crackgrow.{home}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
