"""Cells for a target of the error of K: halved at the cracks whose K is off by more, until the bound meets it.

A step begins with the cells of the one before. What is known of its error holds until a crack has grown by some part of
what it had grown, or a tip more or less is there: then it is measured anew, and cells are halved where that asks for
it, and joined where the error is far below the target.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

from crackgrow.case.model import LoadHistory
from crackgrow.cover.refinement import MOST_LEVELS
from crackgrow.errors import GeometryError, NotSolvedError, SolveError
from crackgrow.fracture.advance import GrowingCrack
from crackgrow.geometry.polyline import arc_lengths
from crackgrow.run.configuration import Configuration, lay_out
from crackgrow.run.goal import goal_bound
from crackgrow.run.halvings import Accuracy, Halvings
from crackgrow.run.increments import LoadState, Origin
from crackgrow.run.judging import StepSolution
from crackgrow.run.loading import load_history
from crackgrow.run.other_cells import (
    accuracy_of,
    compared,
    fitted_bounds,
    fitted_share,
    largest_K,
    still_tells,
)
from crackgrow.run.scene import Scene

MOST_ROUNDS = 4
"""Times that cells are halved for one step."""

MOST_AT_ONCE = 3
"""Halvings in one of them."""

MOST_UNKNOWNS = 150_000
"""Cells are not halved where that may give more."""

FAR_BELOW = 1.0 / 6.0
"""Of the target: cells of a crack with less are joined, once a step."""

STUCK = 0.8
"""An error of which this is left does not come from the cells at the crack: all are halved."""

GROWN = 2.0
"""What is known of the error holds until what was added to a crack is so many times as long, or B so much of K."""


@dataclass(frozen=True, slots=True, eq=False)
class Ways:
    """How a step is solved again on other cells."""

    solve: Callable[[Scene, Configuration], StepSolution]
    state: Callable[[Scene, float, Configuration], LoadState]  # at a load factor
    # both may take over what they have in common with a configuration


class _History:
    """The loads of a history one after the other on the cells of a scene."""

    def __init__(
        self,
        scene: Scene,
        cracks: tuple[GrowingCrack, ...],
        first: int = 0,
        origin: Origin | None = None,
        like: Configuration | None = None,
    ) -> None:
        self.scene, self._next = scene, first
        self._solutions = load_history(scene, cracks, first, origin, like)

    def at(self, number: int) -> StepSolution:
        """The solution under a load that has not been asked for. Raises SolveError where there is none."""
        for solution in self._solutions:
            self._next += 1
            if self._next > number:
                return solution
        raise NotSolvedError("an earlier load of the history has no solution on these cells")


def aimed_history(
    scene: Scene, cracks: tuple[GrowingCrack, ...], first: int, origin: Origin | None, known: Accuracy | None
) -> Iterator[StepSolution]:
    """The cracks at every factor of the case's history, from number `first` on, on cells that meet the target there.

    Where they are halved all loads before are gone through again. `known` is what was measured at the first.
    """
    loading = scene.case.loading
    assert isinstance(loading, LoadHistory)
    if known is not None:
        scene = replace(scene, halvings=known.halvings)
    pair = _Pair(_History(scene, cracks, first, origin), cracks)
    for number in range(first, len(loading.factors)):
        pair.number = number
        solution = pair.fine.at(number)
        if number == first and known is not None:
            yield replace(solution, accuracy=known)
        else:
            yield aimed(solution, cracks, Ways(pair.solve, pair.state_on_others), None)


@dataclass(slots=True, eq=False)
class _Pair:
    """A history on the cells of now and on those to compare."""

    fine: _History
    cracks: tuple[GrowingCrack, ...]
    other: _History | None = None
    number: int = 0  # of the load

    def solve(self, scene: Scene, like: Configuration) -> StepSolution:
        """The solution on other cells."""
        self.fine = _History(scene, self.cracks, like=like)
        return self.fine.at(self.number)

    def state_on_others(self, scene: Scene, _: float, like: Configuration) -> LoadState:
        """The state on the cells to compare."""
        if self.other is None or scene.halvings != self.other.scene.halvings:
            self.other = _History(scene, self.cracks, like=like)
        return self.other.at(self.number).state


def aimed(solution: StepSolution, cracks: tuple[GrowingCrack, ...], ways: Ways, last: Accuracy | None) -> StepSolution:
    """The step on cells that meet the target, or as near as they come, with what is known of its error.

    `last` is what was known of the step before.
    """
    scene = solution.configuration.scene
    target, of_K = scene.case.numerics.target, scene.case.numerics.goal == "K"
    assert target is not None
    grown = _grown(scene, cracks)
    if of_K and not any(math.isfinite(tip.intensity.K_I) for tip in solution.tips):
        why = "K is not known at any tip" if solution.tips else "" if any(grown) else "no crack has a tip"
        return replace(solution, accuracy=replace(accuracy_of(solution, None), grown=grown, missed=why))
    if last is not None and _holds(last, solution, grown):
        return replace(solution, accuracy=_scaled(last, largest_K(solution)))
    n_solves, seconds, before, missed, known = solution.factorizations, Counter(solution.seconds), None, "", last
    other: LoadState | None = None
    for round_ in range(MOST_ROUNDS + 1):
        told = None if other is None or not still_tells(solution, other) else accuracy_of(solution, other)
        if told is None or not _met(told, target, of_K):
            other = _compared(ways, solution, known)
            told = accuracy_of(solution, other)
            n_solves += 1
            if other is not None:
                seconds.update({**other.configuration.seconds, "contact": other.seconds})
        known = replace(told, grown=grown)
        if not of_K:
            known = replace(known, goal=goal_bound(solution, other))
        if _met(known, target, of_K):
            break
        wanted, missed = (
            _halved(target, known, before) if of_K else _halved_for_goal(target, solution, cracks, known, before)
        )
        if wanted is not None and solution.cover.sizes.min() <= 0.5**MOST_LEVELS:
            wanted, missed = None, f"cells are halved {MOST_LEVELS} times already, which is the most"
        if wanted is None or round_ == MOST_ROUNDS:
            missed = missed or f"cells were divided in {MOST_ROUNDS} rounds for it"
            break
        before, scene = known, replace(scene, halvings=wanted)
        try:
            solution = _solved(ways, scene, cracks, solution.configuration)
        except (GeometryError, SolveError) as error:
            missed = f"smaller cells are not to be had: {error}"
            break
        n_solves += solution.factorizations
        seconds.update(solution.seconds)
    assert known is not None
    return replace(solution, accuracy=replace(known, missed=missed), factorizations=n_solves, seconds=dict(seconds))


def _met(known: Accuracy, target: float, of_K: bool) -> bool:
    return max(known.shares(), default=0.0 if of_K else math.inf) <= target


def _solved(ways: Ways, scene: Scene, cracks: tuple[GrowingCrack, ...], before: Configuration) -> StepSolution:
    """The solution on the cells of a scene. Raises GeometryError or SolveError where there is none, or it is large.

    So it does where the cells are those `before`.
    """
    cover = lay_out(scene, cracks)[0]
    n_dofs = cover.n_dofs
    if cover.lattice.cells.equal(before.cover.lattice.cells):
        raise NotSolvedError(f"they are halved {MOST_LEVELS} times already, which is the most")
    if n_dofs > MOST_UNKNOWNS:
        raise NotSolvedError(f"they make {n_dofs:,} unknowns, and at most {MOST_UNKNOWNS:,} are taken")
    return ways.solve(scene, before)


def halvings_after(solution: StepSolution) -> Halvings:
    """The cells that the step after a solution begins with."""
    scene, accuracy = solution.configuration.scene, solution.accuracy
    halvings, target = scene.halvings, scene.case.numerics.target
    if target is None or accuracy is None or scene.case.numerics.goal != "K":
        return halvings
    fewer = []
    for crack, n in enumerate(halvings.cracks):
        shares = accuracy.shares(crack)
        joined = bool(shares) and max(shares) < FAR_BELOW * target
        fewer.append(max(n - joined, 0))
    return replace(halvings, cracks=tuple(fewer))


def _compared(ways: Ways, solution: StepSolution, last: Accuracy | None) -> LoadState | None:
    """The state on the cells to compare, None where there is none; at its own load factor where that is the goal."""
    like = solution.configuration if last is None or last.compared is None else last.compared
    try:
        if solution.configuration.scene.case.numerics.goal == "load_factor":
            return ways.solve(compared(solution), like).state
        return ways.state(compared(solution), solution.state.factor, like)
    except (GeometryError, SolveError):
        return None


def _grown(scene: Scene, cracks: tuple[GrowingCrack, ...]) -> tuple[float, ...]:
    """What has been added to each crack, m."""
    pairs = zip(cracks, scene.case.cracks, strict=True)
    return tuple(float(arc_lengths(now.crack.points)[-1] - arc_lengths(given.points)[-1]) for now, given in pairs)


def _holds(last: Accuracy, solution: StepSolution, grown: tuple[float, ...]) -> bool:
    """Whether what was known of the step before is good enough for this one."""
    same = last.ends == tuple(solution.cover.tip_ends) and last.halvings == solution.configuration.scene.halvings
    if not same or any(now > GROWN * then for now, then in zip(grown, last.grown, strict=True)):
        return False
    return fitted_share(solution, fitted_bounds(solution)) <= GROWN * last.fitted


def _scaled(last: Accuracy, largest: float) -> Accuracy:
    """The same shares of another K."""
    scale = largest / last.largest if last.largest > 0.0 else 1.0
    bounds, expected = (tuple(scale * error for error in errors) for errors in (last.bounds, last.expected))
    return replace(last, bounds=bounds, expected=expected, largest=largest)


def _halved_for_goal(
    target: float, solution: StepSolution, cracks: tuple[GrowingCrack, ...], now: Accuracy, before: Accuracy | None
) -> tuple[Halvings | None, str]:
    """The same for another goal than K: at all cracks and corners, or everywhere where that does not help."""
    if math.isinf(now.goal):
        return None, "it is nothing: no cells can be chosen by it"
    if math.isnan(now.goal):
        return None, "there is no solution on cells twice as large to hold it against"
    halvings, scene = now.halvings, solution.configuration.scene
    more = math.ceil(math.log2(min(now.goal / target, 2.0**MOST_AT_ONCE)))
    if before is None or not now.goal > STUCK * before.goal:
        at_cracks = tuple(min(n + more, MOST_LEVELS) for n in halvings.cracks)
        wanted = replace(halvings, cracks=at_cracks, corners=min(halvings.corners + more, MOST_LEVELS))
        cells = lay_out(replace(scene, halvings=wanted), cracks)[0].lattice.cells
        if not cells.equal(solution.cover.lattice.cells):
            return wanted, ""
    return replace(halvings, everywhere=halvings.everywhere + 1), ""


def _halved(target: float, now: Accuracy, before: Accuracy | None) -> tuple[Halvings | None, str]:
    """The cells to try next; None and why, where there are none."""
    if before is not None and min(now.shares(), default=0.0) >= 1.0:
        return None, "K is nothing beside what it is off by, as where faces stick: no cells can be chosen by it"
    halvings = now.halvings
    cracks = []
    for crack, n in enumerate(halvings.cracks):
        share = max(now.shares(crack), default=0.0)
        at_once = MOST_AT_ONCE if n else 1  # the first one comes with those at kinks
        more = math.ceil(math.log2(min(max(share / target, 1.0), 2.0**at_once)))
        cracks.append(min(n + more, MOST_LEVELS))
    worst = [max(known.shares()) for known in (now, before) if known is not None]
    wanted = replace(halvings, cracks=tuple(cracks))
    if wanted != halvings and not (len(worst) == 2 and worst[0] > STUCK * worst[1]):
        return wanted, ""
    if halvings.everywhere >= MOST_LEVELS:
        return None, f"all cells are halved {MOST_LEVELS} times already"
    return replace(halvings, everywhere=halvings.everywhere + 1), ""
