"""Where the displacement unknowns of a cover are, for the order of elimination."""

from __future__ import annotations

import numpy as np

from crackgrow.cover.cover import Cover
from crackgrow.cover.tips import N_TIP_FUNCTIONS
from crackgrow.direct import Places

QUARTERS = 4
"""Supports are whole numbers of quarters of a spacing: the unit of places."""


def places_of_unknowns(cover: Cover) -> Places:
    """Boxes of the displacement unknowns: those of their patches; those of a crumb share the node next to it."""
    lattice = cover.lattice
    patch_nodes = cover.patch_nodes.copy()
    if cover.crumbs.n:
        patch_nodes[-3 * cover.crumbs.n :] = np.repeat(cover.crumbs.corners.mean(axis=1), 3, axis=0)
    of_patch = np.clip(np.rint(patch_nodes).astype(np.int64), 0, np.array(lattice.shape))
    nodes = np.empty((cover.n_functions, 2), dtype=np.int64)
    nodes[: len(of_patch)] = of_patch
    for first in cover.tip_function_ids:
        singular = first >= 0
        for k in range(N_TIP_FUNCTIONS):
            nodes[first[singular] + k] = of_patch[singular]
    middle, half = np.repeat(QUARTERS * nodes, 2, axis=0), round(QUARTERS * lattice.support)
    last = QUARTERS * np.array(lattice.shape)
    return Places(middle - half, middle + half, np.array([-half, -half]), last + half, QUARTERS)
