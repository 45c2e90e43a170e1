"""The distance of two solutions of one scene in the energy norm: the error of the coarse one, if the other is finer."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from crackgrow.arrays import Floats
from crackgrow.case.units import place_text
from crackgrow.cover.elements import locate
from crackgrow.errors import GeometryError
from crackgrow.quadrature.elements import element_points
from crackgrow.run.judging import StepSolution
from crackgrow.solid.elasticity import energy_density
from crackgrow.solid.recovery import stress_at

AT_ONCE = 20000
"""Points whose stress is evaluated together, which bounds the memory."""


@dataclass(frozen=True, slots=True, eq=False)
class EnergyDistance:
    """The norm is the root of twice the strain energy: of the integral of stress . C^-1 stress."""

    absolute: float  # sqrt(J/m)
    relative: float  # percent of the norm of the finer solution; nan where that is free of stress


def energy_distance(coarse: StepSolution, fine: StepSolution) -> EnergyDistance:
    """Energy norm of the difference of the stresses of two solutions, by the quadrature of the finer one.

    Every point is located anew in the coarse cover, in the same body: each cover says on which side of its cracks it
    is. Raises GeometryError where a point of the finer body is not in the coarse one.
    """
    scene, cover = fine.configuration.scene, fine.cover
    found = element_points(cover, scene.case.numerics.quadrature + 1)
    difference = total = 0.0
    for first in range(0, len(found.points), AT_ONCE):
        some = slice(first, first + AT_ONCE)
        points, element = found.points[some], found.element[some]
        body = cover.elements.body[element]
        reference = stress_at(cover, fine.materials, fine.outcome.u, points, element)
        stress = _stress(coarse, cover.lattice.to_metres(points), body)
        area = found.weights[some] * cover.lattice.spacing**2
        difference += float(area @ energy_density(fine.materials, stress - reference, body))
        total += float(area @ energy_density(fine.materials, reference, body))
    relative = 100.0 * math.sqrt(difference / total) if total > 0.0 else math.nan
    return EnergyDistance(math.sqrt(difference), relative)


def _stress(solution: StepSolution, metres: Floats, body: NDArray[np.int64]) -> Floats:
    """Stress (n, 3) Pa at points (n, 2) m of bodies (n,)."""
    cover = solution.cover
    points = cover.lattice.to_lattice(metres)
    element = locate(cover.lattice, cover.elements, points, body)
    if element.min(initial=0) < 0:
        alone = place_text(metres[np.argmin(element)] + cover.lattice.map_origin)
        raise GeometryError(f"the two solutions have different bodies: {alone} is in one of them alone")
    return stress_at(cover, solution.materials, solution.outcome.u, points, element)
