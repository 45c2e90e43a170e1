"""Where the displacement unknowns of a cover are, for the order of elimination."""

from __future__ import annotations

import numpy as np

from crackgrow.cover.cover import Cover
from crackgrow.cover.tips import N_TIP_FUNCTIONS
from crackgrow.direct.dissection import Places


def places_of_unknowns(cover: Cover) -> Places:
    """Places of the displacement unknowns: the nodes of their patches; those of a crumb share the node next to it."""
    lattice = cover.lattice
    shape = (lattice.shape[0] + 1, lattice.shape[1] + 1)
    patch_nodes, first = cover.patch_nodes.copy(), cover.patches.n_of_lattice
    patch_nodes[first:] = np.repeat(patch_nodes[first:].reshape(-1, 3, 2).mean(axis=1), 3, axis=0)
    of_patch = np.clip(np.rint(patch_nodes).astype(np.int64), 0, np.array(shape) - 1)
    of_tips = [np.repeat(of_patch[tip.patches], N_TIP_FUNCTIONS, axis=0) for tip in cover.tips]
    nodes = np.concatenate([of_patch, *of_tips])
    return Places(np.repeat(nodes, 2, axis=0), shape, int(np.ceil(2.0 * lattice.support)) - 1)
