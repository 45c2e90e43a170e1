"""Cells for a target of the error of K, or of another goal: halved where it is off by more, until the bound meets it.

A step begins with the cells of the one before. What is known of its error holds for a while (`run.still_known`): then
it is measured anew (`run.aim`), and cells are halved where that asks for it, and joined where the error is far below
the target (`run.next_cells`). Where a name has chosen the cells they stay: their error is measured alone.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field, replace

from crackgrow.cover.refinement import MOST_LEVELS
from crackgrow.errors import GeometryError, NotSolvedError, SolveError
from crackgrow.run.aim import Aim, Ways, aim_of
from crackgrow.run.configuration import Configuration
from crackgrow.run.halvings import Accuracy, Halvings
from crackgrow.run.increments import LoadState
from crackgrow.run.judging import StepSolution
from crackgrow.run.layout import cover_of
from crackgrow.run.scene import Scene
from crackgrow.run.still_known import Since, lengths_grown

MOST_ROUNDS = 4
"""Times that cells are halved for one step."""

MOST_UNKNOWNS = 150_000
"""Cells are not halved where that may give more."""


def aimed(solution: StepSolution, ways: Ways, last: Accuracy | None) -> StepSolution:
    """The step with what is known of its error, on cells that meet a target, or come as near to it as they can.

    `last` is what was known of the step before.
    """
    grown, aim = lengths_grown(solution), aim_of(solution.scene)
    if not aim.is_there(solution):
        known = aim.accuracy(solution, None)
        return replace(solution, accuracy=replace(known, grown=grown, missed=aim.why_not(solution, grown)))
    if last is not None:
        since = Since(last, solution, grown)
        if since.holds:
            return replace(solution, accuracy=since.carried_over)
    return _in_rounds(solution, ways, _Comparison(aim, ways, last, grown))


def _in_rounds(solution: StepSolution, ways: Ways, comparison: _Comparison) -> StepSolution:
    """The step on cells that are halved round by round until it meets the target, or none can be had."""
    n_solves, seconds, before, aim = solution.factorizations, Counter(solution.seconds), None, comparison.aim
    for round_ in range(MOST_ROUNDS + 1):
        known, missed = comparison.known_of(solution), ""
        if _met(aim, known, solution):
            break
        wanted, missed = aim.next_cells(solution, known, before)
        if wanted is not None and solution.cover.sizes.min() <= 0.5**MOST_LEVELS:
            wanted, missed = None, f"cells are halved {MOST_LEVELS} times already, which is the most"
        if wanted is None or round_ == MOST_ROUNDS:
            missed = missed or f"cells were divided in {MOST_ROUNDS} rounds for it"
            break
        before = known
        try:
            solution = _solved(ways, solution.scene.with_halvings(wanted), solution.configuration)
        except (GeometryError, SolveError) as error:
            missed = f"smaller cells are not to be had: {error}"
            break
        n_solves += solution.factorizations
        seconds.update(solution.seconds)
    seconds.update(comparison.seconds)
    return replace(
        solution,
        accuracy=replace(known, missed=missed),
        factorizations=n_solves + comparison.n_solves,
        seconds=dict(seconds),
    )


@dataclass(slots=True, eq=False)
class _Comparison:
    """What a step is held against on one round's cells after the other's.

    A state on cells to compare is used again while it tells of the error, and tells that the target is met.
    """

    aim: Aim
    ways: Ways
    last: Accuracy | None  # what was known before
    grown: tuple[float, ...]  # m, crack by crack
    other: LoadState | None = None
    n_solves: int = 0
    seconds: Counter[str] = field(default_factory=Counter)

    def known_of(self, solution: StepSolution) -> Accuracy:
        """What is known of the error of a solution; it is held against other cells where it has to be."""
        if self.other is not None and self.aim.still_tells(solution, self.other):
            self.last = self._told(solution)
            if _met(self.aim, self.last, solution):
                return self.last
        self.other = self._solved(solution)
        self.last = self._told(solution)
        return self.last

    def _told(self, solution: StepSolution) -> Accuracy:
        """What the state on the other cells tells."""
        return replace(self.aim.accuracy(solution, self.other), grown=self.grown)

    def _solved(self, solution: StepSolution) -> LoadState | None:
        """The state on the cells to compare, None where there is none."""
        last = self.last
        like = solution.configuration if last is None or last.compared is None else last.compared
        try:
            state, seconds = self.aim.other(solution, self.ways, like)
        except (GeometryError, SolveError):
            return None
        self.n_solves += 1
        self.seconds.update(seconds)
        return state


def _met(aim: Aim, known: Accuracy, solution: StepSolution) -> bool:
    """Whether the bound is within the target, if there is one."""
    target = solution.scene.case.numerics.target
    return target is None or aim.off(known) <= target


def _solved(ways: Ways, scene: Scene, before: Configuration) -> StepSolution:
    """The solution on the cells of a scene. Raises GeometryError or SolveError where there is none, or it is large.

    So it does where the cells are those `before`.
    """
    cover = cover_of(scene, before.cracks)
    n_dofs = cover.n_dofs
    if cover.lattice.cells.equal(before.cover.lattice.cells):
        raise NotSolvedError(f"they are halved {MOST_LEVELS} times already, which is the most")
    if n_dofs > MOST_UNKNOWNS:
        raise NotSolvedError(f"they make {n_dofs:,} unknowns, and at most {MOST_UNKNOWNS:,} are taken")
    return ways.solve(scene, before)


def cells_after(solution: StepSolution) -> Halvings:
    """The cells that the step after a solution begins with."""
    scene = solution.scene
    return scene.halvings if scene.case.numerics.target is None else aim_of(scene).cells_after(solution)
