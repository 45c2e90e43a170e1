"""For how long what was measured of the error of K holds while cracks grow.

It does until a crack has grown by some part of what it had grown, or a tip more or less is there.
"""

from __future__ import annotations

from dataclasses import replace

from crackgrow.geometry.polyline import arc_lengths
from crackgrow.run.halvings import Accuracy
from crackgrow.run.judging import StepSolution
from crackgrow.run.other_cells import fitted_bounds, fitted_share, largest_K

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


def holds(last: Accuracy, solution: StepSolution, grown: tuple[float, ...]) -> bool:
    """Whether what was known of the step before is good enough for this one, in which cracks have `grown`."""
    same = last.ends == tuple(solution.cover.tip_ends) and last.halvings == solution.scene.halvings
    if not same or any(now > (1.0 + ROUND_OFF) * GROWN * then for now, then in zip(grown, last.grown, strict=True)):
        return False
    return fitted_share(solution, fitted_bounds(solution)) <= GROWN * last.fitted


def carried_over(last: Accuracy, solution: StepSolution) -> Accuracy:
    """What was known of the step before, in the same shares of the K of this one."""
    largest = largest_K(solution)
    scale = largest / last.largest if last.largest > 0.0 else 1.0
    bounds, expected = (tuple(scale * error for error in errors) for errors in (last.bounds, last.expected))
    return replace(last, bounds=bounds, expected=expected, largest=largest)
