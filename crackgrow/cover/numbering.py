"""Numbers of vertices and edges: those of tiles come from the grid of the tile lines, only the others are sorted.

The corners of all tiles are vertices, whether a body is there or not; those that lines make follow them, from left to
right. The sides of tiles are edges, in the order of their corners; then come all others, in that of their vertices.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from crackgrow.arrays import Floats, Ints
from crackgrow.geometry.arrangement import Edges, as_numbers, edges_between

_ROUND_TILE = np.array([(0, 0), (1, 0), (1, 1), (0, 1)])
"""Corners of a tile, counter-clockwise."""


@dataclass(frozen=True, slots=True, eq=False)
class Vertices:
    """The vertices: corners of tiles, then those that lines make."""

    x: Floats  # (i,) tile lines
    y: Floats  # (j,)
    others: NDArray[np.complex128]  # (n,) ascending

    @property
    def points(self) -> Floats:
        """All vertices (i j + n, 2); corner (k, l) has the number k j + l."""
        n = len(self.x) * len(self.y)
        points = np.empty((n + len(self.others), 2))
        points[:n, 0], points[:n, 1] = np.repeat(self.x, len(self.y)), np.tile(self.y, len(self.x))
        points[n:, 0], points[n:, 1] = self.others.real, self.others.imag
        return points

    def at(self, points: Floats) -> Ints:
        """Numbers (n,) of the vertices at `points` (n, 2), -1 where there is none."""
        corner = _corners_at(self.x, self.y, points)
        rest = np.flatnonzero(corner < 0)
        wanted = as_numbers(points[rest])
        place = np.searchsorted(self.others, wanted)
        found = place < len(self.others)
        found[found] = self.others[place[found]] == wanted[found]
        corner[rest[found]] = len(self.x) * len(self.y) + place[found]
        return corner


@dataclass(frozen=True, slots=True, eq=False)
class EdgeNumbers:
    """Finds edges by their vertices."""

    of_side: Ints  # (2 i j,) number of the edge from corner k upwards (2 k) and to the right (2 k + 1), -1 for none
    n_rows: int  # j
    keys: Ints  # (e,) of all other edges, ascending
    base: int
    first: int  # number of the first of them

    def between(self, start: Ints, end: Ints) -> Ints:
        """Numbers (n,) of the edges between vertices `start` and `end` (n,), either way round; -1 for none."""
        low, high = np.minimum(start, end), np.maximum(start, end)
        number = np.full(len(low), -1, dtype=np.int64)
        side = _sides(low, high, self.n_rows, len(self.of_side))
        number[side >= 0] = self.of_side[side[side >= 0]]
        key = low * self.base + high
        place = np.minimum(np.searchsorted(self.keys, key), len(self.keys) - 1)
        if len(self.keys):
            found = (side < 0) & (low >= 0) & (self.keys[place] == key)
            number[found] = self.first + place[found]
        return number


def number_vertices(x: Floats, y: Floats, points: Floats) -> tuple[Vertices, Ints]:
    """The vertices of an arrangement with corners of polygons `points` (n, 2), and the numbers (n,) of these."""
    number = _corners_at(x, y, points)
    rest = number < 0
    others, place = np.unique(as_numbers(points[rest]), return_inverse=True)
    number[rest] = len(x) * len(y) + place
    return Vertices(x, y, others), number


def corners_of_tiles(tiles: Ints, n_rows: int) -> Ints:
    """Numbers (n, 4) of the corners of tiles (n, 2), counter-clockwise from the lower left; `n_rows` lines in y."""
    return np.asarray((tiles[:, :1] + _ROUND_TILE[:, 0]) * n_rows + tiles[:, 1:] + _ROUND_TILE[:, 1])


def number_edges(vertices: Vertices, corners: Ints, start: Ints, end: Ints, face: Ints) -> tuple[Edges, EdgeNumbers]:
    """The edges of whole tiles with `corners` (n, 4), which are the faces 0 to n - 1, and of polygons.

    Edges of polygons lead from vertex `start` to `end` (e,) round their `face` (e,).
    """
    n_rows, n_corners = len(vertices.y), len(vertices.x) * len(vertices.y)
    left, right = np.full((2, 2 * n_corners), -1, dtype=np.int64)
    number = np.arange(len(corners))
    left[2 * corners[:, 0] + 1] = number
    left[2 * corners[:, 1]] = number
    right[2 * corners[:, 3] + 1] = number
    right[2 * corners[:, 0]] = number
    forward, backward = _sides(start, end, n_rows, 2 * n_corners), _sides(end, start, n_rows, 2 * n_corners)
    left[forward[forward >= 0]] = face[forward >= 0]
    right[backward[backward >= 0]] = face[backward >= 0]
    # a step up has its left at smaller x, one to the right at larger y: as the polygons' own edges tell
    rest = (forward < 0) & (backward < 0)
    others = edges_between(start[rest], end[rest], face[rest])

    sides = np.flatnonzero((left >= 0) | (right >= 0))
    a, axis = np.divmod(sides, 2)
    b = a + np.where(axis == 1, n_rows, 1)
    left, right = left[sides], right[sides]
    turn = np.flatnonzero(left < 0)
    a[turn], b[turn] = b[turn], a[turn].copy()
    left[turn], right[turn] = right[turn], -1
    of_side = np.full(2 * n_corners, -1, dtype=np.int64)
    of_side[sides] = np.arange(len(sides))
    edges = Edges(
        *(np.concatenate(pair) for pair in ((a, others.a), (b, others.b), (left, others.left), (right, others.right)))
    )
    base = n_corners + len(vertices.others)
    keys = np.minimum(others.a, others.b) * base + np.maximum(others.a, others.b)
    return edges, EdgeNumbers(of_side, n_rows, keys, base, len(sides))


def _corners_at(x: Floats, y: Floats, points: Floats) -> Ints:
    """Numbers (n,) of the corners of tiles at `points` (n, 2), -1 for none."""
    i = np.searchsorted(x, points[:, 0], side="right") - 1
    j = np.searchsorted(y, points[:, 1], side="right") - 1
    is_corner = (x[i] == points[:, 0]) & (y[j] == points[:, 1])
    return np.where(is_corner, i * len(y) + j, -1)


def _sides(low: Ints, high: Ints, n_rows: int, n_sides: int) -> Ints:
    """Places (n,) of sides of tiles that lead up or to the right from vertex `low` to `high` (n,); -1 for no such."""
    step = high - low
    is_side = ((step == 1) | (step == n_rows)) & (low >= 0) & (2 * high < n_sides)
    return np.where(is_side, 2 * low + (step == n_rows), -1)
