"""Frictional crack growth in rock by MLS-NMM (moving least squares, numerical manifold method).

The parts, from the ground up; each imports only from those above it:

arrays         the types of arrays
ragged         lists of different lengths in one array
blas           one thread for linear algebra, while a case is solved
vectors        cross products of vectors of the plane
case           a YAML file becomes a checked, frozen Case in SI units
geometry       polylines, the arrangement of lines that cuts the lattice, tolerances
cover          lattice, manifold elements, physical patches, tips, numbering of functions
approximation  weights, moving least squares, tip functions: value and gradient of every dof at points
quadrature     integration rules, and the points of elements and edges
direct         the direct solver: sparse symmetric matrices, nested dissection, the multifrontal method
solid          elasticity: stiffness, loads, supports, the linear solve, stress
contact        crack faces: contact points, jump, Coulomb law, the contact solvers
fracture       tip stress, stress intensity, growth criteria, advance of a tip
estimate       the error in the energy norm
run            one step, and the loop over the steps
results        tables, frames, figures and a report on disk, made from the results alone
plan           what a case will model and cost, and a picture of it, before anything is solved
study          what several runs tell: how far apart their crack paths are, what extremes do to a scene,
               what accuracy costs, what parameters do: one run for each combination
api            a case solved or run from Python: arrays, tables, fields at points
cli            the command line, the only place that prints
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from crackgrow.api import Run, Solution, run_case, solve
    from crackgrow.case import dump_case, load_case
    from crackgrow.case.json_schema import case_schema
    from crackgrow.case.model import Case
    from crackgrow.errors import CaseError, CrackgrowError, GeometryError, SolveError
    from crackgrow.plan.picture import draw_scene
    from crackgrow.plan.text import plan_text
    from crackgrow.results.animation import find_ffmpeg, write_gif, write_mp4
    from crackgrow.results.atomic import OccupiedError, OutputError
    from crackgrow.results.export import export
    from crackgrow.results.folder import FolderError
    from crackgrow.results.overview import overview
    from crackgrow.results.render import render
    from crackgrow.results.report import write_report
    from crackgrow.results.resume import find_resumption
    from crackgrow.results.view import view
    from crackgrow.results.writer import RunWriter, complete_run
    from crackgrow.run import grow
    from crackgrow.run.result import RunEnd, StepResult
    from crackgrow.study.compare import compare_paths
    from crackgrow.study.comparison import Comparison
    from crackgrow.study.comparison_text import comparison_csv, comparison_text
    from crackgrow.study.converge.plan import plan_convergence
    from crackgrow.study.converge.runner import converge
    from crackgrow.study.second_solution import unique_text
    from crackgrow.study.stability.runner import stability
    from crackgrow.study.stability.table import stability_line
    from crackgrow.study.stability.writer import write_stability
    from crackgrow.study.sweep.plan import plan_sweep
    from crackgrow.study.sweep.runner import sweep, sweep_line
    from crackgrow.study.trade.plan import plan_trade
    from crackgrow.study.trade.row import trade_line
    from crackgrow.study.trade.runner import trade

__version__ = "0.1.0"

__all__ = [
    "Case",
    "CaseError",
    "Comparison",
    "CrackgrowError",
    "FolderError",
    "GeometryError",
    "OccupiedError",
    "OutputError",
    "Run",
    "RunEnd",
    "RunWriter",
    "Solution",
    "SolveError",
    "StepResult",
    "__version__",
    "case_schema",
    "compare_paths",
    "comparison_csv",
    "comparison_text",
    "complete_run",
    "converge",
    "draw_scene",
    "dump_case",
    "export",
    "find_ffmpeg",
    "find_resumption",
    "grow",
    "load_case",
    "overview",
    "plan_convergence",
    "plan_sweep",
    "plan_text",
    "plan_trade",
    "render",
    "run_case",
    "solve",
    "stability",
    "stability_line",
    "sweep",
    "sweep_line",
    "trade",
    "trade_line",
    "unique_text",
    "view",
    "write_gif",
    "write_mp4",
    "write_report",
    "write_stability",
]

# Loaded on first use: importing crackgrow stays cheap, and the command line can set thread limits before numpy.
_HOMES = {
    "Case": "crackgrow.case.model",
    "CaseError": "crackgrow.errors",
    "Comparison": "crackgrow.study.comparison",
    "CrackgrowError": "crackgrow.errors",
    "FolderError": "crackgrow.results.folder",
    "GeometryError": "crackgrow.errors",
    "OccupiedError": "crackgrow.results.atomic",
    "OutputError": "crackgrow.results.atomic",
    "Run": "crackgrow.api",
    "RunEnd": "crackgrow.run.result",
    "RunWriter": "crackgrow.results.writer",
    "Solution": "crackgrow.api",
    "SolveError": "crackgrow.errors",
    "StepResult": "crackgrow.run.result",
    "case_schema": "crackgrow.case.json_schema",
    "compare_paths": "crackgrow.study.compare",
    "comparison_csv": "crackgrow.study.comparison_text",
    "comparison_text": "crackgrow.study.comparison_text",
    "complete_run": "crackgrow.results.writer",
    "converge": "crackgrow.study.converge.runner",
    "draw_scene": "crackgrow.plan.picture",
    "dump_case": "crackgrow.case",
    "export": "crackgrow.results.export",
    "find_ffmpeg": "crackgrow.results.animation",
    "find_resumption": "crackgrow.results.resume",
    "grow": "crackgrow.run",
    "load_case": "crackgrow.case",
    "overview": "crackgrow.results.overview",
    "plan_convergence": "crackgrow.study.converge.plan",
    "plan_sweep": "crackgrow.study.sweep.plan",
    "plan_text": "crackgrow.plan.text",
    "plan_trade": "crackgrow.study.trade.plan",
    "render": "crackgrow.results.render",
    "run_case": "crackgrow.api",
    "solve": "crackgrow.api",
    "stability": "crackgrow.study.stability.runner",
    "stability_line": "crackgrow.study.stability.table",
    "sweep": "crackgrow.study.sweep.runner",
    "sweep_line": "crackgrow.study.sweep.runner",
    "trade": "crackgrow.study.trade.runner",
    "trade_line": "crackgrow.study.trade.row",
    "unique_text": "crackgrow.study.second_solution",
    "view": "crackgrow.results.view",
    "write_gif": "crackgrow.results.animation",
    "write_mp4": "crackgrow.results.animation",
    "write_report": "crackgrow.results.report",
    "write_stability": "crackgrow.study.stability.writer",
}


def __getattr__(name: str) -> object:
    if name in _HOMES:
        return getattr(import_module(_HOMES[name]), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
