"""For how long what was measured of the error of K holds while cracks grow.

What is known of the K of a crack holds until what was added to it is over twice as long, or one of its tips more or
less is there; of the K of a tip until what lies nearest is a third nearer. For a target all of it has to hold. A name
chooses no cells by it: it is measured anew once what was added to all cracks together is over twice as long, or where
it holds no more at a tip, but after a step for each tip at the soonest. Until then the fitted bound tells of such tips.

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
    def still_known(self) -> list[bool]:
        """Whether what was measured at it holds, tip by tip."""
        last, solution = self.last, self.solution
        lengths = dict(enumerate(last.grown))  # a crack that has started since had nothing
        then = dict(zip(last.ends, last.rooms, strict=True))
        return [
            end in then and _is_like(self.grown[end[0]], lengths.get(end[0], 0.0)) and not NEARER * room < then[end]
            for end, room in zip(solution.cover.tip_ends, room_at_tips(solution.scene, solution.cover), strict=True)
        ]

    @property
    def holds(self) -> bool:
        """Whether what was known is good enough for this step."""
        last, solution = self.last, self.solution
        if last.jumps != any(solution.jumps):
            return False
        if solution.scene.case.numerics.target is None:
            young = last.age < len(solution.cover.tip_ends)  # scenes with many tips would be measured all the time
            known = young or (not _has_lost(last) and all(self.still_known))
            still = known and _is_like(sum(self.grown), sum(last.grown))
        else:
            same = last.ends == tuple(solution.cover.tip_ends) and last.halvings == solution.scene.halvings
            still = same and all(self.still_known)
        return still and fitted_share(solution, self.fitted) <= GROWN * last.fitted and not self._part_otherwise

    @property
    def _part_otherwise(self) -> bool:
        """Whether K of a tip misses more where faces part than the bound says that was known."""
        missed = partings(self.solution.state, self.solution.tips)
        return any(missed[end].at_most > bound for end, bound in zip(missed, self.carried_over.bounds, strict=True))

    @cached_property
    def carried_over(self) -> Accuracy:
        """What was measured before, in the same shares of the K of this step; of other tips the fitted bound."""
        last, ends = self.last, tuple(self.solution.cover.tip_ends)
        largest, then = largest_K(self.solution), {end: number for number, end in enumerate(last.ends)}
        scale = largest / last.largest if last.largest > 0.0 else 1.0
        measured = [
            then[end] if still and not math.isnan(last.expected[then[end]]) else None
            for end, still in zip(ends, self.still_known, strict=True)
        ]

        def carried(numbers: Sequence[float]) -> tuple[float, ...]:
            return tuple(math.nan if tip is None else numbers[tip] for tip in measured)

        of_tips = zip(measured, self.fitted, strict=True)
        return replace(
            last,
            age=last.age + 1,
            ends=ends,
            largest=largest,
            bounds=tuple(bound if tip is None else scale * last.bounds[tip] for tip, bound in of_tips),
            expected=tuple(scale * error for error in carried(last.expected)),
            rooms=carried(last.rooms),
            turns=carried(last.turns),
            criticalities=carried(last.criticalities),
        )


def _has_lost(last: Accuracy) -> bool:
    """Whether there is a tip of which the fitted bound tells."""
    of_tips = zip(last.expected, last.bounds, strict=True)
    return any(math.isnan(error) and not math.isnan(bound) for error, bound in of_tips)


def _is_like(now: float, then: float) -> bool:
    """Whether what was known with a length `then` holds `now`."""
    return now <= (1.0 + ROUND_OFF) * GROWN * then
