"""Quadrature points along straight edges."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from crackgrow.arrays import Floats
from crackgrow.quadrature.rules import gauss


def on_edges(n_edges: int, n: int) -> tuple[Floats, Floats]:
    """Gauss points on `n_edges` edges, by their position in [0, 1] (n_edges, n), and weights that sum to 1."""
    x, w = gauss(n)
    return np.tile(x, (n_edges, 1)), np.tile(w, (n_edges, 1))


def on_edges_with_tips(at_start: NDArray[np.bool_], at_end: NDArray[np.bool_], n: int) -> tuple[Floats, Floats]:
    """As `on_edges`, for functions of sqrt(distance) from the end that is a tip: exact for half powers to 2 n - 1.

    An edge with a tip at both ends uses x = sin^2(pi y / 2).
    """
    x, w = gauss(n)
    position = np.tile(x, (len(at_start), 1))
    weights = np.tile(w, (len(at_start), 1))
    only_start, only_end, both = at_start & ~at_end, at_end & ~at_start, at_start & at_end
    position[only_start], weights[only_start] = x**2, 2.0 * x * w
    position[only_end], weights[only_end] = 1.0 - x**2, 2.0 * x * w
    position[both], weights[both] = np.sin(0.5 * np.pi * x) ** 2, 0.5 * np.pi * np.sin(np.pi * x) * w
    return position, weights
