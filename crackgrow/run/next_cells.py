"""Which cells come next for a target: halved at the cracks that are off by more, or joined where K is far better.

The goal's bound is of all cracks; where it is off by more cells are halved at all of them and at corners. What does not
fall with the cells there is halved everywhere.
"""

from __future__ import annotations

import math
from dataclasses import replace

from crackgrow.cover.refinement import MOST_LEVELS
from crackgrow.run.halvings import Accuracy, Halvings
from crackgrow.run.judging import StepSolution
from crackgrow.run.layout import cells_of

Wanted = tuple[Halvings | None, str]
"""The cells to try for a step that misses its target; None and why, where there are none."""

MOST_AT_ONCE = 3
"""Halvings in one round."""

FAR_BELOW = 1.0 / 6.0
"""Of the target: cells of a crack with less are joined, once a step."""

STUCK = 0.8
"""An error of which this is left does not come from the cells at the crack: all are halved."""


def with_joined(solution: StepSolution) -> Halvings:
    """Those of a step, with cells joined at cracks whose K is far better than the target."""
    halvings, accuracy = solution.scene.halvings, solution.accuracy
    if accuracy is None:
        return halvings
    fewer = []
    for crack, n in enumerate(halvings.cracks):
        shares = accuracy.shares(crack)
        joined = bool(shares) and max(shares) < FAR_BELOW * _target(solution)
        fewer.append(max(n - joined, 0))
    return replace(halvings, cracks=tuple(fewer))


def _target(solution: StepSolution) -> float:
    target = solution.scene.case.numerics.target
    assert target is not None  # else no cells are chosen
    return target


def for_goal(solution: StepSolution, now: Accuracy, before: Accuracy | None) -> Wanted:
    """Of another goal than K: at all cracks and corners, or everywhere where that does not help."""
    if math.isinf(now.goal):
        return None, "it is nothing: no cells can be chosen by it"
    if math.isnan(now.goal):
        return None, "there is no solution on cells twice as large to hold it against"
    halvings, scene = now.halvings, solution.scene
    more = math.ceil(math.log2(min(now.goal / _target(solution), 2.0**MOST_AT_ONCE)))
    if before is None or not now.goal > STUCK * before.goal:
        at_cracks = tuple(min(n + more, MOST_LEVELS) for n in halvings.cracks)
        wanted = replace(halvings, cracks=at_cracks, corners=min(halvings.corners + more, MOST_LEVELS))
        if not cells_of(scene.with_halvings(wanted), solution.cracks).equal(solution.cover.lattice.cells):
            return wanted, ""
    return replace(halvings, everywhere=halvings.everywhere + 1), ""


def for_K(solution: StepSolution, now: Accuracy, before: Accuracy | None) -> Wanted:
    """Crack by crack, or everywhere where that does not help."""
    if before is not None and min(now.shares(), default=0.0) >= 1.0:
        return None, "K is nothing beside what it is off by, as where faces stick: no cells can be chosen by it"
    halvings = now.halvings
    cracks = []
    for crack, n in enumerate(halvings.cracks):
        share = max(now.shares(crack), default=0.0)
        at_once = MOST_AT_ONCE if n else 1  # the first one comes with those at kinks
        more = math.ceil(math.log2(min(max(share / _target(solution), 1.0), 2.0**at_once)))
        cracks.append(min(n + more, MOST_LEVELS))
    worst = [max(known.shares()) for known in (now, before) if known is not None]
    wanted = replace(halvings, cracks=tuple(cracks))
    if wanted != halvings and not (len(worst) == 2 and worst[0] > STUCK * worst[1]):
        return wanted, ""
    if halvings.everywhere >= MOST_LEVELS:
        return None, f"all cells are halved {MOST_LEVELS} times already"
    return replace(halvings, everywhere=halvings.everywhere + 1), ""
