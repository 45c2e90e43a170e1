"""The growth loop: load, evaluate the criterion, advance; one result a step."""

from __future__ import annotations

from collections.abc import Callable, Generator
from dataclasses import replace
from functools import partial
from typing import TypeVar

import numpy as np

from crackgrow.accuracy.companion import BOUND
from crackgrow.arrays import Ints
from crackgrow.blas import single_threaded
from crackgrow.case.model import Case, Growth, Stages, StrengthReduction
from crackgrow.case.on_map import on_map
from crackgrow.errors import GeometryError, SolveError
from crackgrow.run.advances import NO_SITES, chosen_advances, no_advance, site_criticality, time_step
from crackgrow.run.checkpoint import RunState, beginning, packed, restored
from crackgrow.run.direction import advance_tips
from crackgrow.run.evaluation import StepSolution
from crackgrow.run.increments import FROM_REST, Origin
from crackgrow.run.loading import HistorySolver, LoadsInTurn, NextStepSolver, load, load_again
from crackgrow.run.propagation import BeforeAdvance
from crackgrow.run.report import estimated_error, paths_of, step_result
from crackgrow.run.result import Checkpoint, RunEnd, Safety, StepResult
from crackgrow.run.scene import Scene, make_scene
from crackgrow.run.stopping import all_done, stopped, unsolved, without_tips
from crackgrow.run.strength_reduction import NARROW, strength_reduction
from crackgrow.run.target import next_grading, solved_to_target
from crackgrow.solid.rigid_modes import all_pieces

Steps = Generator[tuple[StepResult, StepSolution], None, RunEnd]
"""The result of each step with its solution, then why the run has ended."""

Item = TypeVar("Item")
Returned = TypeVar("Returned")


def grow(case: Case, checkpoint: Checkpoint | None = None) -> Generator[StepResult, None, RunEnd]:
    """Run a case: yields the result of every step, step 0 first, and returns why it ended.

    With a `checkpoint` of an earlier run of the case it begins with that step, and goes on to the same bits.

    With growth a step is a configuration of the cracks under the last of its loads; without, it is a load factor of the
    history. Raises GeometryError or SolveError where step 0 (without growth: any) can't be solved. A later one ends the
    run: `broke_through` where a piece of rock comes loose that nothing holds, else `failed`; the end has the cracks and
    the events of that step, and the estimated error of the last one that was solved.
    """
    return _steps(case, checkpoint, lambda result, _: result)


def solved_steps(case: Case, checkpoint: Checkpoint | None = None) -> Steps:
    """As `grow`, each result with the solution that it tells of."""
    return _steps(case, checkpoint, lambda *step: step)


def for_each(steps: Generator[Item, None, Returned], each: Callable[[Item], object]) -> Returned:
    """Hand each step on as it comes; return what the steps return."""
    while True:
        try:
            step = next(steps)
        except StopIteration as stop:
            end: Returned = stop.value
            return end
        each(step)


def _steps(
    case: Case, checkpoint: Checkpoint | None, convert: Callable[[StepResult, StepSolution], Item]
) -> Generator[Item, None, RunEnd]:
    """What `convert` makes of each step, then the end; linear algebra has one thread while steps are made.

    Places of results are those of the map, if the case has one; what is computed, and checkpoints, are at its origin.
    """
    with single_threaded():
        steps = _begun(make_scene(case), beginning(case) if checkpoint is None else restored(case, checkpoint))
    last: tuple[StepResult, StepSolution] | None = None
    while True:
        with single_threaded():
            try:
                last = next(steps)
            except StopIteration as stop:
                end: RunEnd = stop.value
                end = on_map(end, case.origin)
                return end if last is None else replace(end, norm_error=_last_error(*last))
        result, solution = last
        yield convert(on_map(result, case.origin), solution)


def _begun(scene: Scene, begun: RunState) -> Steps:
    """The steps of a run by what its loading and growth are."""
    if isinstance(scene.case.loading, StrengthReduction):
        return _reduced(scene, begun)
    return _static(scene, begun) if scene.case.growth is None else _growth(scene, scene.case.growth, begun)


def _last_error(result: StepResult, solution: StepSolution) -> float:
    """Estimated error, percent, of the last step, which is known to be the last only now."""
    return estimated_error(solution).relative if np.isnan(result.norm_error) else result.norm_error


def _growth(scene: Scene, growth: Growth, begun: RunState) -> Steps:
    """The steps of a run with growth."""
    scene = scene.with_cracks(begun.cracks)
    state, advances = begun, no_advance(begun.cracks)
    known = None if begun.origin is None else _again(scene, begun, begun.origin)
    before: StepSolution | None = None
    while True:
        if known is None and before is not None:
            before.contact.system.hand_over()  # this load alone takes over from it: memory holds the factors once
        try:
            solution = known or load(scene, state.cracks, before)
        except (GeometryError, SolveError) as error:
            if state.step == 0:
                raise
            return unsolved(state, error)
        solution = _solved_to_target(solution, before)
        scene = scene.with_grading(next_grading(solution))
        taken = time_step(advances, solution)
        solution = replace(solution, notes=(*solution.notes, *taken.notes))
        cracks, n_pieces = taken.with_shortfall(state.cracks), state.n_pieces or len(all_pieces(solution.cover))
        state = replace(state, cracks=cracks, n_pieces=n_pieces, time=state.time + taken.time)
        is_last = state.step == growth.steps
        advances = no_advance(state.cracks) if is_last else chosen_advances(growth, solution, state.cracks)
        yield _reported(state, solution, advances.sites), solution
        if is_last:
            no_tips = growth.steps > 0 and site_criticality(solution).max(initial=-np.inf) == -np.inf
            return (without_tips if no_tips else all_done)(state, solution)
        if len(advances.sites) == 0:
            return stopped(state, solution)
        at = BeforeAdvance(solution.scene, advances.cracks, state.step + 1, advances.lengths)
        advance = advance_tips(at, solution, advances.sites, partial(load, scene, before=solution))
        state = RunState(state.step + 1, advance.cracks, advance.events, state.n_pieces, time=state.time)
        scene, known, before = scene.with_cracks(advance.cracks), advance.solution, solution


def _again(scene: Scene, begun: RunState, origin: Origin) -> StepSolution:
    """The solution of a step that was solved before; the search for its direction of growth is not repeated."""
    if begun.errors is not None:
        scene = scene.with_grading(begun.errors.grading)
    solution = load_again(scene, begun.cracks, origin)
    return replace(solution, factorizations=begun.factorizations, notes=begun.notes, errors=begun.errors)


def _solved_to_target(solution: StepSolution, before: StepSolution | None) -> StepSolution:
    """A step with its errors, on cells that meet their target; `before` is the step before."""
    if not solution.scene.case.numerics.measured or solution.errors is not None:
        return solution
    return solved_to_target(
        solution, NextStepSolver(solution.cracks, before), None if before is None else before.companion
    )


def _static(scene: Scene, begun: RunState) -> Steps:
    """The load factors of the history, or the stages, in turn, without growth."""
    cracks, n = begun.cracks, scene.case.n_loads
    if begun.errors is not None:
        scene = scene.with_grading(begun.errors.grading)
    solver = HistorySolver(cracks, LoadsInTurn(scene, cracks, begun.step, begun.origin or FROM_REST))
    for step in range(begun.step, n):
        solver.number, solution = step, solver.here.solution(step)
        if step == begun.step and begun.origin is not None:  # it was solved before
            solution = replace(solution, factorizations=begun.factorizations, errors=begun.errors)
        elif scene.case.numerics.measured:
            solution = solved_to_target(solution, solver, None)
        yield _reported(RunState(step, cracks), solution, NO_SITES), solution
    done = f"all {n} {'stages' if isinstance(scene.case.loading, Stages) else 'load factors'} are done"
    return RunEnd("completed", "the static solve is done" if n == 1 else done, paths_of(cracks))


def _reduced(scene: Scene, begun: RunState) -> Steps:
    """The scene as it is, if it holds, and its last stable state while its strength is reduced."""
    safety, solutions = strength_reduction(scene, begun.cracks)
    if scene.case.numerics.measured:
        safety = replace(safety, error=100.0 * (BOUND * _factor_apart(scene, begun, safety) + NARROW))
    for step, solution in enumerate(solutions):
        if step >= begun.step:  # those before were told of when they were solved first
            yield _reported(RunState(step, begun.cracks), solution, NO_SITES), solution
    return RunEnd("completed", str(safety), paths_of(begun.cracks), safety=safety)


def _factor_apart(scene: Scene, begun: RunState, safety: Safety) -> float:
    """By how much, of itself, the factor of safety is another one on the companion mesh; nan where there is none."""
    companion = scene.with_grading(replace(scene.grading, companion=True))
    try:
        other = strength_reduction(companion, begun.cracks)[0].factor
        return abs(other / safety.factor - 1.0) if np.isfinite([other, safety.factor]).all() else float("nan")
    except (GeometryError, SolveError):
        return float("nan")


def _reported(state: RunState, solution: StepSolution, chosen: Ints) -> StepResult:
    """The step's result; frames are made where files or figures can want them."""
    output = solution.scene.case.output
    result = step_result(state, solution, chosen, output.frames != "none" or output.figures)
    solved = replace(
        state,
        origin=solution.origin,
        factorizations=solution.factorizations,
        notes=solution.notes,
        errors=solution.errors,
    )
    return replace(result, checkpoint=packed(solved))
