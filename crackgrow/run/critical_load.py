"""The load factor at which the criterion is just met.

The load rises from the held loads alone; contact points remember on the way, and follow a path of straight pieces
(`path`). The first state on it that meets the criterion, and the one before it, enclose the critical factor: the
stresses are linear between the two, so that the criterion, whose limits are convex in stress, is met once there, and
only where it is met at the end. The path is gone along piece by piece, and ends where no branch goes on:
there pieces of rock come loose. Where contact that breaks makes the criticality jump past 1, the critical factor is the
one behind the jump.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from crackgrow.arrays import Bools, Floats
from crackgrow.errors import FreePieceError, NotSolvedError, SolveError
from crackgrow.fracture.criteria import TipLoading
from crackgrow.run.clock import timed
from crackgrow.run.configuration import Configuration
from crackgrow.run.evaluation import StartState, StepSolution, TipState, evaluated, verdicts
from crackgrow.run.increments import LoadState, held_loads, increment, rising

LARGEST_FACTOR = 1e6
"""Load factors beyond this are not tried."""

STRIDE = 4.0
"""Factor by which the load grows where the criticality does not rise with it."""

MOST_WAYS = 60
"""Load factors that one step makes for in turn."""

SAME = 1e-9
"""The criterion is just met where the criticality differs from 1 by less; load factors are one that differ by less."""

BEYOND = 1e-3
"""Of a load factor up to which there are states: so much farther there are none where it is the last one."""

NEVER_CRITICAL = (
    f"no load factor up to {LARGEST_FACTOR:g} meets the criterion at any tip; where loads confine, strength grows with "
    "them: `held: true` leaves such a load as it is"
)


def critically_loaded(configuration: Configuration, guess: float) -> StepSolution:
    """The configuration at the load factor at which the criterion is just met at the first of the sites that can grow.

    `guess` > 0 is the first factor that is made for. Where no factor up to `LARGEST_FACTOR` meets the criterion, the
    solution is the one at the guess, and its notes say so. Raises SolveError where the search does not settle, and
    FreePieceError where a piece comes loose before.
    """
    search = _Search(configuration)
    if search.rest.is_critical:
        raise SolveError("the criterion is met under the held loads alone: no critical load factor; hold smaller loads")
    trials = [search.rest, *search.towards(search.rest, guess)]
    first = trials[-1]
    if not search.can_grow.any():
        return search.found(first)
    while not trials[-1].is_critical:
        if trials[-1].factor >= LARGEST_FACTOR:
            found = search.found(first)
            return replace(found, notes=(*found.notes, NEVER_CRITICAL))
        (below, above), farther = trials[-2:], STRIDE * trials[-1].factor
        if (rise := above.criticality - below.criticality) > 0.0:
            met = above.factor + (1.0 - above.criticality) / rise * (above.factor - below.factor)
            farther = met if met < LARGEST_FACTOR else farther  # the rise may be round-off, and a long way is coarse
        trials = [*trials[-2:], *search.towards(above, min(farther, LARGEST_FACTOR))]
    (below, above), tries = trials[-2:], 0
    while not above.meets and above.factor - below.factor > SAME * above.factor:
        share = search.share_met(below, above) if tries % 3 < 2 else 0.5  # in a jump the line leads nowhere
        trials = [below, *search.towards(below, below.factor + share * (above.factor - below.factor))]
        below, above = trials[-2:] if trials[-1].is_critical else (trials[-1], above)
        tries += 1
    return search.found(above)


@dataclass(frozen=True, slots=True, eq=False)
class _Trial:
    """What is known of a load factor."""

    factor: float
    loadings: list[TipLoading | None]  # site by site
    criticalities: Floats  # site by site, then tips of cracked interfaces; zero where no crack can leave
    solution: StepSolution | None  # None without any load, where everything is zero
    came: tuple[LoadState, ...] = ()  # on the ways to it, in turn, and at last its own

    @property
    def criticality(self) -> float:
        """The largest of all."""
        return float(self.criticalities.max(initial=0.0))

    @property
    def meets(self) -> bool:
        """Whether the criterion is just met."""
        return abs(self.criticality - 1.0) <= SAME

    @property
    def is_critical(self) -> bool:
        """Whether the criterion is met, just or by more."""
        return self.criticality >= 1.0 or self.meets


class _Search:
    """The search for a critical load factor on one configuration: trials, and guesses of the next one."""

    def __init__(self, configuration: Configuration) -> None:
        self._configuration = configuration
        self._start = held_loads(configuration)
        self._n_ways = 0
        self._why = ""  # a way ended before the load factor that it made for
        ends, sites = configuration.cover.tip_ends, configuration.sites
        grow = [configuration.cracks[index].can_grow(end) for index, end in ends] + [True] * (len(sites) - len(ends))
        grow += [debond is not None for _, debond in configuration.interface_tips]
        self.can_grow: Bools = np.array(grow, dtype=bool)  # site by site, then tips of cracked interfaces
        self.rest = _Trial(0.0, [None] * len(sites), np.zeros(len(grow)), None)  # under the held loads alone
        if any(load.held for load in configuration.scene.case.loads):
            self.rest = self._evaluated(increment(configuration, self._start, 0.0))

    def towards(self, below: _Trial, factor: float) -> list[_Trial]:
        """States from a trial to a load factor, up to the first critical one. Raises SolveError where the path ends."""
        self._n_ways += 1
        if self._n_ways > MOST_WAYS:
            raise NotSolvedError(f"no critical load factor found up to {below.factor:.12g}{self._why}")
        states, found = rising(self._configuration, below.solution or self._start, factor), list[_Trial]()
        try:
            while not (found and found[-1].is_critical):
                with timed("contact"):
                    state = next(states, None)
                if state is None:
                    break
                found.append(self._evaluated(state, below))
        except (FreePieceError, NotSolvedError) as error:
            self._why = f", and no state was found at {factor:.6g}: {error}"
            found.append(self._farther(found[-1] if found else below, factor))
        return found

    def _farther(self, last: _Trial, factor: float) -> _Trial:
        """The trial a little farther than the `last` one before the path ends, on the way to a load factor."""
        farther = min(last.factor + BEYOND * (last.factor or factor), factor)
        try:
            state = increment(self._configuration, last.solution or self._start, farther)
        except FreePieceError as error:
            if last.solution is None:
                raise  # nothing holds from the beginning
            what = f"{error.what}, from a load factor of {farther:.4g} on, before the criterion is met"
            raise FreePieceError(what, error.remedy) from error
        except NotSolvedError as error:
            raise NotSolvedError(
                f"the criterion is not met up to a load factor of {last.factor:.6g}, and no state was found at "
                f"{farther:.6g}: {error}"
            ) from error
        return self._evaluated(state, last)

    def found(self, trial: _Trial) -> StepSolution:
        """The solution of a trial that ends the search."""
        assert trial.solution is not None
        notes = tuple(dict.fromkeys(note for state in trial.came for note in state.notes))
        return replace(trial.solution, via=trial.came[:-1], notes=notes)

    def share_met(self, below: _Trial, above: _Trial) -> float:
        """Where between two trials, from 0 to 1, the criterion is just met if everything is linear between them."""
        from scipy.optimize import brentq  # here: loading it takes a tenth of a second that other loads save

        some = above.criticalities >= 1.0
        met = partial(self._beyond, below, above, some)
        return float(brentq(met, 0.0, 1.0, xtol=1e-16, rtol=1e-14))

    def _evaluated(self, state: LoadState, below: _Trial | None = None) -> _Trial:
        """The trial of a state, on a way that began at the trial `below`."""
        solution = evaluated(state)
        sites: list[TipState | StartState] = [*solution.tips, *solution.starts]
        largest = [0.0 if site.verdict is None else site.verdict.largest for site in sites]
        largest += np.nan_to_num([each.criticality for each in solution.interface_tips]).tolist()
        criticalities = np.where(self.can_grow, largest, 0.0)
        earlier = () if below is None else (*below.came[:-1], *(at.light() for at in below.came[-1:]))
        came = (*earlier, *state.via, state)
        return _Trial(state.factor, [site.loading for site in sites], criticalities, solution, came)

    def _beyond(self, below: _Trial, above: _Trial, some: Bools, share: float) -> float:
        """The criticality less 1 at a share of the way between trials, if all is linear there.

        The largest of `some` sites (n,) counts, where no others can meet the criterion. It is that of all branches:
        where tension is met as well, shear may have been at a lower load. Of tips of interfaces it is linear itself, as
        K is.
        """
        found = (1.0 - share) * below.criticalities + share * above.criticalities
        sites, loadings = self._configuration.sites, dict[int, TipLoading]()
        for number, (first, last) in enumerate(zip(below.loadings, above.loadings, strict=True)):
            if last is not None and some[number]:
                loadings[number] = TipLoading.between(first or last.none, last, share)  # none without any load
        said = verdicts(self._configuration.scene, [sites[number] for number in loadings], list(loadings.values()))
        found[list(loadings)] = [verdict.largest for verdict in said]
        return float(found[some].max()) - 1.0
