"""The growth loop: solve, judge, advance; one result a step."""

from __future__ import annotations

import time
from collections.abc import Generator

import numpy as np
from numpy.typing import NDArray

from crackgrow.case.model import Case, Growth
from crackgrow.errors import GeometryError, SolveError
from crackgrow.fracture.advance import GrowingCrack, growing_tips
from crackgrow.run.direction import advance_tips
from crackgrow.run.report import step_result
from crackgrow.run.result import CrackPath, RunEnd, StepResult
from crackgrow.run.scene import Scene, make_scene
from crackgrow.run.loading import load, load_history
from crackgrow.run.step import StepSolution

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


def grow(case: Case) -> Generator[StepResult, None, RunEnd]:
    """Run a case: yields the result of every solved step, step 0 first, and returns why it ended.

    Raises GeometryError or SolveError where a step can't be solved; the steps before it have been yielded.
    """
    scene = make_scene(case)
    cracks = tuple(GrowingCrack(crack, np.zeros(len(crack.points), dtype=np.int64)) for crack in case.cracks)
    n_steps = case.growth.steps if case.growth else 0
    ended: RunEnd | None = None
    told: frozenset[str] = frozenset()
    known: StepSolution | None = None
    for step in range(n_steps + 1):
        try:
            solution = known or solve_step(scene, cracks, case.last_factor)
        except (SolveError, GeometryError):
            if ended is None:
                raise
            return ended  # the body that a crack broke through can't be held any more
        chosen = _choose(case.growth, cracks, solution, last=step == n_steps or ended is not None)
        result = _reported(scene, cracks, solution, step, chosen, told)
        told |= frozenset(result.warnings)
        yield result
        if ended is not None:
            return ended
        if len(chosen) == 0 and step < n_steps:
            return RunEnd("arrested", _why_arrested(cracks, solution, step), _paths(cracks))
        if case.growth and step < n_steps:
            advance = advance_tips(scene, cracks, solution, chosen, step + 1, case.last_factor)
            cracks, known = advance.cracks, advance.solution
            if advance.left:
                reached = f"step {step + 1}: {' and '.join(advance.left)}"
                ended = RunEnd("broke_through", reached, _paths(cracks))
    done = f"all {n_steps} growth steps are done" if n_steps else "the static solve is done"
    return RunEnd("completed", done, _paths(cracks))


def _choose(growth: Growth | None, cracks: tuple[GrowingCrack, ...], solution: StepSolution, last: bool) -> Ints:
    """Numbers of the tips that advance after this solve; none after the last."""
    if growth is None or last:
        return np.empty(0, dtype=np.int64)
    n_advances = [cracks[index].n_advances(at_end) for index, at_end in solution.cover.tip_ends]
    return growing_tips(_criticality(cracks, solution), np.array(n_advances, dtype=np.int64), growth.advance)


def _criticality(cracks: tuple[GrowingCrack, ...], solution: StepSolution) -> Floats:
    """Criticality (n,) of every tip, -inf for one that must not grow."""
    return np.array(
        [
            tip.verdict.criticality if tip.verdict is not None and cracks[index].can_grow(at_end) else -np.inf
            for tip, (index, at_end) in zip(solution.tips, solution.cover.tip_ends, strict=True)
        ]
    )


def _reported(
    scene: Scene,
    cracks: tuple[GrowingCrack, ...],
    solution: StepSolution,
    step: int,
    chosen: Ints,
    told: frozenset[str],
) -> StepResult:
    """The step's result; frames are made where files or figures can want them."""
    start = time.perf_counter()
    output = scene.case.output
    wanted = output.frames != "none" or output.figures
    return step_result(scene, _paths(cracks), solution, step, chosen, wanted, start, told)


def _paths(cracks: tuple[GrowingCrack, ...]) -> tuple[CrackPath, ...]:
    return tuple(CrackPath(g.crack.name, g.crack.points, g.steps) for g in cracks)


def _why_arrested(cracks: tuple[GrowingCrack, ...], solution: StepSolution, step: int) -> str:
    largest = _criticality(cracks, solution).max(initial=-np.inf)
    if largest == -np.inf:
        return f"step {step}: no tip is left that could grow"
    return f"step {step}: no tip meets the criterion; the most critical is at {largest:.3g} of its strength"
