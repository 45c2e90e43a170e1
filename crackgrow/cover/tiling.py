"""The tiles as a mesh: their corners, from left to right and upwards, and their rings.

The corners of smaller neighbours divide the sides of a tile.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from crackgrow.arrays import Floats, Ints
from crackgrow.cover.squares import QUANTA, Squares
from crackgrow.geometry.arrangement import as_numbers
from crackgrow.ragged import Ragged, by_row


@dataclass(frozen=True, slots=True, eq=False)
class Tiling:
    """The mesh of n tiles."""

    corners: NDArray[np.complex128]  # (v,) ascending, spacings
    ring: Ragged  # tiles -> corners on their rims, counter-clockwise from the lower left
    following: Ints  # (places of `ring`,) the next corner

    @property
    def points(self) -> Floats:
        """The corners (v, 2)."""
        return np.stack([self.corners.real, self.corners.imag], axis=1)


def tiling_of(tiles: Squares) -> Tiling:
    """The mesh of tiles."""
    corners = tiles.corners
    around = np.sort(tiles.around(corners / QUANTA), axis=1)
    around[:, 1:][around[:, 1:] == around[:, :-1]] = -1
    corner, column = np.nonzero(around >= 0)
    tile = around[corner, column]
    along = _along_rim(corners[corner] - tiles.low[tile], tiles.size[tile])
    order = np.lexsort((along, tile))
    ring = by_row(tile[order], corner[order], tiles.n)
    following = np.roll(ring.values, -1)
    following[ring.start[1:] - 1] = ring.values[ring.start[:-1]]
    return Tiling(as_numbers(corners / QUANTA), ring, following)


def _along_rim(off: Ints, size: Ints) -> Ints:
    """How far (n,) round squares of `size` (n,) points on their rims are, from the lower left corner; `off` (n, 2)."""
    x, y = off.T
    return np.select([y == 0, x == size, y == size], [x, size + y, 3 * size - x], 4 * size - y)
