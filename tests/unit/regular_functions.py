"""Functions among cells of one size, node by node of the regular window."""

from __future__ import annotations

import numpy as np

from crackgrow.approximation.mls import mls
from crackgrow.cover.windows import regular_window


def regular_functions(local: np.ndarray, support: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Values (n, w) and gradients (n, w, 2) at places in a cell (n, 2), in its sides, and the nodes (w, 2)."""
    nodes = regular_window(support)
    distance = (nodes - local[:, None]).reshape(-1, 2).T
    half, start = np.full(distance.shape[1], support), len(nodes) * np.arange(len(local) + 1)
    found = mls(distance, half, start).reshape(3, len(local), len(nodes))
    alone = mls(distance, half, start, derivatives=False)[0]
    np.testing.assert_array_equal(alone, found[0].ravel())
    return found[0], found[1:].transpose(1, 2, 0), nodes
