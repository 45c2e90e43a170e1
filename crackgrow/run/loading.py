"""How a configuration is loaded: through a history of factors, or up to the factor at which the criterion is just met.

Between two load factors with the same contact states everything is linear in the factor: stresses, K, tractions. The
critical factor is found on the line between the states at both ends of an interval, and solved for; once no contact
point changes its state inside of the interval, the line is exact. Where contact that breaks makes everything jump, the
factor at which it breaks is foreseen on the line that its tractions follow before. Every factor is reached in one
increment from the state of the held loads alone.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from crackgrow.case.model import CriticalLoad, LoadHistory
from crackgrow.contact.coulomb import STICK
from crackgrow.contact.solve import ContactLaw, ContactOutcome
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

LAZY = 3
"""An interval is halved after the line has moved one of its ends so many times in turn."""

MET = 1e-9
"""The criterion is just met where the criticality differs from 1 by less than this."""

NARROW = 1e-9
"""An interval of load factors is a single one below this fraction."""

NEAR_CHANGE = 1e-10
"""So far beside the factor at which a contact point should slip, as a fraction of it, it is tried whether it does."""

SMALL_SHARE = 1e-3
"""Of a load factor: contact is taken to do there what it does under the smallest loads."""

NEVER_CRITICAL = f"no load factor up to {LARGEST_FACTOR:g} meets the criterion at any tip"


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
    solution is the one at the guess, and its notes say so. Where contact that breaks makes the criticality jump past
    1, it is the first one behind the jump. Raises SolveError where the search does not settle.
    """
    search = _Search(configuration, cracks)
    first = above = search.at(guess)
    if not search.can_grow.any() or search.meets(above):
        return search.found(above)
    below = search.at(0.0)
    if search.criticality(below) >= 1.0:
        raise SolveError("the criterion is met under the held loads alone: no critical load factor; hold smaller loads")
    while search.criticality(above) < 1.0:
        if above.state.factor >= LARGEST_FACTOR:
            return replace(search.found(first), notes=(NEVER_CRITICAL,))
        factor = search.beyond(below, above)
        below, above = above, search.at(factor)
        if search.meets(above):
            return search.found(above)
    halved = 0  # times that one end has been replaced in turn, negative for the upper one
    while len(search.seconds) < MOST_TRIALS:
        low, high = below.state.factor, above.state.factor
        if high - low <= NARROW * high:
            return search.found(above)
        share = search.share_met(below, above) if abs(halved) < LAZY else 0.5
        trial = search.at(search.first_change(below, above) or low + share * (high - low))
        if search.meets(trial):
            return search.found(trial)
        if search.criticality(trial) < 1.0:
            below, halved = trial, max(halved, 0) + 1
        else:
            above, halved = trial, min(halved, 0) - 1
        halved = 0 if abs(halved) > LAZY else halved
    raise SolveError(f"no critical load factor found between {below.state.factor:.12g} and {above.state.factor:.12g}")


class _Search:
    """The search for a critical load factor on one configuration: trials, and guesses of the next one."""

    def __init__(self, configuration: Configuration, cracks: Sequence[GrowingCrack]) -> None:
        self._configuration = configuration
        self._held = _held_loads(configuration)
        self._tried: list[StepSolution] = []
        self._expected: set[float] = set()  # factors at which contact was expected to change
        self.seconds: list[dict[str, float]] = []
        ends = configuration.cover.tip_ends
        self.can_grow = np.array([cracks[index].can_grow(end) for index, end in ends], dtype=bool)

    def at(self, factor: float) -> StepSolution:
        """The solution at a load factor."""
        trial = judged(increment(self._configuration, self._held, factor))
        self._tried.append(trial)
        self.seconds.append(trial.seconds)
        return trial

    def found(self, trial: StepSolution) -> StepSolution:
        """A trial that ends the search, with the time of all of them."""
        spent = {phase: sum(seconds[phase] for seconds in self.seconds) for phase in ("contact", "criterion")}
        return replace(trial, seconds={**trial.seconds, **spent})

    def criticality(self, trial: StepSolution) -> float:
        """Largest criticality of the tips that can grow."""
        return largest_criticality(trial, self.can_grow)

    def meets(self, trial: StepSolution) -> bool:
        """Whether the criterion is just met."""
        return bool(self.can_grow.any()) and abs(self.criticality(trial) - 1.0) <= MET

    def beyond(self, below: StepSolution, above: StepSolution) -> float:
        """The next factor where the criterion is met at neither of two: where it would be if all were linear."""
        low, high = below.state.factor, above.state.factor
        excess, farthest = self._excess(below, above), (LARGEST_FACTOR - low) / (high - low)
        share = 1.0
        while share < farthest:
            nearer, share = share, min(STRIDE * share, farthest)
            if excess(share) >= 0.0:
                return low + float(brentq(excess, nearer, share, xtol=1e-16, rtol=1e-14)) * (high - low)
        return min(STRIDE * high, LARGEST_FACTOR)

    def share_met(self, below: StepSolution, above: StepSolution) -> float:
        """Where, from 0 to 1, the criterion is just met if everything is linear between two states."""
        return float(brentq(self._excess(below, above), 0.0, 1.0, xtol=1e-16, rtol=1e-14))

    def _excess(self, below: StepSolution, above: StepSolution) -> Callable[[float], float]:
        """Largest criticality less 1, at a share of the way from one state to the other."""
        case, crack_bodies = self._configuration.scene.case, self._configuration.scene.crack_bodies
        assert case.growth is not None
        criterion = CRITERIA[case.growth.criterion]
        pairs = []
        for tip in np.flatnonzero(self.can_grow).tolist():
            limits = case.bodies[crack_bodies[below.cover.tip_ends[tip][0]]].strength
            first, last = below.tips[tip].loading, above.tips[tip].loading
            if limits is not None and first is not None and last is not None:
                pairs.append((first, last, limits))
        return lambda share: (
            max(criterion(TipLoading.between(a, b, share), limits).criticality for a, b, limits in pairs) - 1.0
        )

    def first_change(self, below: StepSolution, above: StepSolution) -> float | None:
        """A factor just before or behind the one where a sticking point first slips, between two; None where unknown.

        The point comes to its limit on the line through two states with the same contact points.
        """
        low, high = below.state.factor, above.state.factor
        law, state = self._configuration.contact.law, below.outcome.state
        sticks = state == STICK if low > 0.0 else law.cohesion > 0.0
        if not (sticks & (above.outcome.state != STICK)).any():
            return None
        alike = [trial for trial in self._tried if trial is not below and _is_alike(trial.outcome, below.outcome)]
        if low == 0.0 or not alike:  # what contact does between is seen best under small loads
            return self._new(max(2.0 * low, SMALL_SHARE * high), low, high)
        share = _share_to_limit(alike[-1], below, law)
        factor = alike[-1].state.factor + share * (low - alike[-1].state.factor)
        sides = (self._new(factor * (1.0 + sense * NEAR_CHANGE), low, high) for sense in (-1.0, 1.0))
        return next((side for side in sides if side is not None), None)

    def _new(self, factor: float, low: float, high: float) -> float | None:
        """A factor, unless it lies outside of an interval or has been given before."""
        if not low < factor < high or factor in self._expected:
            return None
        self._expected.add(factor)
        return factor


def largest_criticality(solution: StepSolution, can_grow: Bools) -> float:
    """Largest criticality of the tips that can grow (tips,)."""
    return max(
        tip.verdict.criticality for tip, grows in zip(solution.tips, can_grow, strict=True) if grows and tip.verdict
    )


def _is_alike(one: ContactOutcome, other: ContactOutcome) -> bool:
    """Whether contact points are in the same states: between the two everything is linear."""
    return np.array_equal(one.state, other.state) and np.array_equal(one.memory.broken, other.memory.broken)


def _share_to_limit(first: StepSolution, last: StepSolution, law: ContactLaw) -> float:
    """Where on the line through two states, beyond the last, the first sticking point comes to Coulomb's limit.

    In shares of the way from the first to the last: more than 1, or inf.
    """
    friction, cohesion = law.bound_of(last.outcome.memory.broken)
    shares = [np.inf]
    for sense in (-1.0, 1.0):
        was, now = (
            sense * trial.outcome.tangential_traction + friction * trial.outcome.normal_traction - cohesion
            for trial in (first, last)
        )
        rising = (last.outcome.state == STICK) & (now > was) & (now < 0.0)
        shares.extend(1.0 - now[rising] / (now - was)[rising])
    return float(min(shares))
