"""How a configuration is loaded: through a history of factors, or up to the factor at which the criterion is just met.

Between two load factors with the same contact states everything is linear in the factor: stresses, K, tractions. The
critical factor is found on the line between the states at both ends of an interval, and solved for; once no contact
point changes its state inside of the interval, the line is exact. Every factor is reached in one increment from the
state of the held loads alone.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from crackgrow.case.model import CriticalLoad, LoadHistory
from crackgrow.errors import SolveError
from crackgrow.fracture.advance import GrowingCrack
from crackgrow.fracture.criteria import CRITERIA, TipLoading
from crackgrow.run.configuration import Configuration, assemble
from crackgrow.run.increments import LoadState, Start, carried, from_state, increment, unloaded
from crackgrow.run.scene import Scene
from crackgrow.run.step import StepSolution, judged

Bools = NDArray[np.bool_]

LARGEST_FACTOR = 1e6
"""Load factors beyond this are not tried."""

STRIDE = 4.0
"""Factor by which the load grows until the criterion is met."""

MOST_TRIALS = 60
"""Trial factors of one step."""

MET = 1e-9
"""The criterion is just met where the criticality differs from 1 by less than this."""

NARROW = 1e-13
"""An interval of load factors is a single one below this fraction."""


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
    start = _held_loads(configuration)
    for factor in history.factors:
        state = increment(configuration, start, factor)
        yield state
        start = from_state(state)


def _held_loads(configuration: Configuration) -> Start:
    """The state of the held loads alone, which come first where contact remembers anything."""
    start, law = unloaded(configuration), configuration.contact.law
    remembers = (law.friction > 0.0) | (law.cohesion > 0.0)
    if configuration.constant.any() and remembers.any():
        return from_state(increment(configuration, start, 0.0))
    return start


def critically_loaded(configuration: Configuration, cracks: Sequence[GrowingCrack], guess: float) -> StepSolution:
    """The configuration at the load factor at which the criterion is just met at the first of the tips that can grow.

    `guess` > 0 is the first factor that is tried. Where no factor up to `LARGEST_FACTOR` meets the criterion, the
    solution is the one at the guess, and its notes say so. Raises SolveError where the search does not settle.
    """
    start = _held_loads(configuration)
    can_grow = np.array([cracks[index].can_grow(end) for index, end in configuration.cover.tip_ends], dtype=bool)
    trial = judged(increment(configuration, start, guess))
    if not can_grow.any():
        return trial
    first, spent = trial, 0.0
    below, above = judged(increment(configuration, start, 0.0)), trial
    if largest_criticality(below, can_grow) >= 1.0:
        raise SolveError("the criterion is met under the held loads alone: no critical load factor")
    while largest_criticality(above, can_grow) < 1.0:
        if above.state.factor > LARGEST_FACTOR:
            return replace(first, notes=(f"no load factor up to {LARGEST_FACTOR:g} meets the criterion at any tip",))
        below, above = above, judged(increment(configuration, start, STRIDE * above.state.factor))
        spent += above.seconds["contact"]
    low_side = 0
    for _ in range(MOST_TRIALS):
        low, high = below.state.factor, above.state.factor
        if high - low <= NARROW * high:
            return above
        share = _share_met(below, above, can_grow) if abs(low_side) < 3 else 0.5
        trial = judged(increment(configuration, start, low + share * (high - low)))
        spent += trial.seconds["contact"]
        reached = largest_criticality(trial, can_grow)
        if abs(reached - 1.0) <= MET:
            return replace(trial, seconds={**trial.seconds, "contact": spent})
        if reached < 1.0:
            below, low_side = trial, max(low_side, 0) + 1
        else:
            above, low_side = trial, min(low_side, 0) - 1
        if abs(low_side) > 3:
            low_side = 0
    raise SolveError(f"no critical load factor found between {below.state.factor:.12g} and {above.state.factor:.12g}")


def largest_criticality(solution: StepSolution, can_grow: Bools) -> float:
    """Largest criticality of the tips that can grow (tips,)."""
    return max(
        tip.verdict.criticality for tip, grows in zip(solution.tips, can_grow, strict=True) if grows and tip.verdict
    )


def _share_met(below: StepSolution, above: StepSolution, can_grow: Bools) -> float:
    """Where, from 0 to 1, the criterion is just met if everything is linear between two states."""
    scene = below.configuration.scene
    assert scene.case.growth is not None
    criterion = CRITERIA[scene.case.growth.criterion]
    pairs = []
    for tip in np.flatnonzero(can_grow).tolist():
        strength = scene.case.bodies[scene.crack_bodies[below.cover.tip_ends[tip][0]]].strength
        first, last = below.tips[tip].loading, above.tips[tip].loading
        if strength is not None and first is not None and last is not None:
            pairs.append((first, last, strength))

    def excess(share: float) -> float:
        return max(criterion(TipLoading.between(a, b, share), limits).criticality for a, b, limits in pairs) - 1.0

    return float(brentq(excess, 0.0, 1.0, xtol=1e-16, rtol=1e-14))
