"""The growth loop: load, judge, advance; one result a step."""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import replace
from functools import partial

import numpy as np

from crackgrow.arrays import Ints
from crackgrow.blas import single_threaded
from crackgrow.case.model import Case, Growth, Stages, StrengthReduction
from crackgrow.errors import FreePieceError, GeometryError, SolveError
from crackgrow.run.aimed_history import aimed_history
from crackgrow.run.checkpoint import RunState, beginning, packed, restored
from crackgrow.run.critical_load import NEVER_CRITICAL
from crackgrow.run.direction import BeforeAdvance, advance_tips
from crackgrow.run.error import estimated_error
from crackgrow.run.increments import FROM_REST, Origin
from crackgrow.run.judging import StepSolution
from crackgrow.run.leaving import lapse, leaves, none_leaves, site_criticality
from crackgrow.run.loading import NextStep, load, load_again, load_history
from crackgrow.run.next_cells import halvings_after
from crackgrow.run.report import paths_of, step_result
from crackgrow.run.result import Checkpoint, RunEnd, Safety, StepResult
from crackgrow.run.scene import Scene, make_scene, scene_at_end
from crackgrow.run.strength_reduction import strength_reduction
from crackgrow.run.target import aimed
from crackgrow.solid.rigid_modes import all_pieces


def grow(case: Case, checkpoint: Checkpoint | None = None) -> Generator[StepResult, None, RunEnd]:
    """Run a case: yields the result of every step, step 0 first, and returns why it ended.

    With a `checkpoint` of an earlier run of the case it begins with that step, and goes on to the same bits.

    With growth a step is a configuration of the cracks under the last of its loads; without, it is a load factor of the
    history. Raises GeometryError or SolveError where step 0 (without growth: any) can't be solved. A later one ends the
    run: `broke_through` where a piece of rock comes loose that nothing holds, else `failed`; the end has the cracks and
    the events of that step, and the estimated error of the last one that was solved.
    """
    steps = solved_steps(case, checkpoint)
    while True:
        try:
            result, _ = next(steps)
        except StopIteration as stop:
            end: RunEnd = stop.value
            return end
        yield result


def solved_steps(
    case: Case, checkpoint: Checkpoint | None = None
) -> Generator[tuple[StepResult, StepSolution], None, RunEnd]:
    """As `grow`, each result with the solution that it tells of; linear algebra has one thread while they are made."""
    steps = _solved_steps(case, checkpoint)
    while True:
        try:
            with single_threaded():
                step = next(steps)
        except StopIteration as stop:
            end: RunEnd = stop.value
            return end
        yield step


def _solved_steps(
    case: Case, checkpoint: Checkpoint | None
) -> Generator[tuple[StepResult, StepSolution], None, RunEnd]:
    scene = make_scene(case)
    begun = beginning(case) if checkpoint is None else restored(case, checkpoint)
    if isinstance(case.loading, StrengthReduction):
        steps = _reduced(scene, begun)
    else:
        steps = _static(scene, begun) if case.growth is None else _growth(scene, case.growth, begun)
    last: tuple[StepResult, StepSolution] | None = None
    while True:
        try:
            last = next(steps)
        except StopIteration as stop:
            end: RunEnd = stop.value
            return end if last is None else replace(end, norm_error=_last_error(*last))
        yield last


def _last_error(result: StepResult, solution: StepSolution) -> float:
    """Estimated error, percent, of the last step, which is known to be the last only now."""
    return estimated_error(solution).relative if np.isnan(result.norm_error) else result.norm_error


def _growth(scene: Scene, growth: Growth, begun: RunState) -> Generator[tuple[StepResult, StepSolution], None, RunEnd]:
    """The steps of a run with growth."""
    n_steps = growth.steps
    scene = scene.with_cracks(begun.cracks)
    cracks, events, n_pieces = begun.cracks, begun.events, begun.n_pieces
    known = None if begun.origin is None else _again(scene, begun, begun.origin)
    before: StepSolution | None = None
    leaving, time = none_leaves(cracks), begun.time
    for step in range(begun.step, n_steps + 1):
        if known is None and before is not None:
            before.contact.system.hand_over()  # this load alone takes over from it: memory holds the factors once
        try:
            solution = known or load(scene, cracks, before)
        except FreePieceError as error:
            if step == 0:
                raise
            return RunEnd("broke_through", f"step {step}: {error.what}", paths_of(cracks), events)
        except (GeometryError, SolveError) as error:
            if step == 0:
                raise
            return RunEnd("failed", f"step {step}: {error}", paths_of(cracks), events)
        solution = _on_target(solution, before)
        scene = scene.with_halvings(halvings_after(solution))
        n_pieces = n_pieces or len(all_pieces(solution.cover))
        taken, solution = lapse(leaving, solution)
        time += taken
        leaving = leaves(growth, solution) if step < n_steps else none_leaves(cracks)
        result = _reported(RunState(step, cracks, events, n_pieces, time=time), solution, leaving.sites)
        yield result, solution
        if step == n_steps > 0 and site_criticality(solution).max(initial=-np.inf) == -np.inf:
            return _without_tips(solution, step, n_pieces)
        if len(leaving.sites) == 0 and step < n_steps:
            return _stopped(solution, step, n_pieces)
        if step < n_steps:
            solve = partial(load, scene, before=solution)
            beginning_at = BeforeAdvance(scene_at_end(scene), growth, leaving.cracks, step + 1, (), leaving.lengths)
            advance = advance_tips(beginning_at, solution, leaving.sites, solve)
            cracks, known, events, before = advance.cracks, advance.solution, advance.events, solution
            scene = scene.with_cracks(cracks)
    static = f"the static solve is done{_nearness(solution)}"
    done = f"all {n_steps} growth steps are done" if n_steps else static
    return RunEnd("completed", done, paths_of(cracks))


def _again(scene: Scene, begun: RunState, origin: Origin) -> StepSolution:
    """The solution of a step that was solved before; the search for its direction of growth is not repeated."""
    if begun.accuracy is not None:
        scene = scene.with_halvings(begun.accuracy.halvings)
    solution = load_again(scene, begun.cracks, origin)
    return replace(solution, factorizations=begun.factorizations, notes=begun.notes, accuracy=begun.accuracy)


def _on_target(solution: StepSolution, before: StepSolution | None) -> StepSolution:
    """A step on cells that meet the target of the error of K, if there is one; `before` is the step before."""
    if solution.scene.case.numerics.target is None or solution.accuracy is not None:
        return solution
    return aimed(solution, NextStep(solution.cracks, before), None if before is None else before.accuracy)


def _static(scene: Scene, begun: RunState) -> Generator[tuple[StepResult, StepSolution], None, RunEnd]:
    """The load factors of the history, or the stages, in turn, without growth."""
    cracks, n = begun.cracks, scene.case.last_step + 1
    chosen = np.empty(0, dtype=np.int64)
    histories = load_history if scene.case.numerics.target is None else partial(aimed_history, known=begun.accuracy)
    for step, solution in enumerate(histories(scene, cracks, begun.step, begun.origin or FROM_REST), begun.step):
        if step == begun.step and begun.origin is not None:  # it was solved before
            solution = replace(solution, factorizations=begun.factorizations)
        result = _reported(RunState(step, cracks), solution, chosen)
        yield result, solution
    done = f"all {n} {'stages' if isinstance(scene.case.loading, Stages) else 'load factors'} are done"
    return RunEnd("completed", "the static solve is done" if n == 1 else done, paths_of(cracks))


def _reduced(scene: Scene, begun: RunState) -> Generator[tuple[StepResult, StepSolution], None, RunEnd]:
    """The scene as it is, if it holds, and its last stable state while its strength is reduced."""
    cracks, chosen, step = begun.cracks, np.empty(0, dtype=np.int64), 0
    found = strength_reduction(scene, cracks)
    while True:
        try:
            solution = next(found)
        except StopIteration as stop:
            safety: Safety = stop.value
            return RunEnd("completed", str(safety), paths_of(cracks), safety=safety)
        if step >= begun.step:  # those before were told of when they were solved first
            yield _reported(RunState(step, cracks), solution, chosen), solution
        step += 1


def _reported(state: RunState, solution: StepSolution, chosen: Ints) -> StepResult:
    """The step's result; frames are made where files or figures can want them."""
    output = solution.scene.case.output
    result = step_result(state, solution, chosen, output.frames != "none" or output.figures)
    solved = replace(
        state,
        origin=solution.origin,
        factorizations=solution.factorizations,
        notes=solution.notes,
        accuracy=solution.accuracy,
    )
    return replace(result, checkpoint=packed(solved))


def _stopped(solution: StepSolution, step: int, n_pieces: int) -> RunEnd:
    """The end of a run whose cracks don't grow any more; `n_pieces` of rock there were at the start."""
    largest, paths = site_criticality(solution).max(initial=-np.inf), paths_of(solution.cracks)
    law = solution.scene.case.subcritical
    if NEVER_CRITICAL in solution.notes:
        return RunEnd("arrested", f"step {step}: {NEVER_CRITICAL}", paths)
    if largest > -np.inf and law is not None:
        most = f"the most critical is at {largest:.3g} of its toughness, the threshold is {law.threshold:g}"
        return RunEnd("arrested", f"step {step}: no tip has a velocity; {most}", paths)
    if largest > -np.inf:
        nothing = f"step {step}: no tip meets the criterion" if step else "nothing grew: no tip meets the criterion"
        return RunEnd("arrested", f"{nothing}{_nearness(solution)}", paths)
    return _without_tips(solution, step, n_pieces)


def _nearness(solution: StepSolution) -> str:
    """How near to growth the tips are, in words; empty where there is none that can grow."""
    largest = site_criticality(solution).max(initial=-np.inf)
    at = f"{largest:.3g} of the strength at load factor {solution.state.factor:.4g}"
    return f"; the most critical is at {at}" if largest > -np.inf else ""


def _without_tips(solution: StepSolution, step: int, n_pieces: int) -> RunEnd:
    """The end of a run in which no tip is left; `n_pieces` of rock there were at the start."""
    stopped, paths = f"step {step}: no tip is left that could grow", paths_of(solution.cracks)
    n_left = len(all_pieces(solution.cover))
    if n_left > n_pieces:
        cut = f"the cracks have cut the rock into {n_left} pieces, {n_pieces} at the start"
        return RunEnd("broke_through", f"{stopped}; {cut}", paths)
    return RunEnd("arrested", stopped, paths)
