"""What grows after a solve: which tips and starts of cracks advance, how far, in how much time; why a run ends."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from crackgrow.accuracy.companion import End
from crackgrow.arrays import Floats, Ints
from crackgrow.case.model import Fatigue, Growth
from crackgrow.errors import FreePieceError, GeometryError, SolveError
from crackgrow.fracture.advance import STARTS, GrowingCrack, advancing_sites, largest_first
from crackgrow.fracture.subcritical import WAITS, lengths, mean_velocity, velocities
from crackgrow.run.checkpoint import RunState
from crackgrow.run.critical_load import NEVER_CRITICAL
from crackgrow.run.evaluation import StepSolution
from crackgrow.run.result import RunEnd
from crackgrow.solid.rigid_modes import all_pieces

COARSE = 3.0
"""Factor by which v may change along an increment: the time is off by 2 % then with n = 10, by 10 % with n = 2."""

COARSE_TIME = (
    f"the velocity of the fastest tip changes by more than a factor of {COARSE:g} along an increment, so that the time "
    "of the step, or its cycles, are off by several percent; give a shorter growth.increment"
)


@dataclass(frozen=True, slots=True, eq=False)
class Advances:
    """The sites that advance after a solve, with lengths and velocities where growth takes time, or cycles for it.

    Behind the numbers of sites there are those of tips of cracked interfaces.
    """

    cracks: tuple[GrowingCrack, ...]  # as they are, with what tips that wait have gathered
    sites: Ints = field(default_factory=lambda: np.empty(0, dtype=np.int64))  # by number, that of a new crack last
    lengths: Mapping[End, float] = field(default_factory=dict)  # m, of tips that do not go by the increment
    velocity: Mapping[End, float] = field(default_factory=dict)  # m/s, at the beginning, of these and those that wait
    time: float = 0.0  # s, that the step would take with these


def chosen_advances(growth: Growth, solution: StepSolution, cracks: tuple[GrowingCrack, ...]) -> Advances:
    """The sites that advance: by the criterion, or by velocities, the tip with the longest advance first.

    `cracks` are those of the solution, with what their tips have gathered.
    """
    criticality, n_tips, n_sites = site_criticality(solution), len(solution.tips), len(solution.configuration.sites)
    places = site_places(solution)
    if growth.rate_law is not None:
        return _in_time(growth, solution, cracks, places, velocities(_driving(solution), growth.rate_law))
    n_advances = np.full(len(criticality), STARTS, dtype=np.int64)
    n_advances[:n_tips] = [cracks[index].n_advances(at_end) for index, at_end in solution.cover.tip_ends]
    n_advances[n_sites:] = [
        0 if each.debond is None else each.debond.n_advances(each.tip.at_end) for each in solution.interface_tips
    ]
    chosen = advancing_sites(criticality, n_advances, places, growth.advance)
    starts = chosen[n_advances[chosen] == STARTS]
    if any(solution.configuration.sites[site].kind != "crack" for site in starts.tolist()):
        # on rims and in rock equal ones are neighbours: the first relieves them
        chosen = chosen[: len(chosen) - len(starts) + 1]
    return Advances(cracks, chosen)


def site_places(solution: StepSolution) -> Floats:
    """Where (n, 2) every site lies, lattice coordinates; after them the tips of cracked interfaces."""
    points = [site.point for site in solution.configuration.sites]
    return np.array([*points, *(each.tip.point for each in solution.interface_tips)]).reshape(-1, 2)


def site_criticality(solution: StepSolution) -> Floats:
    """Criticality (n,) of every site, then of the tips of cracked interfaces, -inf for a tip that must not grow."""
    tips = [
        tip.verdict.criticality if tip.verdict is not None and solution.cracks[index].can_grow(at_end) else -np.inf
        for tip, (index, at_end) in zip(solution.tips, solution.cover.tip_ends, strict=True)
    ]
    on_interfaces = np.nan_to_num([each.criticality for each in solution.interface_tips], nan=-np.inf)
    return np.array([*tips, *(start.verdict.criticality for start in solution.starts), *on_interfaces])


def _driving(solution: StepSolution) -> Floats:
    """What the rate of growth of each tip (n,) follows: criticality, or the range of K (Pa sqrt(m)) in fatigue."""
    criticality = site_criticality(solution)[: len(solution.tips)]
    growth = solution.scene.case.growth
    if growth is None or growth.fatigue is None:
        return criticality
    return np.where(np.isfinite(criticality), [tip.K_range for tip in solution.tips], -np.inf)


def _in_time(
    growth: Growth, solution: StepSolution, cracks: tuple[GrowingCrack, ...], places: Floats, velocity: Floats
) -> Advances:
    """The advances by the velocities (n,) m/s of the tips."""
    ends, increment = solution.cover.tip_ends, growth.increment
    gathered = np.array([cracks[index].gathered[at_end] for index, at_end in ends])
    length, left, first = lengths(velocity, gathered, increment)
    if first is None:
        return Advances(cracks)
    goes = largest_first(np.flatnonzero(length > 0.0), length, places)
    far = {ends[tip]: float(length[tip]) for tip in goes.tolist()}
    fast = {end: speed for end, speed in zip(ends, velocity.tolist(), strict=True) if speed > 0.0}
    kept = tuple(replace(crack, gathered=(0.0, 0.0)) for crack in cracks)
    kept = _gathering(kept, dict(zip(ends, left.tolist(), strict=True)))
    return Advances(kept, goes, far, fast, float((increment - gathered[first]) / velocity[first]))


def _gathering(cracks: tuple[GrowingCrack, ...], more: Mapping[End, float]) -> tuple[GrowingCrack, ...]:
    """The cracks, whose ends have gathered so much more (m) for the next advance, or are ahead by it."""
    return tuple(
        replace(crack, gathered=(first + more.get((n, False), 0.0), last + more.get((n, True), 0.0)))
        for n, crack in enumerate(cracks)
        for first, last in [crack.gathered]
    )


def time_of(
    left: Advances, solution: StepSolution, cracks: tuple[GrowingCrack, ...]
) -> tuple[float, tuple[GrowingCrack, ...], tuple[str, ...]]:
    """The time (s) that the advance to a solution took, the cracks with what their tips lag behind it, and notes.

    The time is that of the tip with the largest mean velocity, of those that still are tips, and no less than others
    took to what they have met. Of those, or of one that stands still now, the velocity at the beginning is all that is
    known.
    """
    growth = solution.scene.case.growth
    if growth is None or growth.rate_law is None or not left.lengths:
        return 0.0, cracks, ()
    velocity = velocities(_driving(solution), growth.rate_law).tolist()
    now = dict(zip(solution.cover.tip_ends, velocity, strict=True))
    means = {end: mean_velocity(before, now.get(end) or before) for end, before in left.velocity.items()}
    time = max((_time_to_meeting(left, end, solution) for end in left.lengths if end not in now), default=0.0)
    fastest = max((end for end in left.lengths if end in now), key=lambda end: means[end], default=None)
    before = after = 1.0
    if fastest is not None:
        before, after = left.velocity[fastest], now[fastest] or left.velocity[fastest]
        time = max(time, left.time * before / means[fastest])
    most = WAITS * growth.increment
    lags = {
        end: min(max(mean * time - left.velocity[end] * left.time, -most), most) for end, mean in means.items()
    }  # a step that is resolved is not off by more; what is more would make tips go ahead by turns
    return time, _gathering(cracks, lags), (COARSE_TIME,) if max(after / before, before / after) > COARSE else ()


def _time_to_meeting(left: Advances, end: End, solution: StepSolution) -> float:
    """The time (s) that a tip took to what it has met on its way."""
    index, at_end = end
    tip, before = (some[index].crack.points[-1 if at_end else 0] for some in (solution.cracks, left.cracks))
    ahead = left.lengths[end] - left.velocity[end] * left.time  # gathered before
    return max(float(np.hypot(*(tip - before))) - ahead, 0.0) / left.velocity[end]


def ended(state: RunState, solution: StepSolution, growth: Growth) -> RunEnd:
    """Why a run ends after its last step, or after one from which nothing grows."""
    largest, law = site_criticality(solution).max(initial=-np.inf), growth.rate_law
    step, is_last, grows = f"step {state.step}", state.step == growth.steps, largest > -np.inf
    near = f"; the most critical is at {largest:.3g} of "
    at_load = f"{near}the strength at load factor {solution.factor:.4g}" if grows else ""
    if is_last and state.step == 0:
        return RunEnd("completed", f"the static solve is done{at_load}", state.paths)
    if is_last and grows:
        return RunEnd("completed", f"all {state.step} growth steps are done", state.paths)
    if not is_last and NEVER_CRITICAL in solution.notes:
        return RunEnd("arrested", f"{step}: {NEVER_CRITICAL}", state.paths)
    if grows and law is not None:
        why = f"no tip has a velocity{near}its toughness, the threshold is {law.threshold:g}"
        if isinstance(law, Fatigue):
            why = f"no tip grows in a cycle; the largest range of K is {_driving(solution).max():.4g} Pa sqrt(m), "
            why += f"the threshold is {law.threshold:.4g}"
        return RunEnd("arrested", f"{step}: {why}", state.paths)
    if grows:
        where = step if state.step else "nothing grew"
        return RunEnd("arrested", f"{where}: no tip meets the criterion{at_load}", state.paths)
    reason, n_left = f"{step}: no tip is left that could grow", len(all_pieces(solution.cover))
    if n_left > state.n_pieces:
        cut = f"the cracks have cut the rock into {n_left} pieces, {state.n_pieces} at the start"
        return RunEnd("broke_through", f"{reason}; {cut}", state.paths)
    return RunEnd("arrested", reason, state.paths)


def unsolved(state: RunState, error: GeometryError | SolveError) -> RunEnd:
    """The end at a step after the first that was not solved: rock may have come loose."""
    if isinstance(error, FreePieceError):
        return RunEnd("broke_through", f"step {state.step}: {error.what}", state.paths, state.events)
    return RunEnd("failed", f"step {state.step}: {error}", state.paths, state.events)
