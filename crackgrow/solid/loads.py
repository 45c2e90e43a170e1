"""Loads: tractions on edges."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from crackgrow.approximation.basis import basis_at, value_matrix
from crackgrow.case.model import Body, EdgeTraction
from crackgrow.cover.cover import Cover
from crackgrow.solid.supports import edge_points

Floats = NDArray[np.float64]


def load_vector(cover: Cover, bodies: tuple[Body, ...], loads: tuple[EdgeTraction, ...]) -> Floats:
    """Load vector f (n_dofs,) in N per metre of thickness: integral of phi t along the loaded edges, paper eq. (15)."""
    f = np.zeros((cover.n_functions, 2))
    for load in loads:
        points, length, elements, _ = edge_points(cover, bodies, load.region)
        values = value_matrix(basis_at(cover, points, elements), cover.n_functions)
        f += np.outer(values.T @ length, load.traction)
    return f.ravel()
