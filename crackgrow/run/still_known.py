"""For how long what was measured of the error of K holds while cracks grow.

What is known of the K of a crack holds until what was added to it is over twice as long, or one of its tips more or
less is there; of the K of a tip until what lies nearest is a third nearer.

A name chooses no cells by it. K is measured anew once what was added to all cracks together is over twice as long, or
where what was known holds no more at a tip, but after a step for each tip at the soonest. Until then the fitted bound
tells of such tips.

For a target bounds are widened from there on: as what was added is longer, by the square of what is nearer, as the
fitted bound is larger, and where cells are joined. K is measured anew where they would be beyond the target.

What the criterion says otherwise on other cells does not grow with the cracks, and stays as it was.

Where bonds break at a critical load the other cells have one of their own: what is known there tells nothing of steps
at which none break, nor the other way round.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from crackgrow.geometry.polyline import arc_lengths
from crackgrow.run.halvings import Accuracy
from crackgrow.run.judging import StepSolution
from crackgrow.run.nearby import room_at_tips
from crackgrow.run.other_cells import fitted_bounds, fitted_share, largest_K
from crackgrow.run.parting import partings

GROWN = 2.0
"""What is known of the error holds until what was added to a crack is over so many times as long, or B so much of K.

It still does at just so many times, as where increments are alike.
"""

NEARER = 1.5
"""What is known of the error at a tip holds until it has so many times less room.

Measured in a plate that a crack grows through: with two the error is 1.6 times its bound where half of it is left.
"""

JOINED, EXPECTED_OF_JOINED = 8.0, 4.0
"""Bounds of all tips are so many times as wide for each time that cells are joined at the crack where they have been
most often; what is expected is so many times as large.

Measured in six scenes that grow (of the shipped ones, for 1 %, K against that for 0.1 %): errors are four to five times
what was expected before. With bounds four times as wide, at the joined crack alone, they are up to 1.4 times the bound,
at a tip beside.
"""

ROUND_OFF = 1e-9
"""Of a length: sums of increments are better."""


def lengths_grown(solution: StepSolution) -> tuple[float, ...]:
    """What has been added to each crack, m: to one that has started in the run all of it."""
    found = []
    for now, given in zip(solution.cracks, solution.scene.case.cracks, strict=True):
        began = arc_lengths(given.points)[-1] if now.steps.min() == 0 else 0.0
        found.append(float(arc_lengths(now.crack.points)[-1] - began))
    return tuple(found)


@dataclass(frozen=True, eq=False)
class Since:
    """What was known of the step before, seen from a step in which cracks have grown by then."""

    last: Accuracy
    solution: StepSolution
    grown: tuple[float, ...]  # m, crack by crack

    @cached_property
    def fitted(self) -> list[float]:
        """The fitted bounds of the step's tips."""
        return fitted_bounds(self.solution)

    @cached_property
    def _changed(self) -> list[float]:
        """By how much the bound has to be wider since its surroundings have changed, tip by tip: 1 while it holds."""
        last, solution = self.last, self.solution
        lengths = dict(enumerate(last.grown))  # a crack that has started since had nothing
        then = dict(zip(last.ends, last.rooms, strict=True))
        found = []
        for end, room in zip(solution.cover.tip_ends, room_at_tips(solution.scene, solution.cover), strict=True):
            longer = _times(self.grown[end[0]], lengths.get(end[0], 0.0)) / GROWN
            nearer = _times(then[end], room) / NEARER if end in then else math.inf
            found.append((longer if longer > 1.0 + ROUND_OFF else 1.0) * max(nearer, 1.0) ** 2)
        return found

    @property
    def _coarser(self) -> tuple[int, ...]:
        """How often cells at tips have been doubled since K was measured, crack by crack."""
        last, now = self.last, self.solution.scene.halvings
        before = last.coarser or (0,) * len(last.halvings.cracks)
        return tuple(n + then - here for n, then, here in zip(before, last.halvings.cracks, now.cracks, strict=False))

    @cached_property
    def widening(self) -> list[float]:
        """By how much the bound that was measured has to be wider, tip by tip: 1 while it holds as it was.

        Infinite where nothing was measured; for a name where it does not hold.
        """
        if self.solution.scene.case.numerics.target is None:
            return [1.0 if times == 1.0 else math.inf for times in self._changed]
        fitted = max(_times(fitted_share(self.solution, self.fitted), GROWN * self.last.fitted), 1.0)
        of_all = fitted * JOINED ** max(self._coarser, default=0)
        return [of_all * times for times in self._changed]

    @property
    def holds(self) -> bool:
        """Whether what was known is good enough for this step."""
        last, solution = self.last, self.solution
        if last.jumps != any(solution.jumps):
            return False
        if solution.scene.case.numerics.target is None:
            young = last.age < len(solution.cover.tip_ends)  # scenes with many tips would be measured all the time
            known = young or (not _has_lost(last) and all(self.still_known))
            of_all = _is_like(sum(self.grown), sum(last.grown))
            still = known and of_all and fitted_share(solution, self.fitted) <= GROWN * last.fitted
        else:
            still = self._same_tips and (all(self.still_known) or self._within_target)
        return still and not self._part_otherwise

    @property
    def still_known(self) -> list[bool]:
        """Whether what was measured at it holds as it was, tip by tip."""
        return [times == 1.0 for times in self.widening]

    @property
    def _same_tips(self) -> bool:
        """Whether there are the same cracks and tips, on the same cells but for those that are joined."""
        then, now = self.last.halvings, self.solution.scene.halvings
        same = self.last.ends == tuple(self.solution.cover.tip_ends) and len(then.cracks) == len(now.cracks)
        return same and replace(then, cracks=now.cracks) == now and min(self._coarser, default=0) >= 0

    @property
    def _within_target(self) -> bool:
        """Whether widened bounds are within the target of the error of K; that of another goal is not widened."""
        numerics = self.solution.scene.case.numerics
        if numerics.target is None or numerics.measured_of != "K" or not all(map(math.isfinite, self.widening)):
            return False
        return max(self.carried_over.shares(), default=0.0) <= numerics.target

    @property
    def _part_otherwise(self) -> bool:
        """Whether K of a tip misses more where faces part than the bound says that was known."""
        missed = partings(self.solution.state, self.solution.tips)
        return any(missed[end].at_most > bound for end, bound in zip(missed, self.carried_over.bounds, strict=True))

    @cached_property
    def carried_over(self) -> Accuracy:
        """What was measured before, in the same shares of the K of this step, widened; else the fitted bound."""
        last, ends = self.last, tuple(self.solution.cover.tip_ends)
        largest, then = largest_K(self.solution), {end: number for number, end in enumerate(last.ends)}
        scale = largest / last.largest if last.largest > 0.0 else 1.0
        measured = [
            then[end] if math.isfinite(times) and not math.isnan(last.expected[then[end]]) else None
            for end, times in zip(ends, self.widening, strict=True)
        ]
        joined = max(self._coarser, default=0) - max(last.coarser, default=0)
        so_far = last.widened or (1.0,) * len(last.ends)
        widening = [1.0 if tip is None else times for tip, times in zip(measured, self.widening, strict=True)]
        more = [1.0 if tip is None else times / so_far[tip] for tip, times in zip(measured, widening, strict=True)]

        def carried(numbers: Sequence[float]) -> tuple[float, ...]:
            return tuple(math.nan if tip is None else numbers[tip] for tip in measured)

        of_tips = zip(measured, more, self.fitted, strict=True)
        return replace(
            last,
            halvings=self.solution.scene.halvings,
            coarser=self._coarser,
            age=last.age + 1,
            ends=ends,
            largest=largest,
            bounds=tuple(bound if tip is None else times * scale * last.bounds[tip] for tip, times, bound in of_tips),
            widened=tuple(widening),
            expected=tuple(EXPECTED_OF_JOINED**joined * scale * error for error in carried(last.expected)),
            rooms=tuple(last.rooms[then[end]] if end in then else math.nan for end in ends),
            turns=carried(last.turns),
            criticalities=carried(last.criticalities),
        )


def _has_lost(last: Accuracy) -> bool:
    """Whether there is a tip of which the fitted bound tells."""
    of_tips = zip(last.expected, last.bounds, strict=True)
    return any(math.isnan(error) and not math.isnan(bound) for error, bound in of_tips)


def _times(large: float, small: float) -> float:
    """How many times the small length the large one is; not known, and not more, where either is not."""
    if math.isnan(large) or math.isnan(small) or large == 0.0:
        return 1.0
    return large / small if small > 0.0 else math.inf


def _is_like(now: float, then: float) -> bool:
    """Whether what was known with a length `then` holds `now`."""
    return now <= (1.0 + ROUND_OFF) * GROWN * then
