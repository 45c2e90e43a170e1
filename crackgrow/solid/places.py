"""Where the displacement unknowns of a cover are, for the order of elimination."""

from __future__ import annotations

import numpy as np

from crackgrow.cover.cover import Cover
from crackgrow.cover.tips import N_TIP_FUNCTIONS
from crackgrow.direct import Places


def places_of_unknowns(cover: Cover) -> Places:
    """Places of the displacement unknowns: the nodes of their patches; those of a crumb share the node next to it."""
    lattice = cover.lattice
    shape = (lattice.shape[0] + 1, lattice.shape[1] + 1)
    patch_nodes = cover.patch_nodes.copy()
    if cover.crumbs.n:
        patch_nodes[-3 * cover.crumbs.n :] = np.repeat(cover.crumbs.corners.mean(axis=1), 3, axis=0)
    of_patch = np.clip(np.rint(patch_nodes).astype(np.int64), 0, np.array(shape) - 1)
    nodes = np.empty((cover.n_functions, 2), dtype=np.int64)
    nodes[: len(of_patch)] = of_patch
    for first in cover.tip_function_ids:
        singular = first >= 0
        for k in range(N_TIP_FUNCTIONS):
            nodes[first[singular] + k] = of_patch[singular]
    return Places(np.repeat(nodes, 2, axis=0), shape, int(np.ceil(2.0 * lattice.support)) - 1)
