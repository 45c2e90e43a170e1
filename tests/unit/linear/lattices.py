"""Random matrices of functions at the nodes of a lattice, for tests of the direct solver."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

REACH = 2


def boxes_at(nodes: Ints, reach: int = REACH) -> tuple[Ints, Ints]:
    """Boxes round nodes (n, 2), which overlap where nodes are at most `reach` apart along both axes."""
    return 2 * nodes - reach, 2 * nodes + reach + 1


def lattice(n: int, seed: int, reach: int = REACH) -> tuple[csc_array, Ints]:
    """A random positive definite matrix of two unknowns per node of an n x n lattice, and its nodes (n n, 2)."""
    rng = np.random.default_rng(seed)
    nodes = np.stack(np.meshgrid(np.arange(n), np.arange(n), indexing="ij"), axis=2).reshape(-1, 2)
    places = np.repeat(nodes, 2, axis=0)
    near = np.abs(places[:, None] - places).max(axis=2) <= reach
    dense = np.where(np.triu(near, 1), rng.uniform(-1.0, 1.0, near.shape), 0.0)
    dense += dense.T
    np.fill_diagonal(dense, np.abs(dense).sum(axis=1) + rng.uniform(0.01, 1.0, len(dense)))
    scale = 10.0 ** rng.uniform(-2.0, 2.0, len(dense))
    return csc_array(dense * np.outer(scale, scale)), nodes


def net(n: int, seed: int, ground: float = 0.0) -> tuple[csc_array, Ints]:
    """Springs between the unknowns of such a lattice, tied to the ground by a part of their stiffness."""
    matrix, nodes = lattice(n, seed)
    springs = csc_array(-abs(matrix))
    springs.setdiag(0.0)
    springs.setdiag(-springs.sum(axis=1) * (1.0 + ground))
    return springs, nodes
