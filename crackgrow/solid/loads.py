"""Loads on bodies: tractions on edges, weight, in-situ stress. Those on crack faces are in `contact.face_loads`."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from crackgrow.approximation.basis import basis_at, value_matrix
from crackgrow.approximation.mls import mls
from crackgrow.case.model import Body, EdgeTraction, Gravity, InSituStress, Load
from crackgrow.cover.cover import Cover
from crackgrow.quadrature.elements import element_points, plain_elements
from crackgrow.quadrature.lines import on_edges
from crackgrow.quadrature.rules import square
from crackgrow.solid.supports import POINTS_PER_EDGE, body_index, edge_points

Floats = NDArray[np.float64]


def load_vector(cover: Cover, bodies: Sequence[Body], loads: Sequence[Load], n: int) -> Floats:
    """Load vector f (n_dofs,) in N per metre of thickness, paper eq. (15), of all loads but those on crack faces.

    `n` Gauss points per direction, as for the stiffness.
    """
    f = np.zeros((cover.n_functions, 2))
    for load in loads:
        if isinstance(load, EdgeTraction):
            points, length, elements, _ = edge_points(cover, bodies, load.region)
            values = value_matrix(basis_at(cover, points, elements), cover.n_functions)
            f += np.outer(values.T @ length, load.traction)
        elif isinstance(load, Gravity):
            body = body_index(bodies, load.body)
            density = bodies[body].material.density
            assert density is not None  # the case was checked
            f += np.outer(_volume_of_functions(cover, body, n), density * np.asarray(load.acceleration))
        elif isinstance(load, InSituStress):
            f -= _rim_tractions(cover, body_index(bodies, load.body), np.asarray(load.stress))
    return f.ravel()


def _rim_tractions(cover: Cover, body: int, stress: Floats) -> Floats:
    """Integral of phi sigma n (n_functions, 2) N/m along the rim of a body, for a uniform stress (3,): xx, yy, xy.

    By the divergence theorem this, with the crack faces' part, is the integral of B' sigma. On the rim it cancels
    tractions that balance the stress exactly.
    """
    outlines = cover.elements.outlines
    mine = np.flatnonzero(outlines.body == body)
    start, step = outlines.points[mine, 0], np.diff(outlines.points[mine], axis=1)[:, 0]
    position, weights = on_edges(len(mine), POINTS_PER_EDGE)
    points = (start[:, None] + position[:, :, None] * step[:, None]).reshape(-1, 2)
    elements = np.repeat(outlines.element[mine], POINTS_PER_EDGE)
    values = value_matrix(basis_at(cover, points, elements), cover.n_functions)
    area = step[:, None] * weights[:, :, None] * cover.lattice.spacing  # tangent times length
    normal = np.stack([area[..., 1], -area[..., 0]], axis=-1).reshape(-1, 2)  # outward: the body is on the left
    xx, yy, xy = stress
    return np.asarray(values.T @ (normal @ np.array([[xx, xy], [xy, yy]])))


def _volume_of_functions(cover: Cover, body: int, n: int) -> Floats:
    """Integral of every function (n_functions,) m^2 over a body."""
    lattice, elements = cover.lattice, cover.elements
    total = np.zeros(cover.n_functions)
    local, weights = square(n)
    per_cell = len(lattice.breaks) - 1
    sizes = np.diff(lattice.breaks)
    plain = np.flatnonzero(plain_elements(cover) & (elements.body == body))
    part = elements.tile[plain] % per_cell
    for i, j in np.unique(part, axis=0):
        phi, _ = mls(lattice.breaks[[i, j]] + local * sizes[[i, j]], lattice.support, lattice.reach)
        share = weights @ phi * sizes[i] * sizes[j]
        ids = cover.functions[plain[np.all(part == (i, j), axis=1)]]
        used = ids >= 0
        np.add.at(total, ids[used], np.broadcast_to(share, ids.shape)[used])
    points = element_points(cover, n)
    mine = elements.body[points.element] == body
    basis = basis_at(cover, points.points[mine], points.element[mine])
    total += value_matrix(basis, cover.n_functions).T @ points.weights[mine]
    return total * lattice.spacing**2
