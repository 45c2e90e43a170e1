"""The load factor at which the criterion is just met.

Between two load factors with the same contact states everything is linear in the factor: stresses, K, tractions. The
critical factor is found on the line between the states at both ends of an interval, and solved for; once no contact
point changes its state inside of the interval, the line is exact. Where contact that breaks makes everything jump, the
factor at which it breaks is foreseen on the line that its tractions follow before. Every factor is reached in one
increment from the state of the held loads alone. Of a trial only what the criterion goes by is evaluated.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from crackgrow.contact.coulomb import STICK
from crackgrow.contact.law import ContactLaw
from crackgrow.errors import SolveError
from crackgrow.fracture.advance import GrowingCrack
from crackgrow.fracture.criteria import GO_BY_K, TipLoading
from crackgrow.run.configuration import Configuration, timed
from crackgrow.run.increments import LoadState, held_loads, increment
from crackgrow.run.step import StepSolution, judged, stress_fields, tip_states, verdict

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
    below = search.at_rest(above)
    if below.criticality >= 1.0:
        raise SolveError("the criterion is met under the held loads alone: no critical load factor; hold smaller loads")
    while above.criticality < 1.0:
        if above.factor >= LARGEST_FACTOR:
            return replace(search.found(first), notes=(NEVER_CRITICAL,))
        factor = search.beyond(below, above)
        below, above = above, search.at(factor)
        if search.meets(above):
            return search.found(above)
    halved = 0  # times that one end has been replaced in turn, negative for the upper one
    while search.n_trials < MOST_TRIALS:
        low, high = below.factor, above.factor
        if high - low <= NARROW * high:
            return search.found(above)
        share = search.share_met(below, above) if abs(halved) < LAZY else 0.5
        trial = search.at(search.first_change(below, above) or low + share * (high - low))
        if search.meets(trial):
            return search.found(trial)
        if trial.criticality < 1.0:
            below, halved = trial, max(halved, 0) + 1
        else:
            above, halved = trial, min(halved, 0) - 1
        halved = 0 if abs(halved) > LAZY else halved
    raise SolveError(f"no critical load factor found between {below.factor:.12g} and {above.factor:.12g}")


@dataclass(frozen=True, slots=True, eq=False)
class _Trial:
    """What is known of a load factor."""

    factor: float
    loadings: list[TipLoading | None]  # tip by tip
    criticality: float  # largest of the tips that can grow
    state: LoadState | None  # None without any load, where everything is zero
    seconds: dict[str, float]


class _Search:
    """The search for a critical load factor on one configuration: trials, and guesses of the next one."""

    def __init__(self, configuration: Configuration, cracks: Sequence[GrowingCrack]) -> None:
        self._configuration = configuration
        self._held = held_loads(configuration)
        self._tried: list[_Trial] = []
        self._expected: set[float] = set()  # factors at which contact was expected to change
        growth = configuration.scene.case.growth
        assert growth is not None
        self._growth = growth
        ends = configuration.cover.tip_ends
        self.can_grow = np.array([cracks[index].can_grow(end) for index, end in ends], dtype=bool)

    @property
    def _states(self) -> list[LoadState]:
        return [trial.state for trial in self._tried if trial.state is not None]

    @property
    def n_trials(self) -> int:
        """Load factors that have been solved for."""
        return len(self._tried)

    def at(self, factor: float) -> _Trial:
        """The state at a load factor."""
        state = increment(self._configuration, self._held, factor)
        scene, seconds = self._configuration.scene, {"contact": state.seconds}
        with timed(seconds, "criterion"):
            materials = scene.materials_at(factor)
            fields = stress_fields(state, materials)
            if self._growth.criterion in GO_BY_K:
                loadings = [tip.loading for tip in tip_states(state, materials, fields)]
            else:
                radius = self._growth.tip_radius
                loadings = [None if field is None else TipLoading(field, np.nan, np.nan, radius) for field in fields]
        trial = _Trial(factor, loadings, self._largest_criticality(loadings), state, seconds)
        self._tried.append(trial)
        return trial

    def at_rest(self, trial: _Trial) -> _Trial:
        """The state under the held loads alone; `trial` is one under any load."""
        if any(load.held for load in self._configuration.scene.case.loads):
            return self.at(0.0)
        loadings = [None if loading is None else loading.none for loading in trial.loadings]
        return _Trial(0.0, loadings, self._largest_criticality(loadings), None, {})

    def found(self, trial: _Trial) -> StepSolution:
        """The solution of a trial that ends the search, with the time of all of them."""
        assert trial.state is not None
        fields = [None if loading is None else loading.field for loading in trial.loadings]
        solution = judged(trial.state, fields)
        spent = {phase: sum(tried.seconds[phase] for tried in self._tried) for phase in ("contact", "criterion")}
        spent["criterion"] += solution.seconds["criterion"]
        return replace(solution, seconds={**solution.seconds, **spent})

    def meets(self, trial: _Trial) -> bool:
        """Whether the criterion is just met."""
        return bool(self.can_grow.any()) and abs(trial.criticality - 1.0) <= MET

    def beyond(self, below: _Trial, above: _Trial) -> float:
        """The next factor where the criterion is met at neither of two: where it would be if all were linear."""
        low, high = below.factor, above.factor
        excess, farthest = self._excess(below, above), (LARGEST_FACTOR - low) / (high - low)
        share = 1.0
        while share < farthest:
            nearer, share = share, min(STRIDE * share, farthest)
            if excess(share) >= 0.0:
                return low + float(brentq(excess, nearer, share, xtol=1e-16, rtol=1e-14)) * (high - low)
        return min(STRIDE * high, LARGEST_FACTOR)

    def share_met(self, below: _Trial, above: _Trial) -> float:
        """Where, from 0 to 1, the criterion is just met if everything is linear between two states."""
        return float(brentq(self._excess(below, above), 0.0, 1.0, xtol=1e-16, rtol=1e-14))

    def _excess(self, below: _Trial, above: _Trial) -> Callable[[float], float]:
        """Largest criticality less 1, at a share of the way from one state to the other."""
        pairs = list(zip(below.loadings, above.loadings, strict=True))
        return lambda share: (
            self._largest_criticality([a and b and TipLoading.between(a, b, share) for a, b in pairs]) - 1.0
        )

    def _largest_criticality(self, loadings: Sequence[TipLoading | None]) -> float:
        """Largest criticality of the tips that can grow."""
        scene, ends = self._configuration.scene, self._configuration.cover.tip_ends
        return max(
            (
                verdict(scene, scene.crack_bodies[crack], loading).criticality
                for loading, grows, (crack, _) in zip(loadings, self.can_grow, ends, strict=True)
                if grows and loading is not None
            ),
            default=0.0,
        )

    def first_change(self, below: _Trial, above: _Trial) -> float | None:
        """A factor just before or behind the one where a sticking point first slips, between two; None where unknown.

        The point comes to its limit on the line through two states with the same contact points.
        """
        low, high = below.factor, above.factor
        law = self._configuration.contact.law
        state = below.state
        assert above.state is not None
        sticks = law.cohesion > 0.0 if state is None or low == 0.0 else state.outcome.state == STICK
        if not (sticks & (above.state.outcome.state != STICK)).any():
            return None
        alike = [other for other in self._states if state is not None and _are_alike(other, state)]
        if state is None or low == 0.0 or not alike:  # what contact does between is seen best under small loads
            return self._new(max(2.0 * low, SMALL_SHARE * high), low, high)
        share = _share_to_limit(alike[-1], state, law)
        factor = alike[-1].factor + share * (low - alike[-1].factor)
        sides = (self._new(factor * (1.0 + sense * NEAR_CHANGE), low, high) for sense in (-1.0, 1.0))
        return next((side for side in sides if side is not None), None)

    def _new(self, factor: float, low: float, high: float) -> float | None:
        """A factor, unless it lies outside of an interval or has been given before."""
        if not low < factor < high or factor in self._expected:
            return None
        self._expected.add(factor)
        return factor


def _are_alike(one: LoadState, other: LoadState) -> bool:
    """Whether the contact points of two states are in the same states: between the two everything is linear."""
    same = np.array_equal(one.outcome.memory.broken, other.outcome.memory.broken)
    return one is not other and same and np.array_equal(one.outcome.state, other.outcome.state)


def _share_to_limit(first: LoadState, last: LoadState, law: ContactLaw) -> float:
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
