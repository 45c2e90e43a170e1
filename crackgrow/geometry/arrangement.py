"""The planar arrangement: a set of lines cut into faces and edges that share their vertices exactly.

GEOS nodes and polygonizes; every vertex lies on a grid that holds the integers exactly (`tolerance.GRID`), so vertices
and edges are compared as whole numbers.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from crackgrow.arrays import Floats, Ints
from crackgrow.geometry.tolerance import GRID
from crackgrow.ragged import distinct, found_in


@dataclass(frozen=True, slots=True, eq=False)
class Edges:
    """Undirected edges between faces, in the order of their vertices.

    `left` sees the edge from vertex `a` to vertex `b` counter-clockwise.
    """

    a: Ints  # (n,) vertex ids
    b: Ints  # (n,)
    left: Ints  # (n,) face on the left of a -> b
    right: Ints  # (n,) face on the right, -1 where there is none
    keys: Ints  # (n,) the lower vertex times n_vertices plus the higher one, ascending
    n_vertices: int

    def between(self, start: Ints, end: Ints) -> Ints:
        """Numbers (n,) of the edges between vertices `start` and `end` (n,), either way round; -1 for none."""
        return found_in(self.keys, np.minimum(start, end) * self.n_vertices + np.maximum(start, end))


@dataclass(frozen=True, slots=True, eq=False)
class Rings:
    """Directed edges round faces, which lie on their left."""

    start: Ints  # (r,) vertex ids
    end: Ints  # (r,)
    face: Ints  # (r,)


_COMPLEX = np.array([1.0, 1.0j])


def as_complex(points: Floats) -> NDArray[np.complex128]:
    """Return points (..., 2) as complex numbers x + iy (...), exactly: NumPy orders these by x, then by y."""
    return np.asarray(points @ _COMPLEX)


def on_grid(points: Floats) -> Floats:
    """Points (n, 2) rounded to the grid of the arrangement."""
    return np.asarray(np.rint(points / GRID) * GRID)


def faces_of(arrangements: NDArray[np.object_] | list[shapely.MultiLineString]) -> tuple[NDArray[np.object_], Ints]:
    """Faces (polygons, counter-clockwise) that the lines of each of `arrangements` (n,) enclose, and which it is (p,).

    All vertices are on the grid. What one arrangement is cut into does not depend on the others.
    """
    noded = shapely.union_all(np.asarray(arrangements)[:, None], grid_size=GRID, axis=1)
    polygons, owner = shapely.get_parts(shapely.polygonize(noded[:, None]), return_index=True)
    return np.asarray(shapely.orient_polygons(polygons)), owner.astype(np.int64)


def ring_vertices(polygons: NDArray[np.object_]) -> tuple[Floats, Ints, Ints]:
    """Directed ring edges of polygons: start points (n, 2), the position of each edge's end among them, polygon ids."""
    rings, polygon_of_ring = shapely.get_rings(polygons, return_index=True)
    coordinates, ring = shapely.get_coordinates(rings, return_index=True)
    n = len(ring)
    closing = np.append(ring[1:] != ring[:-1], True)[:n]  # these points repeat the first of their ring
    position, following = np.cumsum(~closing) - 1, np.arange(1, n + 1)
    last = np.flatnonzero(closing) - 1
    following[last] = np.searchsorted(ring, ring[last])
    end = position[following[~closing]]
    return coordinates[~closing], end, polygon_of_ring[ring[~closing]].astype(np.int64)


def vertex_ids(points: Floats) -> Ints:
    """Ids (n,) of points (n, 2) on the grid: equal for equal points, dense from 0."""
    return np.asarray(np.unique(as_complex(on_grid(points)), return_inverse=True)[1], dtype=np.int64)


def connected(n: int, first: Ints, second: Ints) -> Ints:
    """Component (n,) of n things that links first[i] - second[i] join, numbered in the order of their first ones."""
    root = np.arange(n)  # of the tree that each thing hangs in, never above the thing itself
    while len(first):
        one, other = root[first], root[second]
        apart = one != other
        first, second = one[apart], other[apart]
        np.minimum.at(root, np.maximum(first, second), np.minimum(first, second))
        above = root[root]
        while (above != root).any():
            root, above = above, above[above]
    return np.asarray((np.cumsum(root == np.arange(n)) - 1)[root])


def edges_between(rings: Rings, n_vertices: int) -> Edges:
    """Pair directed edges into undirected ones; each of these has one face on a side at most."""
    start, end, face = rings.start, rings.end, rings.face
    key = np.minimum(start, end) * n_vertices + np.maximum(start, end)
    keys = distinct(key)
    a, b = np.divmod(keys, n_vertices)
    left, right = np.full((2, len(keys)), -1, dtype=np.int64)
    forward, place = start < end, np.searchsorted(keys, key)
    left[place[forward]], right[place[~forward]] = face[forward], face[~forward]
    turn = left < 0  # only a right face: turn the edge round, so that `left` always exists
    a[turn], b[turn] = b[turn], a[turn]
    left[turn], right[turn] = right[turn], -1
    return Edges(a, b, left, right, keys, n_vertices)
