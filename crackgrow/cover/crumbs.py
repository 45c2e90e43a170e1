"""Crumbs: pieces of rock, cut out by cracks, that are no larger than a spacing.

All functions of the lattice look alike on such a piece, up to what is linear: the stiffness would be singular to
working precision. A crumb has three functions instead, the barycentric coordinates of a triangle round it. They add up
to one and reproduce linear fields, as the others do; the crumb strains uniformly.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from crackgrow.arrays import Bools, Floats, Ints
from crackgrow.cover.elements import Elements
from crackgrow.cover.lattice import Lattice
from crackgrow.cover.patches import Patches, with_those
from crackgrow.cover.shapes import CrackGeometry
from crackgrow.geometry.arrangement import connected
from crackgrow.ragged import Ragged, starts_of
from crackgrow.vectors import cross

LARGEST_CRUMB = 1.0
"""Spacings: side of the box round a crumb."""

AROUND = np.array([(-1.0, -0.6), (1.0, -0.6), (0.0, 1.2)])
"""Corners of a triangle round a box of side 1 about the origin."""


def barycentric(points: Floats, corners: Floats) -> Floats:
    """Functions (3, n, 3) at points (n, 2) of crumbs with `corners` (n, 3, 2): values, and slopes by x and by y."""
    a, b, c = corners.transpose(1, 0, 2)
    slopes = np.stack([_turned(b - c), _turned(c - a), _turned(a - b)], axis=1) / cross(b - a, c - a)[:, None, None]
    values = 1.0 / 3.0 + np.einsum("nkd,nd->nk", slopes, points - (a + b + c) / 3.0)
    return np.stack([values, slopes[..., 0], slopes[..., 1]])


def with_crumbs(lattice: Lattice, elements: Elements, patches: Patches, cracks: Sequence[CrackGeometry]) -> Patches:
    """The patches, those of crumbs replaced by three each; `cracks` are the first lines of the elements.

    A piece that holds a tip is no crumb: linear functions don't see a tip.
    """
    ends = zip(cracks, elements.lines, strict=False)
    at_tips = [edges.beside(at_end)[0] for crack, edges in ends for at_end in crack.tips()]
    crumb, corners = _crumbs(lattice, elements, np.array(at_tips, dtype=np.int64))
    inside = crumb >= 0
    if not inside.any():
        return patches
    of_element = patches.of_element
    in_crumb = np.repeat(inside, of_element.counts)
    kept = np.ones(len(patches.nodes), dtype=bool)
    kept[of_element.values[in_crumb]] = False
    rest = with_those(patches, kept)
    counts = np.where(inside, 3, rest.of_element.counts)
    start = starts_of(counts)
    values, slot = np.empty((2, start[-1]), dtype=np.int64)
    linear = np.repeat(inside, counts)
    values[~linear], slot[~linear] = rest.of_element.values, rest.slot
    values[linear] = (rest.n_of_lattice + 3 * crumb[inside, None] + np.arange(3)).ravel()
    slot[linear] = np.tile(np.arange(3), int(inside.sum()))
    nodes = np.concatenate([rest.nodes, corners.reshape(-1, 2)])
    return Patches(Ragged(start, values), slot, nodes, rest.n_of_lattice, inside)


def _crumbs(lattice: Lattice, elements: Elements, at_tips: Ints) -> tuple[Ints, Floats]:
    """The crumb that each element belongs to (elements,), -1 for none, and the triangle round each (n, 3, 2)."""
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
    return number[label], corners.reshape(-1, 3, 2)


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


def _turned(v: Floats) -> Floats:
    """Vectors (n, 2) turned clockwise by a right angle."""
    return np.stack([v[:, 1], -v[:, 0]], axis=1)
