"""How a configuration is loaded: through a history of factors, up to the critical one, or on from the step before."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from crackgrow.case.model import CriticalLoad, LoadHistory, Stages
from crackgrow.fracture.advance import GrowingCrack
from crackgrow.run.configuration import Configuration, assemble
from crackgrow.run.critical_load import critically_loaded
from crackgrow.run.history import history_of
from crackgrow.run.increments import FROM_REST, LoadState, Origin, carried, from_state, held_loads, increment
from crackgrow.run.judging import StepSolution, judged
from crackgrow.run.scene import Scene
from crackgrow.run.stages import load_stages, through_stages


def load(
    scene: Scene,
    cracks: tuple[GrowingCrack, ...],
    before: StepSolution | None = None,
    like: Configuration | None = None,
) -> StepSolution:
    """The cracks under the last load of the case.

    `before` is the step before, whose state is gone on from where steps do not start unloaded. `like` is a
    configuration that has more in common with this one than that step's. Raises GeometryError or SolveError where a
    state can't be solved.
    """
    if isinstance(scene.case.loading, Stages):
        return through_stages(scene, cracks)
    known = before.configuration if like is None and before is not None else like
    configuration = assemble(scene, cracks, known)
    return _loaded(configuration, _origin(configuration, before))


def load_to(
    scene: Scene,
    cracks: tuple[GrowingCrack, ...],
    factor: float,
    before: StepSolution | None,
    like: Configuration | None,
) -> LoadState:
    """The state at a load factor that `load` would give with it as the critical one, or the last of several.

    `like` is a configuration that may have parts in common with this one. Raises as `load` does.
    """
    if isinstance(scene.case.loading, Stages):
        return through_stages(scene, cracks).state
    configuration = assemble(scene, cracks, like)
    origin = _origin(configuration, before)
    if origin.start is not None:
        return increment(configuration, origin.start, origin.start.factor)
    if isinstance(scene.case.loading, CriticalLoad):
        return increment(configuration, held_loads(configuration), factor)
    assert isinstance(scene.case.loading, LoadHistory)  # reduced strength has a search of its own
    return _through_history(configuration, scene.case.loading)[0]


def load_again(scene: Scene, cracks: tuple[GrowingCrack, ...], origin: Origin) -> StepSolution:
    """What `load` has made of the cracks, from the origin of that solution. Raises as it does."""
    if isinstance(scene.case.loading, Stages):
        return through_stages(scene, cracks)  # every step begins with the first of them
    return _loaded(assemble(scene, cracks), origin)


def load_history(
    scene: Scene,
    cracks: tuple[GrowingCrack, ...],
    first: int = 0,
    origin: Origin | None = None,
    like: Configuration | None = None,
) -> Iterator[StepSolution]:
    """The cracks at every factor of the case's history, or at the end of every stage, in turn.

    From number `first` on, whose `origin` is given. `like` is a configuration that has much in common with this one.
    """
    if isinstance(scene.case.loading, Stages):
        yield from load_stages(scene, cracks, first, origin)
        return
    assert isinstance(scene.case.loading, LoadHistory)
    configuration = assemble(scene, cracks, like)
    start = None if origin is None else origin.start
    for number, factor in enumerate(scene.case.loading.factors[first:], first):
        origin = Origin(start=start)
        state = increment(configuration, held_loads(configuration) if start is None else start, factor)
        solution = replace(judged(state), origin=origin, passed=history_of(state)[:-1])
        if number:  # the configuration was paid for by the first state
            solution = replace(solution, factorizations=0)
        if number > first:
            solution = replace(solution, seconds={**solution.seconds, **dict.fromkeys(configuration.seconds, 0.0)})
        yield solution
        start = from_state(state)


def _origin(configuration: Configuration, before: StepSolution | None) -> Origin:
    """What a configuration goes on from after the step before."""
    if before is None:
        return FROM_REST
    growth = configuration.scene.case.growth
    on = growth is not None and not growth.unload_between_steps
    return Origin(before.state.factor, carried(before.state, configuration) if on else None)


def _loaded(configuration: Configuration, origin: Origin) -> StepSolution:
    """A configuration under the last load of the case."""
    loading = configuration.scene.case.loading
    if origin.start is not None:
        solution = judged(increment(configuration, origin.start, origin.start.factor))
    elif isinstance(loading, CriticalLoad):
        solution = critically_loaded(configuration, origin.guess)
    else:
        assert isinstance(loading, LoadHistory)
        state, passed = _through_history(configuration, loading)
        solution = replace(judged(state), passed=passed)
    return replace(solution, origin=origin)


def _through_history(configuration: Configuration, loading: LoadHistory) -> tuple[LoadState, tuple[LoadState, ...]]:
    """The state at the end of a history, and those that led to it where the case asks for them."""
    start = held_loads(configuration)
    states: list[LoadState] = []
    for factor in loading.factors:
        state = increment(configuration, start, factor)
        start = from_state(state)
        states += history_of(state)
    return state, tuple(states[:-1])
