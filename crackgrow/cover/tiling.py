"""The tiles as a mesh: their corners, and their sides, which the corners of smaller neighbours divide.

Corners are numbered from left to right and upwards, sides in the order of their corners.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from crackgrow.arrays import Floats, Ints
from crackgrow.cover.squares import QUANTA, Squares
from crackgrow.geometry.arrangement import as_numbers
from crackgrow.ragged import Ragged, by_row, distinct


@dataclass(frozen=True, slots=True, eq=False)
class Tiling:
    """The mesh of n tiles."""

    corners: NDArray[np.complex128]  # (v,) ascending, spacings
    ring: Ragged  # tiles -> corners on their rims, counter-clockwise from the lower left
    following: Ints  # (places of `ring`,) the next corner
    sides: Ints  # (s,) first corner times v plus second, ascending

    @property
    def points(self) -> Floats:
        """The corners (v, 2)."""
        return np.stack([self.corners.real, self.corners.imag], axis=1)

    def corners_at(self, points: Floats) -> Ints:
        """Numbers (n,) of the corners at `points` (n, 2), -1 for none."""
        wanted = as_numbers(points)
        place = np.minimum(np.searchsorted(self.corners, wanted), len(self.corners) - 1)
        return np.where(self.corners[place] == wanted, place, -1)

    def sides_between(self, start: Ints, end: Ints) -> Ints:
        """Numbers (n,) of the sides between corners `start` and `end` (n,), either way round; -1 for none."""
        n = len(self.corners)
        low, high = np.minimum(start, end), np.maximum(start, end)
        key = low * n + high
        place = np.minimum(np.searchsorted(self.sides, key), len(self.sides) - 1)
        return np.where((low >= 0) & (high < n) & (self.sides[place] == key), place, -1)


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
    keys = np.minimum(ring.values, following) * len(corners) + np.maximum(ring.values, following)
    return Tiling(as_numbers(corners / QUANTA), ring, following, distinct(keys))


def _along_rim(off: Ints, size: Ints) -> Ints:
    """How far (n,) round squares of `size` (n,) points on their rims are, from the lower left corner; `off` (n, 2)."""
    x, y = off.T
    return np.select([y == 0, x == size, y == size], [x, size + y, 3 * size - x], 4 * size - y)
