"""How a configuration is loaded: by loads in turn, up to the critical one, or on from the step before.

A stage of a construction is a configuration of its own, of the rock that is left, on the lattice of the whole scene: so
the functions of what is left stay. What a body that is taken out did on it, the forces that bonds, contact and water
between the two carried, goes on acting at first, and falls in proportion to what the stage releases. The strain energy
of the body is released at once.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import chain, islice

import numpy as np

from crackgrow.arrays import Floats, Ints
from crackgrow.case.model import CriticalLoad, FluidPressure, LoadHistory, Stages
from crackgrow.contact.face_loads import face_load_vector
from crackgrow.cover.cover import Cover
from crackgrow.cover.elements import locate
from crackgrow.cover.shapes import body_index
from crackgrow.errors import NotSolvedError
from crackgrow.fracture.advance import GrowingCrack
from crackgrow.quadrature.elements import element_points
from crackgrow.run.configuration import Configuration, Excavated, assemble
from crackgrow.run.critical_load import critically_loaded
from crackgrow.run.evaluation import StepSolution, evaluated, with_ranges
from crackgrow.run.increments import (
    FROM_REST,
    LoadState,
    Origin,
    equilibrated,
    held_loads,
    increment,
    mapped,
    next_load,
)
from crackgrow.run.scene import Scene, scene_of_stage
from crackgrow.run.state_values import face_forces, history_of

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
        growth, before = scene.case.growth, self.before
        if origin is None and before is not None:
            on = growth is not None and not growth.unload_between_steps
            origin = Origin(before.factor, mapped(before, configuration) if on else None)
        origin = origin or FROM_REST
        if origin.start is not None:
            solution = evaluated(increment(configuration, origin.start, origin.start.level.factor))
        elif isinstance(scene.case.loading, CriticalLoad):
            solution = critically_loaded(configuration, origin.guess)
        elif growth is not None and growth.fatigue is not None:
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


def load(scene: Scene, cracks: tuple[GrowingCrack, ...], before: StepSolution | None = None) -> StepSolution:
    """The cracks under the last load of the case, after the step `before`. Raises as `NextStepSolver.solve` does."""
    return NextStepSolver(cracks, before).solve(scene)


class LoadsInTurn:
    """The cracks at every factor of the case's history, or at the end of every stage."""

    def __init__(
        self, scene: Scene, cracks: tuple[GrowingCrack, ...], first: int = 0, origin: Origin = FROM_REST
    ) -> None:
        """From number `first` on, whose `origin` is given."""
        self.scene, self._next = scene, first
        self._states = _in_turn(scene, cracks, first, origin)

    def solution(self, number: int) -> StepSolution:
        """The solution under a load not asked for yet. Raises GeometryError or SolveError where there is none."""
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
            configuration, origin = _next_stage(state, origin, here)
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
    for each in islice(states, n):
        number, (state, came_from) = number + 1, each
        before, passed = passed, (*passed, *history_of(state)) if n is None else ()
    if number < (n or 1):
        raise NotSolvedError("an earlier load of the history has no solution on these cells")
    return replace(evaluated(state), origin=came_from, passed=before)


def _next_stage(state: LoadState, origin: Origin, here: Scene) -> tuple[Configuration, Origin]:
    """The configuration of the next stage, whose scene is given, and where it starts from.

    Raises GeometryError or SolveError where it has no state.
    """
    before = state.configuration
    configuration = assemble(here, before.cracks)
    left = {body.name for body in here.case.bodies}
    newly = [body.name for body in before.scene.case.bodies if body.name not in left]
    excavated = (*origin.excavated, *(Excavated(body, _held_by(state, body)) for body in newly))
    if newly:
        same = _same_functions(before.cover, configuration.cover)
        unknowns = (2 * same[:, None] + np.arange(2)).ravel()
        excavated = tuple(replace(rock, forces=rock.forces[unknowns]) for rock in excavated)
    configuration = configuration.with_excavated(excavated)
    return configuration, Origin(start=equilibrated(state, configuration), excavated=excavated)


def _held_by(state: LoadState, body: str) -> Floats:
    """Forces (n_dofs,) N/m of what is between a body and the rest, on all rock: bonds, contact, water."""
    configuration = state.configuration
    scene, cover = configuration.scene, configuration.cover
    forces = np.zeros(cover.n_dofs)
    for index, surface in enumerate(cover.surfaces):
        if surface.name.bounds({body}):
            forces += face_forces(state, index)
    for load in scene.case.loads:
        if isinstance(load, FluidPressure) and load.surface.bounds({body}):
            forces += scene.share(load, state.factor) * face_load_vector(cover, [], [load])
    return forces


def _same_functions(before: Cover, after: Cover) -> Ints:
    """For every function of the rock that is left its number before other rock was taken out.

    Raises NotSolvedError where the functions are others.
    """
    points = element_points(after, 1)
    elements, first = np.unique(points.element, return_index=True)
    numbers = np.array([body_index(before.bodies, body.name) for body in after.bodies])
    there = locate(before.lattice, before.elements, points.points[first], numbers[after.elements.body[elements]])
    same = np.full(after.n_functions, -1, dtype=np.int64)
    if (there >= 0).all():
        mine, theirs = after.functions.taken(elements), before.functions.taken(there)
        if np.array_equal(mine.counts, theirs.counts):
            same[mine.values] = theirs.values
            if (same >= 0).all() and np.array_equal(same[mine.values], theirs.values):
                return same
    what = "the functions of the rock change where rock is taken out beside it"
    raise NotSolvedError(f"{what}; change numerics.spacing a little")
