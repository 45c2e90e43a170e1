"""The advances after a solve: which tips and starts of cracks advance, by which lengths, and in how much time."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from crackgrow.arrays import Floats, Ints
from crackgrow.case.model import Growth
from crackgrow.fracture.advance import STARTS, GrowingCrack, advancing_sites, largest_first
from crackgrow.fracture.subcritical import WAITS, lengths, mean_velocity, velocities
from crackgrow.run.evaluation import StepSolution
from crackgrow.run.propagation import End

COARSE = 3.0
"""Factor by which v may change along an increment: the time is off by 2 % then with n = 10, by 10 % with n = 2."""

COARSE_TIME = (
    f"the velocity of the fastest tip changes by more than a factor of {COARSE:g} along an increment, so that the time "
    "of the step is off by several percent; give a shorter growth.increment"
)


NO_SITES = np.empty(0, dtype=np.int64)


@dataclass(frozen=True, slots=True, eq=False)
class Advances:
    """The sites that advance after a solve, with lengths and velocities where growth takes time."""

    sites: Ints  # numbers of the sites, that of a new crack last
    cracks: tuple[GrowingCrack, ...]  # as they are, with what tips that wait have gathered
    lengths: Mapping[End, float] = field(default_factory=dict)  # m, of tips that do not go by the increment
    velocity: Mapping[End, float] = field(default_factory=dict)  # m/s, at the beginning, of these and those that wait
    time: float = 0.0  # s, that the step would take with these


def no_advance(cracks: tuple[GrowingCrack, ...]) -> Advances:
    """No site advances."""
    return Advances(NO_SITES, cracks)


def chosen_advances(growth: Growth, solution: StepSolution, cracks: tuple[GrowingCrack, ...]) -> Advances:
    """The sites that advance: by the criterion, or by velocities, the tip with the longest advance first.

    `cracks` are those of the solution, with what their tips have gathered.
    """
    criticality, n_tips = site_criticality(solution), len(solution.tips)
    ends = solution.cover.tip_ends
    if growth.subcritical is not None:
        return _in_time(growth, solution, cracks, velocities(criticality[:n_tips], growth.subcritical))
    n_advances = np.full(len(criticality), STARTS, dtype=np.int64)
    n_advances[:n_tips] = [cracks[index].n_advances(at_end) for index, at_end in ends]
    places = _places(solution)
    sites = advancing_sites(criticality, n_advances, places, growth.advance)
    on_cracks = [solution.configuration.sites[site].kind == "crack" for site in sites[sites >= n_tips].tolist()]
    if not all(on_cracks):  # on rims and in rock equal ones are neighbours: the first relieves them
        sites = sites[: np.count_nonzero(sites < n_tips) + 1]
    return Advances(sites, cracks)


def site_criticality(solution: StepSolution) -> Floats:
    """Criticality (n,) of every site, -inf for a tip that must not grow."""
    tips = [
        tip.verdict.criticality if tip.verdict is not None and solution.cracks[index].can_grow(at_end) else -np.inf
        for tip, (index, at_end) in zip(solution.tips, solution.cover.tip_ends, strict=True)
    ]
    return np.array([*tips, *(start.verdict.criticality for start in solution.starts)])


@dataclass(frozen=True, slots=True)
class TimeStep:
    """The time that the advance to a solution took, by the mean of the velocities before and after it."""

    time: float = 0.0  # s
    shortfall: Mapping[End, float] = field(default_factory=dict)  # m, by which tips lag behind that time
    notes: tuple[str, ...] = ()

    def with_shortfall(self, cracks: tuple[GrowingCrack, ...]) -> tuple[GrowingCrack, ...]:
        """The cracks, whose tips have gathered the lengths that they lack, or are ahead by, for the next advance."""
        if not self.shortfall:
            return cracks
        return tuple(
            replace(
                crack, gathered=(first + self.shortfall.get((n, False), 0.0), last + self.shortfall.get((n, True), 0.0))
            )
            for n, crack in enumerate(cracks)
            for first, last in [crack.gathered]
        )


def time_step(left: Advances, solution: StepSolution) -> TimeStep:
    """The time that the advance to a solution took, with a note where the increment is too coarse for it.

    The time is that of the tip with the largest mean velocity, of those that still are tips, and no less than others
    took to what they have met. Of those, or of one that stands still now, the velocity at the beginning is all that is
    known.
    """
    law = solution.scene.case.subcritical
    if law is None or not left.lengths:
        return TimeStep()
    now = dict(zip(solution.cover.tip_ends, velocities(site_criticality(solution), law).tolist(), strict=True))
    means = {end: mean_velocity(before, now.get(end) or before) for end, before in left.velocity.items()}
    time = max((_time_to_meeting(left, end, solution) for end in left.lengths if end not in now), default=0.0)
    fastest = max((end for end in left.lengths if end in now), key=lambda end: means[end], default=None)
    before = after = 1.0
    if fastest is not None:
        before, after = left.velocity[fastest], now[fastest] or left.velocity[fastest]
        time = max(time, left.time * before / means[fastest])
    growth = solution.scene.case.growth
    most = WAITS * growth.increment if growth else 0.0
    shortfall = {
        end: min(max(mean * time - left.velocity[end] * left.time, -most), most) for end, mean in means.items()
    }  # a step that is resolved is not off by more; what is more would make tips go ahead by turns
    return TimeStep(time, shortfall, (COARSE_TIME,) if max(after / before, before / after) > COARSE else ())


def _time_to_meeting(left: Advances, end: End, solution: StepSolution) -> float:
    """The time (s) that a tip took to what it has met on its way."""
    index, at_end = end
    tip, before = (some[index].crack.points[-1 if at_end else 0] for some in (solution.cracks, left.cracks))
    ahead = left.lengths[end] - left.velocity[end] * left.time  # gathered before
    return max(float(np.hypot(*(tip - before))) - ahead, 0.0) / left.velocity[end]


def _places(solution: StepSolution) -> Floats:
    """Where the sites are (n, 2), those of tips first, in lattice coordinates."""
    return np.array([site.point for site in solution.configuration.sites]).reshape(-1, 2)


def _in_time(growth: Growth, solution: StepSolution, cracks: tuple[GrowingCrack, ...], velocity: Floats) -> Advances:
    """The advances by the velocities (n,) m/s of the tips."""
    ends, increment = solution.cover.tip_ends, growth.increment
    gathered = np.array([cracks[index].gathered[at_end] for index, at_end in ends])
    length, left, first = lengths(velocity, gathered, increment)
    if first is None:
        return no_advance(cracks)
    waiting = dict(zip(ends, left.tolist(), strict=True))
    kept = tuple(
        replace(crack, gathered=(waiting.get((index, False), 0.0), waiting.get((index, True), 0.0)))
        for index, crack in enumerate(cracks)
    )
    goes = largest_first(np.flatnonzero(length > 0.0), length, _places(solution))
    far = {ends[tip]: float(length[tip]) for tip in goes.tolist()}
    fast = {end: speed for end, speed in zip(ends, velocity.tolist(), strict=True) if speed > 0.0}
    return Advances(goes, kept, far, fast, float((increment - gathered[first]) / velocity[first]))
