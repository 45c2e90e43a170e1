"""Displacement and stress at points."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from crackgrow.approximation.basis import Basis, basis_at, values_at
from crackgrow.cover.cover import Cover
from crackgrow.solid.elasticity import PlaneElasticity

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


def displacement_at(cover: Cover, u: Floats, points: Floats, elements: Ints) -> Floats:
    """Displacement (n, 2) m at points (n, 2), in lattice coordinates, of given elements (n,); `u` (n_dofs,)."""
    basis = values_at(cover, points, elements)
    values = basis.values.T
    return np.stack([np.sum(values * c, axis=0) for c in _coefficients(u, basis.ids)], axis=1)


def gradient_at(cover: Cover, u: Floats, points: Floats, elements: Ints) -> Floats:
    """Displacement gradient du_c/dx_d (n, 2, 2) [point, c, d] at points (n, 2), in lattice coordinates."""
    return gradient_of(basis_at(cover, points, elements), u)


def gradient_of(basis: Basis, u: Floats) -> Floats:
    """Displacement gradient (n, 2, 2) [point, c, d] at the points of a basis; `u` (n_dofs,) m."""
    by_x, by_y = basis.gradients.transpose(2, 1, 0)
    rows = [np.stack([np.sum(by_x * c, axis=0), np.sum(by_y * c, axis=0)]) for c in _coefficients(u, basis.ids)]
    return np.stack(rows).transpose(2, 0, 1)


def _coefficients(u: Floats, ids: Ints) -> Iterator[Floats]:
    """The coefficients (k, n) of functions `ids` (n, k), component by component; the points last, as in a basis."""
    for component in u.reshape(-1, 2).T:
        yield np.append(component, 0.0).take(ids.T)  # the last entry serves the index -1


def stress_at(cover: Cover, materials: Sequence[PlaneElasticity], u: Floats, points: Floats, elements: Ints) -> Floats:
    """Stress (n, 3) Pa: xx, yy, xy at points (n, 2), in lattice coordinates, of given elements (n,); `u` (n_dofs,)."""
    gradient = gradient_at(cover, u, points, elements)
    return stress_of(materials, gradient, cover.elements.body[elements])


def stress_of(materials: Sequence[PlaneElasticity], gradient: Floats, body: Ints) -> Floats:
    """Stress (n, 3) Pa: xx, yy, xy for displacement gradients (n, 2, 2) in bodies (n,), in-situ stress included."""
    strain = np.stack([gradient[:, 0, 0], gradient[:, 1, 1], gradient[:, 0, 1] + gradient[:, 1, 0]], axis=1)
    matrices = np.stack([material.matrix for material in materials])[body]
    initial = np.array([material.initial for material in materials])[body]
    return np.asarray(np.einsum("nij,nj->ni", matrices, strain) + initial)


def principal(stress: Floats) -> tuple[Floats, Floats, Floats]:
    """Principal stresses s1 >= s3 (n,) Pa and the angle (n,) rad of s1's axis from +x, for stresses (n, 3)."""
    xx, yy, xy = stress.T
    centre, half = 0.5 * (xx + yy), 0.5 * (xx - yy)
    radius = np.hypot(half, xy)
    return centre + radius, centre - radius, 0.5 * np.arctan2(xy, half)
