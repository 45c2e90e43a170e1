"""For how long what was measured of the error of K holds while cracks grow.

What is known of the K of a crack holds until what was added to it is over twice as long, or one of its tips more or
less is there. For a target all of it has to hold. A name chooses no cells by it: it is measured anew once what was
added to all cracks together is over twice as long, and until then the fitted bound tells of those that have grown more.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from crackgrow.geometry.polyline import arc_lengths
from crackgrow.run.halvings import Accuracy
from crackgrow.run.judging import StepSolution
from crackgrow.run.other_cells import fitted_share, largest_K

GROWN = 2.0
"""What is known of the error holds until what was added to a crack is over so many times as long, or B so much of K.

It still does at just so many times, as where increments are alike.
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


def holds(last: Accuracy, solution: StepSolution, grown: tuple[float, ...], fitted: Sequence[float]) -> bool:
    """Whether what was known of the step before is good enough for this one, in which cracks have `grown`.

    `fitted` are the fitted bounds of its tips.
    """
    if solution.scene.case.numerics.target is None:
        lengths_hold = _is_like(sum(grown), sum(last.grown))
    else:
        same = last.ends == tuple(solution.cover.tip_ends) and last.halvings == solution.scene.halvings
        lengths_hold = same and all(_is_like(*lengths) for lengths in zip(grown, last.grown, strict=True))
    return lengths_hold and fitted_share(solution, fitted) <= GROWN * last.fitted


def _is_like(now: float, then: float) -> bool:
    """Whether what was known with a length `then` holds `now`."""
    return now <= (1.0 + ROUND_OFF) * GROWN * then


def carried_over(last: Accuracy, solution: StepSolution, grown: tuple[float, ...], fitted: Sequence[float]) -> Accuracy:
    """What was measured before, in the same shares of the K of this step; of other tips the `fitted` bound."""
    largest = largest_K(solution)
    scale = largest / last.largest if last.largest > 0.0 else 1.0
    then = dict(enumerate(last.grown))  # a crack that has started since had nothing
    known = {
        end: (scale * bound, scale * expected)
        for end, bound, expected in zip(last.ends, last.bounds, last.expected, strict=True)
        if not math.isnan(expected) and _is_like(grown[end[0]], then.get(end[0], 0.0))
    }
    ends = tuple(solution.cover.tip_ends)
    of_tips = [known.get(end, (bound, math.nan)) for end, bound in zip(ends, fitted, strict=True)]
    bounds, expected = zip(*of_tips, strict=True) if of_tips else ((), ())
    return replace(last, ends=ends, bounds=bounds, expected=expected, largest=largest)
