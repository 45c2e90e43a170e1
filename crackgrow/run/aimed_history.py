"""Loads in turn, or stages, on cells that meet a target at each of them: the same history on several lattices."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

from crackgrow.errors import NotSolvedError
from crackgrow.fracture.advance import GrowingCrack
from crackgrow.run.configuration import Configuration
from crackgrow.run.halvings import Accuracy
from crackgrow.run.increments import LoadState, Origin
from crackgrow.run.judging import StepSolution
from crackgrow.run.loading import load_history
from crackgrow.run.scene import Scene
from crackgrow.run.target import Ways, aimed


class _History:
    """The loads of a history, or its stages, one after the other on the cells of a scene."""

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
    """The cracks at every factor of the case's history, or after every stage, on cells that meet the target there.

    From number `first` on. Where cells are halved all loads before are gone through again: contact remembers them, and
    rock is taken out on the cells that it was loaded on. `known` is what was measured at the first.
    """
    if known is not None:
        scene = scene.with_halvings(known.halvings)
    pair = _Pair(_History(scene, cracks, first, origin), cracks)
    for number in range(first, scene.case.n_loads):
        pair.number = number
        solution = pair.fine.at(number)
        if number == first and known is not None:
            yield replace(solution, accuracy=known)
        else:
            yield aimed(solution, Ways(pair.solve, pair.state_on_others), None)


@dataclass(slots=True, eq=False)
class _Pair:
    """A history on the cells of now and on those to compare."""

    fine: _History
    cracks: tuple[GrowingCrack, ...]
    other: _History | None = None
    number: int = 0  # of the load

    def solve(self, scene: Scene, like: Configuration) -> StepSolution:
        """The solution on other cells. Where there is none the next loads go on with the cells of now."""
        finer = _History(scene, self.cracks, like=like)
        solution = finer.at(self.number)
        self.fine = finer
        return solution

    def state_on_others(self, scene: Scene, _: float, like: Configuration) -> LoadState:
        """The state on the cells to compare."""
        if self.other is None or scene.halvings != self.other.scene.halvings:
            self.other = _History(scene, self.cracks, like=like)
        return self.other.at(self.number).state
