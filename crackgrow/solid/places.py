"""Where the displacement unknowns of a cover are, for the order of elimination."""

from __future__ import annotations

import numpy as np

from crackgrow.cover.cover import Cover
from crackgrow.cover.squares import QUANTA
from crackgrow.cover.tips import N_TIP_FUNCTIONS
from crackgrow.direct import Places


def places_of_unknowns(cover: Cover) -> Places:
    """Boxes of the displacement unknowns: those of their patches; those of a crumb share the node next to it."""
    lattice, first = cover.lattice, cover.patches.n_of_lattice
    nodes = np.rint(QUANTA * cover.patch_nodes).astype(np.int64)
    half = np.rint(QUANTA * cover.patches.half).astype(np.int64)
    middles = QUANTA * cover.patch_nodes[first:].reshape(-1, 3, 2).mean(axis=1)
    for crumb, middle in enumerate(middles):
        near = np.argmin(np.abs(lattice.nodes.places - middle).max(axis=1))
        mine = slice(first + 3 * crumb, first + 3 * crumb + 3)
        nodes[mine], half[mine] = lattice.nodes.places[near], lattice.nodes.half[near]
    patch = np.concatenate([np.arange(len(half)), *(np.repeat(t.patches, N_TIP_FUNCTIONS) for t in cover.tips)])
    cell, widest = int(lattice.cells.size.min()), int(lattice.nodes.half.max())
    unit = int(np.gcd.reduce(np.concatenate([nodes.ravel(), half, [cell, widest]])))
    middle, reach = np.repeat(nodes[patch] // unit, 2, axis=0), np.repeat(half[patch] // unit, 2)[:, None]
    last = (QUANTA * np.array(lattice.shape) + widest) // unit
    return Places(middle - reach, middle + reach, np.full(2, -widest // unit), last, cell // unit)
