"""The growth loop: load, evaluate the criterion, advance; one result a step."""

from __future__ import annotations

from collections.abc import Callable, Generator
from contextlib import suppress
from dataclasses import replace
from functools import partial
from typing import TypeVar

import numpy as np

from crackgrow.accuracy.companion import BOUND
from crackgrow.blas import single_threaded
from crackgrow.case.model import Case, Growth, Stages, StrengthReduction
from crackgrow.case.on_map import on_map
from crackgrow.errors import GeometryError, SolveError
from crackgrow.run.checkpoint import RunState, beginning, packed, restored
from crackgrow.run.clock import SPENT
from crackgrow.run.deflection import Way, way_on
from crackgrow.run.evaluation import StepSolution
from crackgrow.run.growth import Advances, chosen_advances, ended, time_of, unsolved
from crackgrow.run.increments import FROM_REST
from crackgrow.run.loading import HistorySolver, LoadsInTurn, NextStepSolver, load
from crackgrow.run.propagation import BeforeAdvance, advance_debonds, advance_tips
from crackgrow.run.report import estimate_maker, step_result
from crackgrow.run.result import Checkpoint, RunEnd, StepResult
from crackgrow.run.scene import Scene, make_scene
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
    steps = solved_steps(case, checkpoint)
    while True:
        try:
            yield next(steps)[0]
        except StopIteration as stop:
            end: RunEnd = stop.value
            return end


def for_each(steps: Generator[Item, None, Returned], each: Callable[[Item], object]) -> Returned:
    """Hand each step on as it comes; return what the steps return."""
    while True:
        try:
            step = next(steps)
        except StopIteration as stop:
            end: Returned = stop.value
            return end
        each(step)


def solved_steps(case: Case, checkpoint: Checkpoint | None = None) -> Steps:
    """As `grow`, each result with the solution that it tells of; linear algebra has one thread while steps are made.

    Places of results are those of the map, if the case has one; what is computed, and checkpoints, are at its origin.
    The error of the last step is estimated as it is known to be the last.
    """
    with single_threaded():
        begun = beginning(case) if checkpoint is None else restored(case, checkpoint)
        scene = make_scene(case).with_debonds(begun.debonds)
        if begun.errors is not None:
            scene = scene.with_grading(begun.errors.grading)
    if isinstance(case.loading, StrengthReduction):
        steps = _reduced(scene, begun)
    else:
        steps = _static(scene, begun) if case.growth is None else _growth(scene, case.growth, begun)
    last: tuple[StepResult, StepSolution] | None = None
    while True:
        with single_threaded():
            SPENT.begin()
            try:
                last = next(steps)
            except StopIteration as stop:
                end: RunEnd = stop.value
                if last is not None:
                    error = last[0].norm_error
                    error = estimate_maker(last[1])().relative if np.isnan(error) else error
                    end = replace(end, norm_error=error)
                return on_map(end, case.origin)
        result, solution = last
        yield on_map(result, case.origin), solution


def _growth(scene: Scene, growth: Growth, begun: RunState) -> Steps:
    """The steps of a run with growth."""
    scene, state, advances = scene.with_cracks(begun.cracks), begun, Advances(begun.cracks)
    known, before = None, None
    if begun.origin is not None:  # it was solved before: the search for its direction of growth is not repeated
        known = NextStepSolver(begun.cracks, None).solve(scene, begun.origin)
        known = replace(known, doubts=begun.doubts, errors=begun.errors)
    while True:
        if before is not None:
            before.configuration.contact.release()  # memory holds the factors of one step
        try:
            solution = known or load(scene, state.cracks, before)
        except (GeometryError, SolveError) as error:
            if state.step == 0:
                raise
            return unsolved(state, error)
        if scene.case.numerics.measured and solution.errors is None:
            solver = NextStepSolver(solution.cracks, before)
            solution = solved_to_target(solution, solver)
        scene = scene.with_grading(next_grading(solution))
        time, cracks, doubts = time_of(advances, solution, state.cracks)
        solution = replace(solution, doubts=(*solution.doubts, *doubts))
        n_pieces = state.n_pieces or len(all_pieces(solution.cover))
        state = replace(state, cracks=cracks, n_pieces=n_pieces, time=state.time + time)
        grows_on = state.step < growth.steps
        solved = solution
        solution, way, told = way_on(solved, state.step + 1) if grows_on else (solved, Way(), [])
        goes_on, alone = bool(way.debonds or way.cracks), growth.advance != "all"
        chooses = grows_on and not (goes_on and alone)
        advances = chosen_advances(growth, solution, state.cracks) if chooses else Advances(state.cracks)
        yield _reported(state, solution, advances, solved), solution
        if len(advances.sites) == 0 and not goes_on:
            end = ended(state, solution, growth)
            return replace(end, events=(*told, *end.events))
        debonds, met = advance_debonds(solution, advances.sites, state.step + 1, way.debonds)
        debonds = (*debonds, *way.debonds)
        scene = scene.with_debonds(debonds)
        cracks = (*advances.cracks, *way.cracks)
        at = BeforeAdvance(solution.scene, cracks, state.step + 1, advances.lengths)
        advance = advance_tips(at, solution, advances.sites, partial(load, scene, before=solution))
        events = (*told, *met, *advance.events)
        state = RunState(state.step + 1, advance.cracks, events, state.n_pieces, time=state.time, debonds=debonds)
        scene, known, before = scene.with_cracks(advance.cracks), advance.solution, solution


def _static(scene: Scene, begun: RunState) -> Steps:
    """The load factors of the history, or the stages, in turn, without growth."""
    cracks, n = begun.cracks, scene.case.n_loads
    solver = HistorySolver(cracks, LoadsInTurn(scene, cracks, begun.step, begun.origin or FROM_REST))
    for step in range(begun.step, n):
        solver.number, solution = step, solver.here.solution(step)
        if step == begun.step and begun.origin is not None:  # it was solved before
            solution = replace(solution, errors=begun.errors)
        elif scene.case.numerics.measured:
            solution = solved_to_target(solution, solver)
        yield _reported(begun.at_load(step), solution), solution
    done = f"all {n} {'stages' if isinstance(scene.case.loading, Stages) else 'load factors'} are done"
    return RunEnd("completed", "the static solve is done" if n == 1 else done, begun.paths)


def _reduced(scene: Scene, begun: RunState) -> Steps:
    """The scene as it is, if it holds, and its last stable state while its strength is reduced."""
    safety, solutions = strength_reduction(scene, begun.cracks)
    if scene.case.numerics.measured:
        companion = scene.with_grading(replace(scene.grading, companion=True))
        with suppress(GeometryError, SolveError):
            other = strength_reduction(companion, begun.cracks)[0].factor
            if np.isfinite([other, safety.factor]).all():
                safety = replace(safety, error=100.0 * (BOUND * abs(other / safety.factor - 1.0) + NARROW))
    for step, solution in enumerate(solutions):
        if step >= begun.step:  # those before were told of when they were solved first
            yield _reported(begun.at_load(step), solution), solution
    return RunEnd("completed", str(safety), begun.paths, safety=safety)


def _reported(
    state: RunState, solution: StepSolution, advances: Advances | None = None, solved: StepSolution | None = None
) -> StepResult:
    """The step's result, with what a run can go on from: the solution as it was `solved`, or itself."""
    output = solution.scene.case.output
    result = step_result(state, solution, advances or Advances(state.cracks), output.frames != "none" or output.figures)
    return replace(result, checkpoint=packed(replace(state, factorizations=result.factorizations), solved or solution))
