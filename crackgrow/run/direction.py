"""The advance of the chosen tips: by the criterion's kinks, or by kinks corrected until K_II vanishes at the new tips.

The new tip of an increment along the hoop-stress kink is not free of K_II: the path zigzags about the smooth one by an
amount that shrinks with the increment. The corrected kinks follow the smooth path at large increments. Every kink is
corrected by its own tip's K_II alone (diagonal secant); one whose tip has met something is not corrected any more.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from crackgrow.arrays import Floats, Ints
from crackgrow.errors import GeometryError, SolveError
from crackgrow.fracture.advance import GrowingCrack
from crackgrow.fracture.criteria import hoop_stress_kink
from crackgrow.run.evaluation import StepSolution
from crackgrow.run.propagation import AfterAdvance, BeforeAdvance, End, advanced_by
from crackgrow.run.starting import start_at

Solve = Callable[[tuple[GrowingCrack, ...]], StepSolution]

MOST_SOLVES = 6
"""Solves for one advance."""

SMALL_SHEAR = 1e-3
"""K_II below this fraction of K has vanished: it turns a crack by 0.1 degrees."""

WORST_ERROR = 1e-2
"""K_II within its spread over radii has vanished too, as long as that is below this fraction of K."""

USUAL_SLOPE = 1.0
"""d(K_II / K)/dkink, 1/rad: 0.5 for a small kink of an open crack, measured 2 for the wing of a closed one."""

SLOPES = (0.1, 20.0)
"""Secants outside of this range say nothing."""

LARGEST_CORRECTION = np.deg2rad(30.0)
"""rad, of one trial."""


@dataclass(frozen=True, slots=True, eq=False)
class _Trial:
    """What the kinks of an advance give; solutions are large, and only the best one is kept."""

    kinks: Floats  # (n,) rad
    shear: Floats  # (n,) K_II / K at the new tips, zero where a tip has met something
    error: Floats  # (n,) below which `shear` counts as zero

    @property
    def excess(self) -> float:
        """Largest shear, as a multiple of what counts as zero."""
        return float((np.abs(self.shear) / self.error).max())


def advance_tips(before: BeforeAdvance, solution: StepSolution, chosen: Ints, solve: Solve) -> AfterAdvance:
    """The cracks after they have left the sites `chosen` of a solution; `solve` gives the step that follows.

    Starts of new cracks come last.
    """
    n_tips = len(solution.cover.tips)
    tips, started_at = chosen[chosen < n_tips].tolist(), chosen[chosen >= n_tips].tolist()
    ends = [solution.cover.tip_ends[tip] for tip in tips]
    verdicts = [verdict for verdict in (solution.tips[tip].verdict for tip in tips) if verdict is not None]
    turning = [verdict.mode == "tension" for verdict in verdicts]  # what starts, and shear, keep their directions
    for number, site in enumerate(started_at):
        start = solution.starts[site - n_tips]
        new = start_at(before.scene, before.cracks, before.starts, start.site, start.verdict.mode)
        before, end = replace(before, starts=(*before.starts, new)), (len(before.cracks) + number, True)
        ends, verdicts, turning = [*ends, end], [*verdicts, start.verdict], [*turning, False]
    kinks = np.array([verdict.kink for verdict in verdicts])
    first = advanced_by(before, ends, kinks)
    turned = [end for end, turns in zip(ends, turning, strict=True) if turns]
    growth = before.scene.case.growth
    if growth is None or growth.direction == "explicit" or not any(first.can_grow(end) for end in turned):
        return first
    return _without_shear(before, _Turning(ends, turning), kinks, first, solve)


@dataclass(frozen=True, slots=True)
class _Turning:
    """The ends that advance, and whether a direction is looked for in which K_II vanishes."""

    ends: list[End]
    turning: list[bool]


def _without_shear(
    before: BeforeAdvance, wanted: _Turning, kinks: Floats, first: AfterAdvance, solve: Solve
) -> AfterAdvance:
    """The advance whose new tips see least shear, with its solution and the cost of all solves."""
    trials: list[_Trial] = []
    seconds: dict[str, float] = {}
    least, found, gave_up = np.inf, first, ""
    while True:
        try:
            advance = advanced_by(before, wanted.ends, kinks) if trials else first
            solved = solve(advance.cracks)
        except (GeometryError, SolveError) as error:
            if not trials:
                return first  # solving it again tells the user why
            gave_up = f"the search for the direction of growth ended at trial {len(trials) + 1}: {error}"
            break
        for phase, spent in solved.seconds.items():
            seconds[phase] = seconds.get(phase, 0.0) + spent
        trials.append(_evaluated(kinks, advance, solved, wanted))
        if found.solution is None or trials[-1].excess < least:
            least, best, found = trials[-1].excess, trials[-1], replace(advance, solution=solved)
        del solved
        if least <= 1.0 or len(trials) == MOST_SOLVES:
            break
        kinks = _corrected(trials)
    assert found.solution is not None
    notes = (*found.solution.notes, *([gave_up] if gave_up else []))
    if least > 1.0:
        left = f"the direction of growth left K_II at {np.abs(best.shear).max():.2g} of K at a new tip"
        notes = (*notes, left)
    return replace(found, solution=replace(found.solution, seconds=seconds, factorizations=len(trials), notes=notes))


def _evaluated(kinks: Floats, advance: AfterAdvance, solution: StepSolution, wanted: _Turning) -> _Trial:
    """The shear that new tips see."""
    shear, error = np.zeros(len(wanted.ends)), np.full(len(wanted.ends), SMALL_SHEAR)
    for number, (end, turns) in enumerate(zip(wanted.ends, wanted.turning, strict=True)):
        if not turns or not advance.can_grow(end):
            continue  # it keeps its direction, or has met something
        state = solution.tips[solution.cover.tip_ends.index(end)]
        size = float(np.hypot(*state.K))
        if size == 0.0:
            continue  # nothing to turn it
        # the kink of the largest hoop stress is -2 K_II / K_I where that is small, and bounded everywhere
        shear[number] = -0.5 * hoop_stress_kink(*state.K)
        error[number] = np.clip(np.nan_to_num(state.intensity.K_II_spread) / size, SMALL_SHEAR, WORST_ERROR)
    return _Trial(kinks, shear, error)


def _corrected(trials: list[_Trial]) -> Floats:
    """The next kinks (n,): by the secant through the last two trials, else by the usual slope."""
    last = trials[-1]
    slope = np.full(len(last.kinks), USUAL_SLOPE)
    if len(trials) > 1:
        step, change = last.kinks - trials[-2].kinks, last.shear - trials[-2].shear
        secant = np.divide(change, step, out=np.zeros_like(slope), where=step != 0.0)
        slope = np.where((secant > SLOPES[0]) & (secant < SLOPES[1]), secant, slope)
    return np.asarray(last.kinks - np.clip(last.shear / slope, -LARGEST_CORRECTION, LARGEST_CORRECTION))
