"""How a configuration is loaded: through a history of factors, up to the critical one, or on from the step before."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from crackgrow.case.model import CriticalLoad, LoadHistory
from crackgrow.fracture.advance import GrowingCrack
from crackgrow.run.configuration import Configuration, assemble
from crackgrow.run.critical_load import critically_loaded
from crackgrow.run.increments import LoadState, carried, from_state, held_loads, increment
from crackgrow.run.scene import Scene
from crackgrow.run.step import StepSolution, judged


def load(scene: Scene, cracks: tuple[GrowingCrack, ...], before: StepSolution | None = None) -> StepSolution:
    """The cracks under the last load of the case.

    `before` is the step before, whose state is gone on from where steps do not start unloaded. Raises GeometryError or
    SolveError where a state can't be solved.
    """
    configuration = assemble(scene, cracks, None if before is None else before.configuration)
    loading, growth = scene.case.loading, scene.case.growth
    if before is not None and growth is not None and not growth.unload_between_steps:
        return judged(increment(configuration, carried(before.state, configuration), before.state.factor))
    if isinstance(loading, CriticalLoad):
        return critically_loaded(configuration, cracks, 1.0 if before is None else before.state.factor)
    *_, last = _history(configuration, loading)
    return judged(last)


def load_history(scene: Scene, cracks: tuple[GrowingCrack, ...]) -> Iterator[StepSolution]:
    """The cracks at every factor of the case's history, in turn."""
    assert isinstance(scene.case.loading, LoadHistory)
    configuration = assemble(scene, cracks)
    for number, state in enumerate(_history(configuration, scene.case.loading)):
        solution = judged(state)
        if number:  # the configuration was paid for by the first state
            solution = replace(
                solution, seconds={**solution.seconds, **dict.fromkeys(configuration.seconds, 0.0)}, factorizations=0
            )
        yield solution


def _history(configuration: Configuration, history: LoadHistory) -> Iterator[LoadState]:
    start = held_loads(configuration)
    for factor in history.factors:
        state = increment(configuration, start, factor)
        yield state
        start = from_state(state)
