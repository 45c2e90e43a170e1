"""The error of a run in the energy norm: its solution held against that of the reference, solved once."""

from __future__ import annotations

from crackgrow.case import Case
from crackgrow.fracture.advance import GrowingCrack
from crackgrow.run.judging import StepSolution
from crackgrow.run.loading import load
from crackgrow.run.scene import make_scene
from crackgrow.study.energy_distance import energy_distance


class EnergyReference:
    """The solution that others are held against; it is solved when it is first asked for.

    Steps are those that `measures` judges: before growth, or under the last load factor.
    """

    def __init__(self, case: Case) -> None:
        self._case = case
        self._solution: StepSolution | None = None

    @property
    def spacing(self) -> float:
        """The lattice spacing of the reference, m."""
        return self._case.numerics.spacing

    def error(self, case: Case) -> float:
        """Energy norm of the difference to the reference, over that of the reference.

        Raises GeometryError or SolveError where the case can't be solved or lies elsewhere.
        """
        self._solution = self._solution or _solved(self._case)
        return energy_distance(_solved(case), self._solution).relative / 100.0


def _solved(case: Case) -> StepSolution:
    """The cracks as they are given, under the last load."""
    cracks = tuple(map(GrowingCrack.given, case.cracks))
    return load(make_scene(case), cracks)
