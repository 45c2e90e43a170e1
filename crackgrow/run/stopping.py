"""Why a run whose cracks grow ends."""

from __future__ import annotations

import numpy as np

from crackgrow.errors import FreePieceError, GeometryError, SolveError
from crackgrow.run.advances import site_criticality
from crackgrow.run.checkpoint import RunState
from crackgrow.run.critical_load import NEVER_CRITICAL
from crackgrow.run.evaluation import StepSolution
from crackgrow.run.report import paths_of
from crackgrow.run.result import RunEnd
from crackgrow.solid.rigid_modes import all_pieces


def unsolved(state: RunState, error: GeometryError | SolveError) -> RunEnd:
    """The end at a step after the first that was not solved: rock may have come loose."""
    paths = paths_of(state.cracks)
    if isinstance(error, FreePieceError):
        return RunEnd("broke_through", f"step {state.step}: {error.what}", paths, state.events)
    return RunEnd("failed", f"step {state.step}: {error}", paths, state.events)


def stopped(state: RunState, solution: StepSolution) -> RunEnd:
    """The end of a run whose cracks don't grow any more."""
    largest, paths = site_criticality(solution).max(initial=-np.inf), paths_of(state.cracks)
    law = solution.scene.case.subcritical
    if NEVER_CRITICAL in solution.notes:
        return RunEnd("arrested", f"step {state.step}: {NEVER_CRITICAL}", paths)
    if largest > -np.inf and law is not None:
        most = f"the most critical is at {largest:.3g} of its toughness, the threshold is {law.threshold:g}"
        return RunEnd("arrested", f"step {state.step}: no tip has a velocity; {most}", paths)
    if largest > -np.inf:
        where = f"step {state.step}" if state.step else "nothing grew"
        return RunEnd("arrested", f"{where}: no tip meets the criterion{criticality_text(solution)}", paths)
    return without_tips(state, solution)


def without_tips(state: RunState, solution: StepSolution) -> RunEnd:
    """The end of a run in which no tip is left."""
    reason, n_left = f"step {state.step}: no tip is left that could grow", len(all_pieces(solution.cover))
    if n_left > state.n_pieces:
        cut = f"the cracks have cut the rock into {n_left} pieces, {state.n_pieces} at the start"
        return RunEnd("broke_through", f"{reason}; {cut}", paths_of(state.cracks))
    return RunEnd("arrested", reason, paths_of(state.cracks))


def all_done(state: RunState, solution: StepSolution) -> RunEnd:
    """The end of a run that has come to its last step."""
    done = (
        f"all {state.step} growth steps are done"
        if state.step
        else f"the static solve is done{criticality_text(solution)}"
    )
    return RunEnd("completed", done, paths_of(state.cracks))


def criticality_text(solution: StepSolution) -> str:
    """How near to growth the tips are, in words; empty where there is none that can grow."""
    largest = site_criticality(solution).max(initial=-np.inf)
    at = f"{largest:.3g} of the strength at load factor {solution.state.factor:.4g}"
    return f"; the most critical is at {at}" if largest > -np.inf else ""
