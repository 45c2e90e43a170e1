"""Displacement and stress at points."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from crackgrow.approximation.basis import fields_at
from crackgrow.arrays import Floats, Ints
from crackgrow.cover.cover import Cover
from crackgrow.solid.elasticity import PlaneElasticity


def displacement_at(cover: Cover, u: Floats, points: Floats, elements: Ints) -> Floats:
    """Displacement (n, 2) m at points (n, 2), in lattice coordinates, of given elements (n,); `u` (n_dofs,)."""
    return np.asarray(fields_at(cover, points, elements, u, derivatives=False)[0])


def stress_at(cover: Cover, materials: Sequence[PlaneElasticity], u: Floats, points: Floats, elements: Ints) -> Floats:
    """Stress (n, 3) Pa: xx, yy, xy at points (n, 2), in lattice coordinates, of given elements (n,); `u` (n_dofs,)."""
    gradient = fields_at(cover, points, elements, u)[1:].transpose(1, 2, 0)
    return stress_of(materials, gradient, cover.elements.body[elements], cover.lattice.to_metres(points))


def stress_of(materials: Sequence[PlaneElasticity], gradient: Floats, body: Ints, places: Floats) -> Floats:
    """Stress (n, 3) Pa: xx, yy, xy for displacement gradients (n, 2, 2) in bodies (n,) at places (n, 2) m.

    In-situ stress is included.
    """
    strain = np.stack([gradient[:, 0, 0], gradient[:, 1, 1], gradient[:, 0, 1] + gradient[:, 1, 0]], axis=1)
    matrices = np.stack([material.matrix for material in materials])[body]
    stress = np.einsum("nij,nj->ni", matrices, strain) + np.array([m.initial.uniform for m in materials])[body]
    for number, material in enumerate(materials):
        if material.initial.varying:
            mine = body == number
            stress[mine] += material.initial.more_at(places[mine])
    return np.asarray(stress)
