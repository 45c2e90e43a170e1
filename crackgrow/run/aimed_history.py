"""Loads in turn, or stages, on cells that meet a target at each of them: the same history on several lattices."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, replace

from crackgrow.fracture.advance import GrowingCrack
from crackgrow.run.configuration import Configuration
from crackgrow.run.halvings import Accuracy
from crackgrow.run.increments import LoadState, Origin
from crackgrow.run.judging import StepSolution
from crackgrow.run.loading import LoadsInTurn
from crackgrow.run.scene import Scene
from crackgrow.run.target import aimed


def aimed_history(
    scene: Scene, cracks: tuple[GrowingCrack, ...], first: int, origin: Origin, known: Accuracy | None
) -> Iterator[StepSolution]:
    """The cracks at every factor of the case's history, or after every stage, on cells that meet the target there.

    From number `first` on. Where cells are halved all loads before are gone through again: contact remembers them, and
    rock is taken out on the cells that it was loaded on. `known` is what was measured at the first.
    """
    if known is not None:
        scene = scene.with_halvings(known.halvings)
    pair = _Pair(LoadsInTurn(scene, cracks, first, origin), cracks)
    for number in range(first, scene.case.n_loads):
        pair.number = number
        solution = pair.fine.solution(number)
        if number == first and known is not None:
            yield replace(solution, accuracy=known)
        else:
            yield aimed(solution, pair, None)


@dataclass(slots=True, eq=False)
class _Pair:
    """A history on the cells of now and on those to compare."""

    fine: LoadsInTurn
    cracks: tuple[GrowingCrack, ...]
    other: LoadsInTurn | None = None
    number: int = 0  # of the load

    def solve(self, scene: Scene, like: Configuration) -> StepSolution:
        """The solution on other cells. Where there is none the next loads go on with the cells of now."""
        finer = LoadsInTurn(scene, self.cracks, like=like)
        solution = finer.solution(self.number)
        self.fine = finer
        return solution

    def state(self, scene: Scene, _: float, like: Configuration) -> tuple[LoadState, Counter[str]]:
        """The state on the cells to compare, and the seconds that it has taken: no cover is made for the next load."""
        if self.other is None or scene.halvings != self.other.scene.halvings:
            self.other = LoadsInTurn(scene, self.cracks, like=like)
        state, _origin, (seconds, _n) = self.other.state(self.number)
        return state, seconds
