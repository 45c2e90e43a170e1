"""Which cells come next for a target: halved at the cracks that are off by more, or joined where K is far better.

The goal's bound is of all cracks; where it is off by more cells are halved at all of them and at corners. What does not
fall with the cells there is halved everywhere.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from crackgrow.cover.refinement import MOST_LEVELS
from crackgrow.run.advancing import End
from crackgrow.run.halvings import Accuracy, Halvings, Place
from crackgrow.run.judging import StepSolution
from crackgrow.run.layout import cells_of
from crackgrow.run.other_cells import largest_K
from crackgrow.run.parting import Partings, partings
from crackgrow.run.still_known import JOINED

Wanted = tuple[Halvings | None, str]
"""The cells to try for a step that misses its target; None and why, where there are none."""

MOST_AT_ONCE = 3
"""Halvings in one round."""

FAR_BELOW = 1.0 / JOINED
"""Of the target: cells of a crack with less are joined, once a step. So wide its bound is within the target still."""

PART_OF_PARTING = 1.0 / 2.0
"""Of the target: what K may be off by where faces part."""

NOTHING = 0.01
"""Of that: a place where faces part asks for nothing."""

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
    halvings = now.halvings
    more = math.ceil(math.log2(min(now.goal / _target(solution), 2.0**MOST_AT_ONCE)))
    if before is None or not now.goal > STUCK * before.goal:
        at_cracks = tuple(min(n + more, MOST_LEVELS) for n in halvings.cracks)
        wanted = replace(halvings, cracks=at_cracks, corners=min(halvings.corners + more, MOST_LEVELS))
        if _are_others(wanted, solution):
            return wanted, ""
    return replace(halvings, everywhere=halvings.everywhere + 1), ""


def _are_others(wanted: Halvings, solution: StepSolution) -> bool:
    """Whether the cells are not those of the solution."""
    scene = solution.scene
    if wanted == scene.halvings:
        return False
    return not cells_of(scene.with_halvings(wanted), solution.cracks).equal(solution.cover.lattice.cells)


def _share_of_the_rest(crack: int, now: Accuracy, found: Mapping[End, Partings]) -> float:
    """The bound at a crack over the largest K, less what is missed where its faces part."""
    share = max(now.shares(crack), default=0.0)
    parting = max((float(each.K.sum()) for end, each in found.items() if end[0] == crack), default=0.0)
    missed = parting / now.largest if now.largest > 0.0 else 0.0
    return math.sqrt(max(share**2 - missed**2, 0.0))


def _places_for(solution: StepSolution, found: Mapping[End, Partings]) -> tuple[Place, ...]:
    """The stretches over which faces part, with cells small enough there for a part of the target, or as they are."""
    scene, times = solution.scene, dict[tuple[float, float, float, float], int]()
    allowed = PART_OF_PARTING * _target(solution) * largest_K(solution)
    largest_cell = 0.5**scene.halvings.everywhere * scene.case.numerics.spacing
    for each in found.values():
        share = allowed / max(len(each.K), 1)
        for x, y, to_x, to_y, cell, K, of_shear in np.column_stack([
            each.places, each.cells, each.K, each.of_shear,
        ]).tolist():  # fmt: skip
            if not NOTHING * allowed < K:  # nor where two contact points are in one place, as at kinks
                continue
            # the rest of K falls with the square of the cells: a part f of them leaves f of_shear + f^2 (K - of_shear)
            part = 2.0 * share / (of_shear + math.sqrt(of_shear**2 + 4.0 * share * (K - of_shear)))
            size = cell * min(max(part, 0.5**MOST_AT_ONCE), 2.0)
            more = min(math.ceil(math.log2(max(largest_cell / size, 1.0))), MOST_LEVELS)
            times[x, y, to_x, to_y] = max(more, times.get((x, y, to_x, to_y), 0))
    return tuple((x, y, to_x, to_y, more) for (x, y, to_x, to_y), more in times.items() if more)


def for_K(solution: StepSolution, now: Accuracy, before: Accuracy | None) -> Wanted:
    """Crack by crack, or everywhere where that does not help."""
    if before is not None and min(now.shares(), default=0.0) >= 1.0:
        return None, "K is nothing beside what it is off by, as where faces stick: no cells can be chosen by it"
    halvings, parting = now.halvings, partings(solution.state, solution.tips)
    cracks = []
    for crack, n in enumerate(halvings.cracks):
        share = _share_of_the_rest(crack, now, parting)
        at_once = MOST_AT_ONCE if n else 1  # the first one comes with those at kinks
        more = math.ceil(math.log2(min(max(share / _target(solution), 1.0), 2.0**at_once)))
        cracks.append(min(n + more, MOST_LEVELS))
    worst = [max(known.shares()) for known in (now, before) if known is not None]
    wanted = replace(halvings, cracks=tuple(cracks), places=_places_for(solution, parting))
    if not (len(worst) == 2 and worst[0] > STUCK * worst[1]) and _are_others(wanted, solution):
        return wanted, ""
    if halvings.everywhere >= MOST_LEVELS:
        return None, f"all cells are halved {MOST_LEVELS} times already"
    return replace(halvings, everywhere=halvings.everywhere + 1), ""
