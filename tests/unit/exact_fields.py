"""Bodies solved under the tractions of a known stress, and how far their stress is from it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from crackgrow.approximation.basis import values_at
from crackgrow.case.model import PointSupport
from crackgrow.quadrature.elements import element_points
from crackgrow.quadrature.rims import points_on_outlines
from crackgrow.solid.elasticity import energy_components
from crackgrow.solid.recovery import stress_at
from tests.conftest import Sample

Floats = NDArray[np.float64]
Field = Callable[[Floats], Floats]
"""Stress (n, 3): xx, yy, xy at points (n, 2) in metres."""


def solved_under(sample: Sample, field: Field) -> Floats:
    """Displacement unknowns under the tractions of a field on the outline, which balance each other."""
    cover, outlines = sample.cover, sample.cover.elements.outlines
    edge, points, length = points_on_outlines(cover, outlines.points, outlines.element, outlines.edge)
    step = outlines.points[:, 1] - outlines.points[:, 0]
    outward = (np.stack([step[:, 1], -step[:, 0]], axis=1) / np.hypot(*step.T)[:, None])[edge]
    xx, yy, xy = field(sample.lattice.to_metres(points)).T
    traction = np.stack([xx * outward[:, 0] + xy * outward[:, 1], xy * outward[:, 0] + yy * outward[:, 1]], axis=1)
    values = values_at(cover, points, outlines.element[edge]).rows
    loads = values.T @ (length[:, None] * sample.lattice.spacing * traction)
    corners = sample.body.outline
    held = (PointSupport("rock", corners[0], (0.0, 0.0)), PointSupport("rock", corners[1], (None, 0.0)))
    system, given = sample.system(held)
    return system.solve(loads.ravel(), given)[0]


def true_error(sample: Sample, u: Floats, field: Field) -> float:
    """Energy norm of the difference to the field, percent of the field's."""
    found = element_points(sample.cover, 4)
    exact = field(sample.lattice.to_metres(found.points))
    stress = stress_at(sample.cover, [sample.material], u, found.points, found.element)
    body = np.zeros(len(exact), dtype=np.int64)
    squares = [found.weights @ energy_components([sample.material], s, body) ** 2 for s in (stress - exact, exact)]
    return float(100.0 * np.sqrt(squares[0].sum() / squares[1].sum()))
