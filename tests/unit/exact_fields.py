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

PAPER = np.array([[1, 0, 0, 0], [0, 1, 0, 0], [1, 0, 0, 4], [0, -1, 4, 0]])
"""What sqrt(r) {cos t/2, sin t/2, cos 3t/2, sin 3t/2} are of the four tip functions in isotropic rock."""


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


def near_field(t: Floats, K_I: float, K_II: float) -> Floats:
    """sqrt(2 pi r) times the stress (n, 3) round the tip of a crack (Williams) at angles t (n,), in the tip's axes."""
    c, s, c3, s3 = np.cos(t / 2), np.sin(t / 2), np.cos(3 * t / 2), np.sin(3 * t / 2)
    first = np.stack([c * (1 - s * s3), c * (1 + s * s3), c * s * c3], axis=1)
    second = np.stack([-s * (2 + c * c3), s * c * c3, c * (1 - s * s3)], axis=1)
    return K_I * first + K_II * second


def turned(stress: Floats, angle: float) -> Floats:
    """Stress (n, 3) turned by an angle (rad), counter-clockwise."""
    c, s = np.cos(angle), np.sin(angle)
    R = np.array([[c, -s], [s, c]])
    tensors = R @ stress[:, [0, 2, 2, 1]].reshape(-1, 2, 2) @ R.T
    return np.stack([tensors[:, 0, 0], tensors[:, 1, 1], tensors[:, 0, 1]], axis=1)


def true_error(sample: Sample, u: Floats, field: Field) -> float:
    """Energy norm of the difference to the field, percent of the field's."""
    found = element_points(sample.cover, 4)
    exact = field(sample.lattice.to_metres(found.points))
    stress = stress_at(sample.cover, [sample.material], u, found.points, found.element)
    body = np.zeros(len(exact), dtype=np.int64)
    squares = [found.weights @ energy_components([sample.material], s, body) ** 2 for s in (stress - exact, exact)]
    return float(100.0 * np.sqrt(squares[0].sum() / squares[1].sum()))
