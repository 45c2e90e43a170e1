"""Squares of a quadtree: they do not overlap, and each side is a power of two and divides the square's place.

Places are whole numbers of a quantum. Along the Morton curve all squares inside of a larger one follow each other
(Morton 1966), so a square is found by one search.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import shapely

from crackgrow.arrays import Floats, Ints
from crackgrow.ragged import Ragged, distinct, spans, starts_of

QUANTA = 2**18
"""Quanta a spacing: room for many halvings of cells, and for patches that end in quarters of the smallest."""

CORNERS = np.array([(0, 0), (0, 1), (1, 0), (1, 1)])
"""Corners of a square of side one, from left to right and upwards."""

_HALVINGS = (
    (16, 0x0000FFFF0000FFFF), (8, 0x00FF00FF00FF00FF), (4, 0x0F0F0F0F0F0F0F0F), (2, 0x3333333333333333),
    (1, 0x5555555555555555),
)  # fmt: skip


@dataclass(frozen=True, eq=False)
class Squares:
    """The squares, by their lower left corners from left to right and upwards."""

    low: Ints  # (n, 2) quanta
    size: Ints  # (n,) quanta
    curve: Ints  # (n,) the squares along the Morton curve
    codes: Ints  # (n,) their places on it, ascending

    @property
    def n(self) -> int:
        """Number of squares."""
        return len(self.size)

    @cached_property
    def tree(self) -> shapely.STRtree:
        """Over the squares, spacings."""
        low, high = self.low / QUANTA, (self.low + self.size[:, None]) / QUANTA
        return shapely.STRtree(shapely.box(*low.T, *high.T))

    @property
    def corners(self) -> Ints:
        """The corners of all squares (m, 2), each once, from left to right and upwards."""
        every = (self.low[:, None] + self.size[:, None, None] * CORNERS).reshape(-1, 2)
        base = int(every.max()) + 1
        return np.stack(np.divmod(distinct(every[:, 0] * base + every[:, 1]), base), axis=1)

    def equal(self, other: Squares) -> bool:
        """Whether two sets are the same squares."""
        return np.array_equal(self.low, other.low) and np.array_equal(self.size, other.size)

    def quartered(self) -> Squares:
        """The four quarters of each."""
        return squares_of(*quarters_of(self.low, self.size))

    def at(self, places: Ints) -> Ints:
        """The square (m,) that holds the quantum right above each of `places` (m, 2); -1 for none."""
        codes, (x, y) = _codes(np.maximum(places, 0)), places.T
        last = np.maximum(np.searchsorted(self.codes, codes, side="right") - 1, 0)
        found, off = self.curve[last], codes - self.codes[last]
        return np.where((off >= 0) & (off < self.size[found] ** 2) & (x >= 0) & (y >= 0), found, -1)

    def around(self, points: Floats) -> Ints:
        """The squares (n, 4) that touch points (n, 2), lattice coordinates: below left, above left, below, above right.

        Inside of a square all four are the same; -1 for none.
        """
        scaled = points * QUANTA
        sides = np.stack([np.ceil(scaled) - 1.0, np.floor(scaled)]).astype(np.int64)  # below and above
        places = np.stack([sides[[0, 0, 1, 1], :, 0], sides[[0, 1, 0, 1], :, 1]], axis=-1)
        return self.at(places.reshape(-1, 2)).reshape(4, -1).T

    def within(self, low: Ints, size: Ints) -> Ragged:
        """All squares inside of others (m,), which need not belong to these; none where one of these is larger."""
        begin = _codes(np.maximum(low, 0))
        first = np.searchsorted(self.codes, begin)
        counts = np.searchsorted(self.codes, begin + size * size) - first
        larger = self.size[self.curve[np.minimum(first, self.n - 1)]] > size
        counts[(low[:, 0] < 0) | (low[:, 1] < 0) | larger] = 0
        return Ragged(starts_of(counts), self.curve[spans(first, counts)])


def squares_of(low: Ints, size: Ints) -> Squares:
    """The squares with these corners (n, 2) and sizes (n,)."""
    order = np.lexsort((low[:, 1], low[:, 0]))
    low, size = low[order], size[order]
    codes = _codes(low)
    curve = np.argsort(codes)
    return Squares(low, size, curve, codes[curve])


def quarters_of(low: Ints, size: Ints) -> tuple[Ints, Ints]:
    """The four quarters of each square (n,): corners (4 n, 2) and sizes (4 n,)."""
    half = size // 2
    corners = low[:, None] + CORNERS * half[:, None, None]
    return np.asarray(corners, dtype=np.int64).reshape(-1, 2), np.repeat(half, 4)


def _codes(places: Ints) -> Ints:
    """Places (n,) on the Morton curve of corners (n, 2), below 2^31: the bits of both coordinates in turn."""
    spread = places.T.astype(np.int64, order="C")  # with a zero between every two bits
    for shift, mask in _HALVINGS:
        spread |= spread << shift
        spread &= mask
    x, y = spread
    return np.asarray(2 * x + y)
