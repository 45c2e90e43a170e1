"""What a run measures the error of, and halves cells for: K of the tips, or another goal.

Either is held against the same on other cells; they differ in which cells those are, in what the difference tells, and
in the cells that come next where it is too large.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final, Protocol

from crackgrow.case.model import Case, Goal, StrengthReduction
from crackgrow.errors import NotSolvedError
from crackgrow.run.configuration import Configuration
from crackgrow.run.goal import goal_bound
from crackgrow.run.halvings import Accuracy, Halvings
from crackgrow.run.increments import LoadState
from crackgrow.run.judging import StepSolution
from crackgrow.run.next_cells import Wanted, for_goal, for_K, with_joined
from crackgrow.run.other_cells import accuracy_of, compared, still_tells
from crackgrow.run.scene import Scene

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


class Aim(ABC):
    """What the error is of. Where nothing else is said: what any solution has, and another state tells of once."""

    def is_there(self, _: StepSolution) -> bool:
        """Whether a solution has it."""
        return True

    def why_not(self, _: StepSolution, __: Sequence[float]) -> str:
        """Why it has not, where that is no matter of course; with what was added to each crack, m."""
        return ""

    @abstractmethod
    def other(self, solution: StepSolution, ways: Ways, like: Configuration) -> tuple[LoadState, Counter[str]]:
        """The state on the cells that a solution is held against, and its seconds. Raises as `Ways` do."""

    def still_tells(self, _: StepSolution, __: LoadState) -> bool:
        """Whether a state that was made for a solution on larger cells tells the error of this one, too."""
        return False

    @abstractmethod
    def accuracy(self, solution: StepSolution, other: LoadState | None) -> Accuracy:
        """What a state on the other cells tells, None where there is none."""

    @abstractmethod
    def off(self, known: Accuracy) -> float:
        """The bound over the largest value, where it is largest."""

    @abstractmethod
    def next_cells(self, solution: StepSolution, now: Accuracy, before: Accuracy | None) -> Wanted:
        """The cells to try for a step that misses its target, by what is known on these and those before."""

    def cells_after(self, solution: StepSolution) -> Halvings:
        """The cells that the step after a solution begins with."""
        return solution.scene.halvings


class OfK(Aim):
    """K of the tips."""

    def is_there(self, solution: StepSolution) -> bool:
        """Whether K of a tip is known."""
        return any(math.isfinite(tip.intensity.K_I) for tip in solution.tips)

    def why_not(self, solution: StepSolution, grown: Sequence[float]) -> str:
        """Nothing where cracks have grown until no tip was left."""
        if solution.tips:
            return "K is not known at any tip"
        if any(grown):
            return ""
        growth = solution.scene.case.growth
        waits = growth is not None and growth.initiation.at != "tips"
        return f"no crack has a tip{' yet' if waits else ''}"

    def other(self, solution: StepSolution, ways: Ways, like: Configuration) -> tuple[LoadState, Counter[str]]:
        """The state at the solution's load factor, or where bonds break at it, which they do not elsewhere, at its own.

        A name takes no such time for a large scene.
        """
        case, n_dofs = solution.scene.case, solution.cover.n_dofs
        if case.numerics.target is None and not measures_by_name(case, n_dofs):
            raise NotSolvedError(f"{n_dofs:,} unknowns are more than {MOST_UNKNOWNS_OF_A_NAME:,}")
        if any(solution.jumps):
            solved = ways.solve(compared(solution), like)
            return solved.state, Counter(solved.seconds)
        return ways.state(compared(solution), solution.state.factor, like)

    def still_tells(self, solution: StepSolution, other: LoadState) -> bool:
        """Whether it does by the cells at tips and kinks."""
        return still_tells(solution, other)

    def accuracy(self, solution: StepSolution, other: LoadState | None) -> Accuracy:
        """By both K of each crack's tips."""
        return accuracy_of(solution, other)

    def off(self, known: Accuracy) -> float:
        """The largest of all tips'; nothing where there are none."""
        return max(known.shares(), default=0.0)

    def next_cells(self, solution: StepSolution, now: Accuracy, before: Accuracy | None) -> Wanted:
        """Crack by crack."""
        return for_K(solution, now, before)

    def cells_after(self, solution: StepSolution) -> Halvings:
        """Joined at cracks whose K is far better than asked for."""
        return with_joined(solution)


@dataclass(frozen=True, slots=True)
class OfGoal(Aim):
    """A goal other than K, which any solution has: the check of the case sees to that.

    A state tells of cells just half as large. What is known of K besides is its fitted bound.
    """

    goal: Goal

    def other(self, solution: StepSolution, ways: Ways, like: Configuration) -> tuple[LoadState, Counter[str]]:
        """The state on cells that are all twice as large: at the same load factor, or at its own where that is it."""
        doubled = solution.scene.with_halvings(solution.scene.halvings.doubled)
        if self.goal != "load_factor":
            return ways.state(doubled, solution.state.factor, like)
        solved = ways.solve(doubled, like)
        return solved.state, Counter(solved.seconds)

    def accuracy(self, solution: StepSolution, other: LoadState | None) -> Accuracy:
        """By the goal of both."""
        known = None if other is None else other.configuration
        return replace(accuracy_of(solution, None), compared=known, goal=goal_bound(solution, other))

    def off(self, known: Accuracy) -> float:
        """The goal's; it may not be known."""
        return known.goal if math.isfinite(known.goal) else math.inf

    def next_cells(self, solution: StepSolution, now: Accuracy, before: Accuracy | None) -> Wanted:
        """At all cracks and corners."""
        return for_goal(solution, now, before)


def aim_of(scene: Scene) -> Aim:
    """What a scene's error is measured of."""
    goal = scene.case.numerics.measured_of
    return OfK() if goal == "K" else OfGoal(goal)
