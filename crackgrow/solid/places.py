"""Where the functions of a cover are, for the order of elimination."""

from __future__ import annotations

import numpy as np

from crackgrow.arrays import Ints
from crackgrow.compiled import kernel
from crackgrow.cover.cover import Cover
from crackgrow.cover.squares import QUANTA


def boxes_of_functions(cover: Cover) -> tuple[Ints, Ints]:
    """Lower left and upper right corners (n_functions, 2) of what functions are on, in quanta: of all their elements.

    A function beside a crack has its box on its own side of it.
    """
    rings, functions = cover.elements.rings, cover.functions
    first = np.searchsorted(rings.face, np.arange(cover.elements.n))
    corners = QUANTA * cover.elements.vertices[rings.start]
    low = np.floor(np.minimum.reduceat(corners, first)).astype(np.int64)  # outwards: elements may be thin
    high = np.ceil(np.maximum.reduceat(corners, first)).astype(np.int64)
    least, most = _boxes(low, high, functions.start, functions.values, cover.n_dofs // 2)
    return least, most


@kernel
def _boxes(low: Ints, high: Ints, start: Ints, function: Ints, n: int) -> tuple[Ints, Ints]:
    """Boxes (n, 2) round those of the elements of each function; these are listed by element, from `start` on."""
    least, most = np.full((n, 2), np.iinfo(np.int64).max), np.full((n, 2), np.iinfo(np.int64).min)
    for e in range(len(low)):
        for i in function[start[e] : start[e + 1]]:
            for axis in range(2):
                least[i, axis] = min(least[i, axis], low[e, axis])
                most[i, axis] = max(most[i, axis], high[e, axis])
    return least, most
