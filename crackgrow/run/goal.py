"""The error of what a case aims at other than K, from the same on cells that are all twice as large.

Where cells resolve what happens, each halving leaves a third to two thirds of the error, at corners three quarters, and
what is left is 0.5 to 3 times the difference D of the two: the bound is 3 D, over the quantity's largest value.

    slip         the jump of the faces of all surfaces, opening and slip, at places along them
    reaction     the forces of all supports, foundations and interfaces
    load_factor  the critical one
"""

from __future__ import annotations

from typing import Final

import numpy as np

from crackgrow.arrays import Floats
from crackgrow.contact.faces import points_at
from crackgrow.contact.jump import gap_and_slip
from crackgrow.run.increments import LoadState
from crackgrow.run.judging import StepSolution
from crackgrow.run.reactions import reactions

OF_DIFFERENCE: Final = 3.0

PLACES: Final = 65
"""Along each surface."""

NOTHING: Final = 1e-9
"""Of the loads, or of what the loads displace: a reaction or a jump below is round-off."""


def goal_bound(solution: StepSolution, larger: LoadState | None) -> float:
    """The bound, over the largest value; nan where there is no solution on `larger` cells, infinite of nothing."""
    if larger is None:
        return float("nan")
    goal = solution.scene.case.numerics.goal
    if goal == "load_factor":
        return OF_DIFFERENCE * abs(larger.factor / solution.state.factor - 1.0)
    of_both = [_forces(state) if goal == "reaction" else _jumps(state) for state in (solution.state, larger)]
    size = _largest(of_both[0])
    if size <= NOTHING * (_load(solution) if goal == "reaction" else float(np.abs(solution.outcome.u).max())):
        return float("inf")
    return OF_DIFFERENCE * _largest(of_both[0] - of_both[1]) / size


def _forces(state: LoadState) -> Floats:
    """Forces (n, 2) N/m."""
    return np.array([reaction.force for reaction in reactions(state)]).reshape(-1, 2)


def _load(solution: StepSolution) -> float:
    """What the reactions are small beside, N/m: the loads and all reactions."""
    return float(np.abs(solution.loads).sum() + np.abs(_forces(solution.state)).sum())


def _jumps(state: LoadState) -> Floats:
    """Opening and slip (n, 2) m, at places that do not depend on the cells."""
    cover, found = state.cover, [np.zeros((0, 2))]
    for index, surface in enumerate(cover.surfaces):
        s = surface.edges.s
        places = s.min() + np.linspace(0.0, 1.0, PLACES) * (s.max() - s.min())
        found.append(np.column_stack(gap_and_slip(cover, points_at(cover, index, places), state.outcome.u)))
    return np.concatenate(found)


def _largest(vectors: Floats) -> float:
    return float(np.hypot(*vectors.T).max(initial=0.0))
