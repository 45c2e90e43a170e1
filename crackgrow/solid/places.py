"""Where the functions of a cover are, for the order of elimination."""

from __future__ import annotations

import numpy as np

from crackgrow.arrays import Ints
from crackgrow.cover.cover import Cover
from crackgrow.cover.squares import QUANTA
from crackgrow.cover.tips import N_TIP_FUNCTIONS, Tip


def boxes_of_functions(cover: Cover) -> tuple[Ints, Ints]:
    """Lower left and upper right corners (n_functions, 2) of the supports: those of patches, or of those of a tip.

    Functions of a crumb share the node next to it.
    """
    lattice, first = cover.lattice, cover.patches.n_of_lattice
    nodes = np.rint(QUANTA * cover.patches.nodes).astype(np.int64)
    half = np.rint(QUANTA * cover.patches.half).astype(np.int64)[:, None]
    for crumb, middle in enumerate(QUANTA * cover.patches.nodes[first:].reshape(-1, 3, 2).mean(axis=1)):
        near = np.argmin(np.abs(lattice.nodes.places - middle).max(axis=1))
        mine = slice(first + 3 * crumb, first + 3 * crumb + 3)
        nodes[mine], half[mine] = lattice.nodes.places[near], lattice.nodes.half[near]
    boxes = [(nodes - half, nodes + half), *(_of_tip(tip, nodes, half) for tip in cover.tips)]
    low, high = (np.concatenate(corners) for corners in zip(*boxes, strict=True))
    return low, high


def _of_tip(tip: Tip, nodes: Ints, half: Ints) -> tuple[Ints, Ints]:
    """Corners (n, 2) of the functions of a tip, whose patches have `nodes` (patches, 2) and `half` (patches, 1)."""
    begin = np.searchsorted(tip.carriers.number, np.arange(tip.carriers.n))
    low = np.minimum.reduceat((nodes - half)[tip.patches], begin)
    high = np.maximum.reduceat((nodes + half)[tip.patches], begin)
    return np.repeat(low, N_TIP_FUNCTIONS, axis=0), np.repeat(high, N_TIP_FUNCTIONS, axis=0)
