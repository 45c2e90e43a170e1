"""Crumbs: pieces of rock, cut out by cracks, that are no larger than a spacing.

All functions of the lattice look alike on such a piece, up to what is linear: the stiffness would be singular to
working precision. A crumb has three functions instead, the barycentric coordinates of a triangle round it. They add up
to one and reproduce linear fields, as the others do; the crumb strains uniformly.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from crackgrow.arrays import Bools, Floats, Ints
from crackgrow.cover.elements import Elements
from crackgrow.cover.lattice import Lattice
from crackgrow.geometry.arrangement import connected
from crackgrow.vectors import cross

LARGEST_CRUMB = 1.0
"""Spacings: side of the box round a crumb."""

AROUND = np.array([(-1.0, -0.6), (1.0, -0.6), (0.0, 1.2)])
"""Corners of a triangle round a box of side 1 about the origin."""


@dataclass(frozen=True, slots=True, eq=False)
class Crumbs:
    """The crumbs of a cover."""

    of_element: Ints  # (elements,) number of the crumb that an element belongs to, -1 for none
    corners: Floats  # (n, 3, 2) the triangle of each crumb

    @property
    def n(self) -> int:
        """Number of crumbs."""
        return len(self.corners)

    def functions(self, points: Floats, crumb: Ints) -> tuple[Floats, Floats]:
        """Barycentric coordinates (n, 3) and their gradients (n, 3, 2) per spacing at points (n, 2) of crumbs (n,)."""
        a, b, c = self.corners[crumb].transpose(1, 0, 2)
        twice_area = cross(b - a, c - a)
        gradients = np.stack([_turned(b - c), _turned(c - a), _turned(a - b)], axis=1) / twice_area[:, None, None]
        centre = (a + b + c) / 3.0
        return 1.0 / 3.0 + np.einsum("nkd,nd->nk", gradients, points - centre), gradients


def find_crumbs(lattice: Lattice, elements: Elements, at_tips: Ints) -> Crumbs:
    """The pieces of rock that are small enough.

    One that holds a tip is none, linear functions don't see it: `at_tips` (k,) are elements at the tips.
    """
    large = np.zeros(elements.n + 1, dtype=bool)  # the last entry serves the index -1
    large[elements.whole_of_tile[_in_long_rows(lattice, elements.whole_of_tile >= 0)]] = True
    number = np.where(large[:-1], 0, np.cumsum(~large[:-1]))
    edges = elements.edges
    links = np.flatnonzero(~(large[edges.left] & large[edges.right]) & elements.passable)
    label = connected(int(number.max(initial=0)) + 1, number[edges.left[links]], number[edges.right[links]])[number]
    n = int(label.max(initial=-1)) + 1
    low, high = np.full((2, 2, n), np.inf)
    high = -high
    corner = np.flatnonzero(~large[elements.ring_element])
    points, piece = elements.vertices[elements.ring_start[corner]], label[elements.ring_element[corner]]
    for axis in range(2):
        np.minimum.at(low[axis], piece, points[:, axis])
        np.maximum.at(high[axis], piece, points[:, axis])
    size = (high - low).max(axis=0)
    small = size <= LARGEST_CRUMB
    small[0] = False  # that of all large ones
    small[label[at_tips]] = False
    number = np.where(small, np.cumsum(small) - 1, -1)
    corners = 0.5 * (low[:, small] + high[:, small]).T[:, None] + AROUND * size[small, None, None]
    return Crumbs(number[label], corners.reshape(-1, 3, 2))


def _in_long_rows(lattice: Lattice, whole: Bools) -> Bools:
    """Which whole tiles (tiles x, tiles y) are one of a row, or of a column, of whole tiles longer than a spacing."""
    n = len(lattice.breaks)  # as many parts as a cell has, and one more
    found = np.zeros(whole.shape, dtype=bool)
    for tiles, marks in ((whole, found), (whole.T, found.T)):
        n_starts = max(len(tiles) + 1 - n, 0)
        starts = np.logical_and.reduce([tiles[k : k + n_starts] for k in range(n)])
        for k in range(n):
            marks[k : k + n_starts] |= starts
    return found


def with_crumbs(crumbs: Crumbs, functions: Ints, nodes: Ints) -> tuple[Ints, Floats]:
    """Physical patches (n, window) of the elements and their nodes (p, 2), those of crumbs replaced by three each."""
    if crumbs.n == 0:
        return functions, nodes.astype(np.float64)
    inside = crumbs.of_element >= 0
    kept = np.ones(len(nodes), dtype=bool)
    dropped = functions[inside]
    kept[dropped[dropped >= 0]] = False
    number = np.append(np.where(kept, np.cumsum(kept) - 1, -1), -1)  # the last entry serves the index -1
    functions = number[functions]
    functions[inside, :3] = kept.sum() + 3 * crumbs.of_element[inside, None] + np.arange(3)
    return functions, np.concatenate([nodes[kept], crumbs.corners.reshape(-1, 2)])


def _turned(v: Floats) -> Floats:
    """Vectors (n, 2) turned clockwise by a right angle."""
    return np.stack([v[:, 1], -v[:, 0]], axis=1)
