"""Crumbs: pieces of rock, cut out by cracks, that are no larger than a cell there.

All functions of the lattice look alike on such a piece, up to what is linear: the stiffness would be singular to
working precision. A crumb has three functions instead, round the corners of a triangle round it: of so few, moving
least squares makes the barycentric coordinates, whatever the weights. The crumb strains uniformly.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from crackgrow.arrays import Floats, Ints
from crackgrow.cover.elements import Elements
from crackgrow.cover.patches import Patches, with_those
from crackgrow.cover.shapes import CrackGeometry
from crackgrow.geometry.arrangement import connected
from crackgrow.ragged import Ragged, starts_of

LARGEST_CRUMB = 1.0
"""Side of the box round a crumb, over that of the largest cell that it has a part of."""

AROUND = np.array([(-1.0, -0.6), (1.0, -0.6), (0.0, 1.2)])
"""Corners of a triangle round a box of side 1 about the origin."""


def with_crumbs(elements: Elements, patches: Patches, cracks: Sequence[CrackGeometry]) -> Patches:
    """The patches, those of crumbs replaced by three each; `cracks` are the first lines of the elements.

    A piece that holds a tip is no crumb: linear functions don't see a tip.
    """
    ends = zip(cracks, elements.lines, strict=False)
    at_tips = [edges.beside(at_end)[0] for crack, edges in ends for at_end in crack.tips()]
    crumb, corners = _crumbs(elements, np.array(at_tips, dtype=np.int64))
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
    values = np.empty(start[-1], dtype=np.int64)
    linear = np.repeat(inside, counts)
    values[~linear] = rest.of_element.values
    values[linear] = (rest.n_of_lattice + 3 * crumb[inside, None] + np.arange(3)).ravel()
    nodes = np.concatenate([rest.nodes, corners.reshape(-1, 2)])
    half = np.concatenate([rest.half, np.repeat(np.ptp(corners[:, :, 0], axis=1) / 2.0, 3)])
    return Patches(Ragged(start, values), nodes, half, rest.n_of_lattice, inside)


def _crumbs(elements: Elements, at_tips: Ints) -> tuple[Ints, Floats]:
    """The crumb that each element belongs to (elements,), -1 for none, and the triangle round each (n, 3, 2)."""
    edges = elements.edges
    links = np.flatnonzero(elements.passable)
    label = connected(elements.n, edges.left[links], edges.right[links])
    n = int(label.max(initial=-1)) + 1
    low, high = np.full((2, 2, n), np.inf)
    high, cell = -high, np.zeros(n)
    points, piece = elements.vertices[elements.rings.start], label[elements.rings.face]
    for axis in range(2):
        np.minimum.at(low[axis], piece, points[:, axis])
        np.maximum.at(high[axis], piece, points[:, axis])
    np.maximum.at(cell, label, elements.size)
    size = (high - low).max(axis=0)
    small = size <= LARGEST_CRUMB * cell
    small[label[at_tips]] = False
    number = np.where(small, np.cumsum(small) - 1, -1)
    corners = 0.5 * (low[:, small] + high[:, small]).T[:, None] + AROUND * size[small, None, None]
    return number[label], corners.reshape(-1, 3, 2)
