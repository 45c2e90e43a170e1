"""Numbers of vertices and edges: those of tiles are known from the lattice, only the others are sorted.

The corners of all tiles are vertices, whether a body is there or not; those that lines make follow them, from left to
right. The sides of tiles are edges, in the order of their corners; then come all others, in that of their vertices.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from crackgrow.arrays import Floats, Ints
from crackgrow.cover.tiling import Tiling
from crackgrow.geometry.arrangement import Edges, Rings, as_numbers, edges_between


@dataclass(frozen=True, slots=True, eq=False)
class Vertices:
    """The vertices: corners of tiles, then those that lines make."""

    tiling: Tiling
    others: NDArray[np.complex128]  # (n,) ascending

    @property
    def points(self) -> Floats:
        """All vertices (v, 2)."""
        numbers = np.concatenate([self.tiling.corners, self.others])
        return np.stack([numbers.real, numbers.imag], axis=1)

    @property
    def n(self) -> int:
        """Number of vertices."""
        return len(self.tiling.corners) + len(self.others)

    def at(self, points: Floats) -> Ints:
        """Numbers (n,) of the vertices at `points` (n, 2), -1 where there is none."""
        number = self.tiling.corners_at(points)
        rest = np.flatnonzero(number < 0)
        wanted = as_numbers(points[rest])
        place = np.searchsorted(self.others, wanted)
        found = place < len(self.others)
        found[found] = self.others[place[found]] == wanted[found]
        number[rest[found]] = len(self.tiling.corners) + place[found]
        return number


@dataclass(frozen=True, slots=True, eq=False)
class EdgeNumbers:
    """Finds edges by their vertices."""

    tiling: Tiling
    of_side: Ints  # (sides,) number of the edge on each side of tiles, -1 for none
    keys: Ints  # (e,) of all other edges, ascending
    base: int
    first: int  # number of the first of them

    def between(self, start: Ints, end: Ints) -> Ints:
        """Numbers (n,) of the edges between vertices `start` and `end` (n,), either way round; -1 for none."""
        low, high = np.minimum(start, end), np.maximum(start, end)
        number = np.full(len(low), -1, dtype=np.int64)
        side = self.tiling.sides_between(low, high)
        number[side >= 0] = self.of_side[side[side >= 0]]
        key = low * self.base + high
        place = np.minimum(np.searchsorted(self.keys, key), len(self.keys) - 1)
        if len(self.keys):
            found = (side < 0) & (low >= 0) & (self.keys[place] == key)
            number[found] = self.first + place[found]
        return number


def number_vertices(tiling: Tiling, points: Floats) -> tuple[Vertices, Ints]:
    """The vertices of an arrangement with corners of polygons `points` (n, 2), and the numbers (n,) of these."""
    number = tiling.corners_at(points)
    rest = number < 0
    others, place = np.unique(as_numbers(points[rest]), return_inverse=True)
    number[rest] = len(tiling.corners) + place
    return Vertices(tiling, others), number


def number_edges(vertices: Vertices, rings: Rings) -> tuple[Edges, EdgeNumbers]:
    """The edges of faces, and their numbers."""
    tiling, start, end, face = vertices.tiling, rings.start, rings.end, rings.face
    left, right = np.full((2, len(tiling.sides)), -1, dtype=np.int64)
    side = tiling.sides_between(start, end)
    forward, backward = (side >= 0) & (start < end), (side >= 0) & (start > end)
    left[side[forward]], right[side[backward]] = face[forward], face[backward]
    # from the lower number to the higher: upwards or to the right, as with the others
    rest = side < 0
    others = edges_between(Rings(start[rest], end[rest], face[rest]))

    sides = np.flatnonzero((left >= 0) | (right >= 0))
    a, b = np.divmod(tiling.sides[sides], len(tiling.corners))
    left, right = left[sides], right[sides]
    turn = np.flatnonzero(left < 0)
    a[turn], b[turn] = b[turn], a[turn].copy()
    left[turn], right[turn] = right[turn], -1
    of_side = np.full(len(tiling.sides), -1, dtype=np.int64)
    of_side[sides] = np.arange(len(sides))
    edges = Edges(
        *(np.concatenate(pair) for pair in ((a, others.a), (b, others.b), (left, others.left), (right, others.right)))
    )
    keys = np.minimum(others.a, others.b) * vertices.n + np.maximum(others.a, others.b)
    return edges, EdgeNumbers(tiling, of_side, keys, vertices.n, len(sides))
