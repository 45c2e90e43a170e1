"""How a configuration is loaded: by loads in turn, up to the critical one, or on from the step before."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import chain, islice

from crackgrow.case.model import CriticalLoad, LoadHistory, Stages
from crackgrow.errors import NotSolvedError
from crackgrow.fracture.advance import GrowingCrack
from crackgrow.run.configuration import Configuration, assemble
from crackgrow.run.critical_load import critically_loaded
from crackgrow.run.evaluation import StepSolution, evaluated, with_ranges
from crackgrow.run.increments import FROM_REST, LoadState, Origin, held_loads, increment, mapped, next_load
from crackgrow.run.scene import Scene, scene_of_stage
from crackgrow.run.stages import next_stage
from crackgrow.run.state_values import history_of

States = Iterator[tuple[LoadState, Origin]]
"""States in turn, and what each goes on from."""


@dataclass(frozen=True, slots=True, eq=False)
class NextStepSolver:
    """The cracks under the last load of the case, on any cells: the step after the one `before`, if there is one."""

    cracks: tuple[GrowingCrack, ...]
    before: StepSolution | None  # its state is gone on from where steps do not start unloaded

    def solve(self, scene: Scene, origin: Origin | None = None) -> StepSolution:
        """The step. Raises GeometryError or SolveError where a state can't be solved.

        A step that was solved before has the `origin` that it had then.
        """
        if isinstance(scene.case.loading, Stages):  # every step begins with the first of them
            return replace(_solved(_in_turn(scene, self.cracks)), origin=FROM_REST)
        configuration = assemble(scene, self.cracks)
        origin = origin or self._origin(configuration)
        if origin.start is not None:
            state = increment(configuration, origin.start, origin.start.level.factor)
            solution = _solved(iter([(state, origin)]))
        elif isinstance(scene.case.loading, CriticalLoad):
            solution = critically_loaded(configuration, origin.guess)
        elif scene.case.growth is not None and scene.case.growth.fatigue is not None:
            states = _in_turn(scene, self.cracks, configuration=configuration)
            first = next(states)
            solution, origin = with_ranges(_solved(chain([first], states)), first[0]), FROM_REST  # begun unloaded
        else:
            solution = _solved(_in_turn(scene, self.cracks, configuration=configuration))
        return replace(solution, origin=origin)

    def companion(self, scene: Scene, solution: StepSolution) -> tuple[StepSolution, float]:
        """The solution on the cells of a companion at the load factor of the step, and the factor of its own path.

        Where bonds break at a critical load, which they do at another one there, it is that of its own path.
        """
        solution.configuration.contact.release()  # memory holds the factors of one mesh
        own, factor = self.solve(scene), solution.factor
        if isinstance(scene.case.loading, CriticalLoad) and own.factor == factor:
            return own, math.nan  # both are the first guess: the criterion is never met, or no tip can grow
        if own.factor == factor or any(solution.jumps):
            return own, own.factor
        start = held_loads(own.configuration)
        return evaluated(increment(own.configuration, start, factor)), own.factor

    def _origin(self, configuration: Configuration) -> Origin:
        """What a configuration goes on from."""
        if self.before is None:
            return FROM_REST
        growth = configuration.scene.case.growth
        on = growth is not None and not growth.unload_between_steps
        return Origin(self.before.factor, mapped(self.before, configuration) if on else None)


def load(scene: Scene, cracks: tuple[GrowingCrack, ...], before: StepSolution | None = None) -> StepSolution:
    """The cracks under the last load of the case, after the step `before`. Raises as `NextStepSolver.solve` does."""
    return NextStepSolver(cracks, before).solve(scene)


class LoadsInTurn:
    """The cracks at every factor of the case's history, or at the end of every stage."""

    def __init__(
        self,
        scene: Scene,
        cracks: tuple[GrowingCrack, ...],
        first: int = 0,
        origin: Origin = FROM_REST,
    ) -> None:
        """From number `first` on, whose `origin` is given."""
        self.scene, self._next = scene, first
        self._states = _in_turn(scene, cracks, first, origin)

    def solution(self, number: int) -> StepSolution:
        """The solution under a load that has not been asked for.

        Raises GeometryError or SolveError where there is none.
        """
        n, self._next = number + 1 - self._next, number + 1
        return _solved(self._states, n)


@dataclass(slots=True, eq=False)
class HistorySolver:
    """Loads in turn, or stages, on the cells of now and on those of the companion: the same history on both.

    Where cells are refined all loads before are gone through again: contact remembers them, and rock is taken out on
    the cells that it was loaded on.
    """

    cracks: tuple[GrowingCrack, ...]
    here: LoadsInTurn
    there: LoadsInTurn | None = None
    number: int = 0  # of the load

    def solve(self, scene: Scene) -> StepSolution:
        """The solution on other cells. Where there is none the next loads go on with the cells of now."""
        other = LoadsInTurn(scene, self.cracks)
        solution = other.solution(self.number)
        self.here = other
        return solution

    def companion(self, scene: Scene, solution: StepSolution) -> tuple[StepSolution, float]:
        """The solution on the cells of the companion, and its load factor."""
        last = self.number + 1 == scene.case.n_loads
        if last:
            solution.configuration.contact.release()  # memory holds the factors of one mesh
        if self.there is None or scene.grading != self.there.scene.grading:
            self.there = LoadsInTurn(scene, self.cracks)
        there = self.there.solution(self.number)
        if last:
            there.configuration.contact.release()
        return there, there.factor


def _in_turn(
    scene: Scene,
    cracks: tuple[GrowingCrack, ...],
    first: int = 0,
    origin: Origin = FROM_REST,
    configuration: Configuration | None = None,
) -> States:
    """States at every factor of the case's history, or at the end of every stage, in turn, from number `first` on.

    The `configuration` of a history may be at hand; `scene` may be that of any stage. Raises GeometryError or
    SolveError where there is no state.
    """
    loading, state = scene.case.loading, None
    assert isinstance(loading, LoadHistory | Stages)  # others have searches of their own
    scene = scene.at_start.with_cracks(cracks) if isinstance(loading, Stages) else scene
    for number in range(first, scene.case.n_loads):
        here = scene_of_stage(scene, number) if isinstance(loading, Stages) else scene
        if state is None:
            configuration = (configuration or assemble(here, cracks)).with_excavated(origin.excavated)
        elif isinstance(loading, Stages):
            configuration, origin = next_stage(state, origin, here)
        else:
            origin = Origin(start=next_load(state))
        assert configuration is not None
        factor = number + 1.0 if isinstance(loading, Stages) else loading.factors[number]
        state = increment(configuration, origin.start or held_loads(configuration), factor)
        yield state, origin


def _solved(states: States, n: int | None = None) -> StepSolution:
    """The solution of the n-th of the next states; or of the last one, with all of its history."""
    passed: tuple[LoadState, ...] = ()
    number = 0
    for state, origin in islice(states, n):
        number, came_from = number + 1, origin
        passed = (*(passed if n is None else ()), *history_of(state))
    if number < (n or 1):
        raise NotSolvedError("an earlier load of the history has no solution on these cells")
    return replace(evaluated(state), origin=came_from, passed=passed[:-1])
