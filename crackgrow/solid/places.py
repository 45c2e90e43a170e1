"""Where the displacement unknowns of a cover are, for the order of elimination."""

from __future__ import annotations

import numpy as np

from crackgrow.arrays import Ints
from crackgrow.cover.cover import Cover
from crackgrow.cover.squares import QUANTA
from crackgrow.cover.tips import N_TIP_FUNCTIONS, Tip
from crackgrow.direct import Places

FINEST = 1 << 17
"""Units along the lattice, if there need not be more."""


def places_of_unknowns(cover: Cover) -> Places:
    """Boxes of the displacement unknowns: those of their patches; those of a crumb share the node next to it."""
    lattice, first = cover.lattice, cover.patches.n_of_lattice
    nodes = np.rint(QUANTA * cover.patches.nodes).astype(np.int64)
    half = np.rint(QUANTA * cover.patches.half).astype(np.int64)
    middles = QUANTA * cover.patches.nodes[first:].reshape(-1, 3, 2).mean(axis=1)
    for crumb, middle in enumerate(middles):
        near = np.argmin(np.abs(lattice.nodes.places - middle).max(axis=1))
        mine = slice(first + 3 * crumb, first + 3 * crumb + 3)
        nodes[mine], half[mine] = lattice.nodes.places[near], lattice.nodes.half[near]
    cell, widest = int(lattice.cells.size.min()), int(lattice.nodes.half.max())
    unit = _unit(int(np.gcd.reduce(np.concatenate([nodes.ravel(), half, [cell, widest]]))), lattice.shape)
    middle, reach = nodes // unit, (half // unit)[:, None]
    last = (QUANTA * np.array(lattice.shape) + widest) // unit
    boxes = [(middle - reach, middle + reach), *(_of_tip(tip, middle, reach) for tip in cover.tips)]
    low, high = (np.repeat(np.concatenate(corners), 2, axis=0) for corners in zip(*boxes, strict=True))
    return Places(low, high, np.full(2, -widest // unit), last, cell // unit, bool(cell == lattice.cells.size.max()))


def _unit(common: int, shape: tuple[int, int]) -> int:
    """The unit of places, in quanta: the same whatever the smallest cells are, where `common` is a multiple of it.

    Factors are known by the places of their unknowns: in other units all of them would be found anew.
    """
    unit = 1
    while unit < common and QUANTA * max(shape) >= FINEST * unit:
        unit *= 2
    return unit if common % unit == 0 else common


def _of_tip(tip: Tip, middle: Ints, reach: Ints) -> tuple[Ints, Ints]:
    """Lower left and upper right corners (n, 2) of the functions of a tip, whose patches have `middle` and `reach`.

    No box of several patches has the middle of one patch: boxes are known by their middles.
    """
    begin = np.searchsorted(tip.carriers.number, np.arange(tip.carriers.n))
    middle, reach = middle[tip.patches], reach[tip.patches]
    low, high = np.minimum.reduceat(middle - reach, begin), np.maximum.reduceat(middle + reach, begin)
    several = np.diff(begin, append=len(tip.patches)) > 1
    high[:, 0] += several & ((low + high)[:, 0] % 2 == 0)
    return np.repeat(low, N_TIP_FUNCTIONS, axis=0), np.repeat(high, N_TIP_FUNCTIONS, axis=0)
