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
    patch_nodes, first = cover.patch_nodes.copy(), cover.patches.n_of_lattice
    patch_nodes[first:] = np.repeat(patch_nodes[first:].reshape(-1, 3, 2).mean(axis=1), 3, axis=0)
    of_patch = np.clip(np.rint(patch_nodes).astype(np.int64), 0, np.array(lattice.shape))
    of_tips = [np.repeat(of_patch[tip.patches], N_TIP_FUNCTIONS, axis=0) for tip in cover.tips]
    nodes = np.concatenate([of_patch, *of_tips])
    middle, half = np.repeat(QUARTERS * nodes, 2, axis=0), round(QUARTERS * lattice.support)
    last = QUARTERS * np.array(lattice.shape)
    return Places(middle - half, middle + half, np.array([-half, -half]), last + half, QUARTERS)
