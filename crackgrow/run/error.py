"""The error of a solved configuration, as it estimates itself."""

from __future__ import annotations

from crackgrow.fracture.singular_stress import SingularStress
from crackgrow.run.step import StepSolution
from crackgrow.solid.error_estimate import ErrorEstimate, error_estimate


def estimated_error(solution: StepSolution) -> ErrorEstimate:
    """The estimate in the energy norm, with the singular stress of all tips told apart by their K."""
    cover = solution.cover
    singular = [SingularStress(cover, number, tip.K) for number, tip in enumerate(solution.tips)]
    return error_estimate(cover, solution.materials, solution.outcome.u, singular)
