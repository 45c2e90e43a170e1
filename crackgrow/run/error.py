"""The error of a solved configuration, as it estimates itself."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from crackgrow.cover.cover import Cover
from crackgrow.estimate.error_estimate import ErrorEstimate, error_estimate
from crackgrow.fracture.singular_stress import SingularStress
from crackgrow.run.judging import StepSolution
from crackgrow.solid.elasticity import PlaneElasticity


def estimated_error(solution: StepSolution) -> ErrorEstimate:
    """The estimate in the energy norm."""
    return estimate_with(solution.cover, solution.materials, solution.outcome.u, [tip.K for tip in solution.tips])


def estimate_with(
    cover: Cover,
    materials: Sequence[PlaneElasticity],
    u: NDArray[np.float64],
    K: Sequence[tuple[float, float]],
) -> ErrorEstimate:
    """The estimate for displacements `u` (n_dofs,) m, with the singular stress of all tips told apart by their K."""
    singular = [SingularStress(cover, tip, K_of_tip) for tip, K_of_tip in enumerate(K)]
    return error_estimate(cover, materials, u, singular)
