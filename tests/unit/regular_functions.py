"""Functions among cells of one size, node by node of the regular window."""

from __future__ import annotations

import math

import numpy as np

from crackgrow.approximation.mls import mls


def regular_window(support: float) -> np.ndarray:
    """Nodes ((2 reach)^2, 2) that can cover a cell, from its lower left corner, x by x."""
    reach = math.ceil(support)
    steps = np.arange(1 - reach, reach + 1, dtype=float)
    return np.stack(np.meshgrid(steps, steps, indexing="ij"), axis=-1).reshape(-1, 2)


def functions_of(nodes: np.ndarray, point: np.ndarray, support: float) -> np.ndarray:
    """Values and derivatives (3, k) at a point (2,) of the functions of nodes (k, 2), all of one half width."""
    k = len(nodes)
    found, alone, work, per_half = np.empty((3, k)), np.empty((1, k)), np.empty((5, k)), np.full(k, 1.0 / support)
    at = np.ascontiguousarray(nodes.T, dtype=float)
    mls(*point, at, per_half, k, True, found, work)
    mls(*point, at, per_half, k, False, alone, work)
    np.testing.assert_array_equal(alone[0], found[0])
    return found


def regular_functions(local: np.ndarray, support: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Values (n, w) and gradients (n, w, 2) at places in a cell (n, 2), in its sides, and the nodes (w, 2)."""
    nodes = regular_window(support)
    found = np.array([functions_of(nodes, point, support) for point in local])
    return found[:, 0], found[:, 1:].transpose(0, 2, 1), nodes
