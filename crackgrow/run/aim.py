"""What a run measures the error of, and halves cells for: K of the tips, or another goal.

Either is held against the same on other cells; they differ in which cells those are, in what the difference tells, and
in the cells that come next where it is too large.

Of a goal other than K the cells are all twice as large. Where cells resolve what happens, each halving leaves a third
to two thirds of the error, at corners three quarters, and what is left is 0.5 to 3 times the difference D of the two:
the bound is 3 D, over the quantity's largest value.

    slip         the jump of the faces of all surfaces, opening and slip, at places along them
    reaction     the forces of all supports, foundations and interfaces
    load_factor  the critical one
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Final, Protocol

import numpy as np

from crackgrow.arrays import Floats
from crackgrow.case.model import Case, Goal, StrengthReduction
from crackgrow.contact.faces import points_at
from crackgrow.contact.jump import gap_and_slip
from crackgrow.errors import NotSolvedError
from crackgrow.run.configuration import Configuration
from crackgrow.run.halvings import Accuracy, Halvings
from crackgrow.run.increments import LoadState
from crackgrow.run.judging import StepSolution
from crackgrow.run.next_cells import Wanted, for_goal, for_K, with_joined
from crackgrow.run.other_cells import accuracy_of, compared, still_tells
from crackgrow.run.reactions import reactions
from crackgrow.run.scene import Scene

OF_DIFFERENCE: Final = 3.0

PLACES: Final = 65
"""Along each surface."""

NOTHING: Final = 1e-9
"""Of the loads, or of what the loads displace: a reaction or a jump below is round-off."""

MOST_UNKNOWNS_OF_A_NAME: Final = 60_000
"""The error of a larger scene is measured for a target alone: smaller cells would take some GB for a hundred flaws."""


def measures_by_name(case: Case, n_dofs: int) -> bool:
    """Whether a step of so many unknowns on the cells of a name is held against smaller ones.

    Not where strength is reduced: of that search the factor of safety counts, and K of no tip.
    """
    numerics, reduced = case.numerics, isinstance(case.loading, StrengthReduction)
    by_name = numerics.measured and numerics.target is None
    return by_name and not reduced and n_dofs <= MOST_UNKNOWNS_OF_A_NAME


class Ways(Protocol):
    """How a step is solved again on other cells; what they have in common with a configuration may be taken over."""

    def solve(self, scene: Scene, like: Configuration, /) -> StepSolution:
        """The step."""

    def state(self, scene: Scene, factor: float, like: Configuration, /) -> tuple[LoadState, Counter[str]]:
        """Its state at a load factor, and the seconds that it has taken."""


@dataclass(frozen=True, slots=True)
class Aim:
    """What the error is of, as functions of solutions."""

    is_there: Callable[[StepSolution], bool]  # whether a solution has it
    why_not: Callable[[StepSolution, Sequence[float]], str]  # by what was added to each crack, m; empty: no wonder
    other: Callable[[StepSolution, Ways, Configuration], tuple[LoadState, Counter[str]]]  # on cells to compare, seconds
    still_tells: Callable[[StepSolution, LoadState], bool]  # whether one made for larger cells tells of these, too
    accuracy: Callable[[StepSolution, LoadState | None], Accuracy]  # what it tells; None: there is none
    off: Callable[[Accuracy], float]  # the bound over the largest value, where it is largest
    next_cells: Callable[[StepSolution, Accuracy, Accuracy | None], Wanted]  # by what is known now and was before
    cells_after: Callable[[StepSolution], Halvings]  # that the next step begins with


def aim_of(scene: Scene) -> Aim:
    """What a scene's error is measured of; a goal other than K any solution has: the check of the case sees to that."""
    goal = scene.case.numerics.measured_of
    if goal == "K":
        return Aim(_has_K, _why_no_K, _other_of_K, still_tells, accuracy_of, _off_of_K, for_K, with_joined)
    return Aim(
        is_there=lambda _: True,
        why_not=lambda _, __: "",
        other=partial(_other_of_goal, goal),
        still_tells=lambda _, __: False,
        accuracy=_accuracy_of_goal,
        off=lambda known: known.goal if math.isfinite(known.goal) else math.inf,
        next_cells=for_goal,
        cells_after=lambda solution: solution.scene.halvings,
    )


def _has_K(solution: StepSolution) -> bool:
    return any(math.isfinite(tip.intensity.K_I) for tip in solution.tips)


def _why_no_K(solution: StepSolution, grown: Sequence[float]) -> str:
    """Nothing where cracks have grown until no tip was left."""
    if solution.tips:
        return "K is not known at any tip"
    if any(grown):
        return ""
    growth = solution.scene.case.growth
    waits = growth is not None and growth.initiation.at != "tips"
    return f"no crack has a tip{' yet' if waits else ''}"


def _off_of_K(known: Accuracy) -> float:
    """The largest of all tips'; nothing where there are none."""
    return max(known.shares(), default=0.0)


def _other_of_K(solution: StepSolution, ways: Ways, like: Configuration) -> tuple[LoadState, Counter[str]]:
    """The state at the solution's load factor, or where bonds break at it, which they do not elsewhere, at its own.

    A name takes no such time for a large scene. Raises as `Ways` do.
    """
    case, n_dofs = solution.scene.case, solution.cover.n_dofs
    if case.numerics.target is None and not measures_by_name(case, n_dofs):
        raise NotSolvedError(f"{n_dofs:,} unknowns are more than {MOST_UNKNOWNS_OF_A_NAME:,}")
    if any(solution.jumps):
        solved = ways.solve(compared(solution), like)
        return solved.state, Counter(solved.seconds)
    return ways.state(compared(solution), solution.state.factor, like)


def _other_of_goal(
    goal: Goal, solution: StepSolution, ways: Ways, like: Configuration
) -> tuple[LoadState, Counter[str]]:
    """The state at the same load factor, or at its own where that is the goal. Raises as `Ways` do."""
    doubled = solution.scene.with_halvings(solution.scene.halvings.doubled)
    if goal != "load_factor":
        return ways.state(doubled, solution.state.factor, like)
    solved = ways.solve(doubled, like)
    return solved.state, Counter(solved.seconds)


def _accuracy_of_goal(solution: StepSolution, other: LoadState | None) -> Accuracy:
    """By the goal of both; what is known of K besides is its fitted bound."""
    known = None if other is None else other.configuration
    return replace(accuracy_of(solution, None), compared=known, goal=goal_bound(solution, other))


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
