"""Physical patches: the connected pieces into which cracks and outlines cut the mathematical patches.

Crumbs are pieces of rock, cut out by cracks, that are no larger than a cell there. All functions of the lattice look
alike on such a piece, up to what is linear: the stiffness would be singular to working precision. A crumb has three
functions instead, round the corners of a triangle round it: of so few, moving least squares makes the barycentric
coordinates, whatever the weights. The crumb strains uniformly.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from crackgrow.arrays import Bools, Floats, Ints
from crackgrow.cover.elements import Elements
from crackgrow.cover.lattice import Lattice
from crackgrow.cover.shapes import CrackGeometry
from crackgrow.cover.squares import QUANTA
from crackgrow.geometry.arrangement import connected
from crackgrow.ragged import Ragged, found_in, starts_of

SPECK = 1e-15
"""A patch whose weight is nowhere larger than this contributes less than round-off."""

PEEK, PEEK_WEIGHT = 0.03, 1e-10
"""Nor has a patch functions whose rock is smaller than `PEEK` cells, with no larger weight times size than this.
Such patches a kink cuts off at their edge, where it peeks over a tile line, and they nearly depend on each other: the
compliance of contact lost its symmetry or was singular. Of 135 random kinks 2e-6 is the worst left."""

LARGEST_CRUMB = 1.0
"""Side of the box round a crumb, over that of the largest cell that it has a part of."""

AROUND = np.array([(-1.0, -0.6), (1.0, -0.6), (0.0, 1.2)])
"""Corners of a triangle round a box of side 1 about the origin."""

WIDE = 4.0
"""Half width of the weights of a crumb's functions, over that of the triangle round it."""


@dataclass(frozen=True, slots=True, eq=False)
class Patches:
    """All physical patches, and which of them are over each element."""

    of_element: Ragged  # elements -> their patches, ascending
    nodes: Floats  # (p, 2) node of every patch; crumbs follow with their corners
    half: Floats  # (p,) half width of every patch, spacings; of a crumb that of its triangle
    n_of_lattice: int  # patches of the lattice's nodes: all but those of crumbs
    in_crumb: Bools  # (elements,) which elements belong to crumbs

    @property
    def weight_half(self) -> Floats:
        """Half widths (p,) of their weights. All three of a crumb reach all of it: so they are linear."""
        return np.where(np.arange(len(self.half)) < self.n_of_lattice, self.half, WIDE * self.half)


def physical_patches(lattice: Lattice, elements: Elements, cracks: Sequence[CrackGeometry]) -> Patches:
    """The patches of all nodes but specks, and those of crumbs; `cracks` are the first lines of the elements."""
    patches = _connected_pieces(lattice, elements)
    patches = _with_those(patches, _is_seen(lattice, elements, patches))
    return _with_crumbs(elements, patches, cracks)


def _connected_pieces(lattice: Lattice, elements: Elements) -> Patches:
    """The patches of all nodes.

    Two elements of one mathematical patch belong to the same physical patch if a way inside the patch leads from one
    to the other without crossing a crack or leaving the body. Patches are numbered along the lattice, those of one node
    by their first elements.
    """
    pairs = lattice.tiles.over.taken(elements.tile)  # of an element and a node
    n_nodes = len(lattice.nodes.half)
    keys, edges, links = pairs.row * n_nodes + pairs.values, elements.edges, np.flatnonzero(elements.passable)
    which, one = pairs.places(edges.left[links])
    other = found_in(keys, edges.right[links][which] * n_nodes + pairs.values[one])
    label = connected(len(keys), one[other >= 0], other[other >= 0])
    first = np.flatnonzero(np.diff(np.maximum.accumulate(label), prepend=-1) > 0)  # pair of each piece
    patches = np.argsort(pairs.values[first], kind="stable")
    number, of_node = np.empty(len(patches), dtype=np.int64), pairs.values[first[patches]]
    number[patches] = np.arange(len(patches))
    nodes, half = lattice.nodes.places[of_node] / QUANTA, lattice.nodes.half[of_node] / QUANTA
    return Patches(Ragged(pairs.start, number[label]), nodes, half, len(nodes), np.zeros(elements.n, dtype=bool))


def _is_seen(lattice: Lattice, elements: Elements, patches: Patches) -> Bools:
    """Which physical patches (p,) give no rows of zeros, nor rows that depend on others but for round-off.

    The weight of a patch grows as the cube of the depth inside of the patch, per axis. Patches that hold a whole tile
    are all seen: a tile is no smaller than an eighth of the cells of a node.
    """
    of_element, nodes, skipped = patches.of_element, patches.nodes, elements.n_whole
    sure = np.zeros(len(nodes), dtype=bool)
    sure[of_element.values[: of_element.start[skipped]]] = True
    ring = slice(int(np.searchsorted(elements.rings.face, skipped)), None)
    owner = np.concatenate([elements.rings.face[ring], np.arange(skipped, elements.n)])
    points = np.concatenate([elements.vertices[elements.rings.start[ring]], elements.reference[skipped:]])
    unsure = of_element.kept(~sure[of_element.values])
    which, place = unsure.places(owner)
    used = unsure.values[place]
    from_node = (points[which] - nodes[used]) / patches.half[used, None]
    weight = np.zeros(len(nodes))
    np.maximum.at(weight, used, np.prod(np.maximum(1.0 - np.abs(from_node), 0.0), axis=1) ** 3)
    low, high = _boxes(from_node, used, len(nodes))
    size = lattice.support * np.maximum(high - low, 0.0).max(axis=1)  # cells
    return np.asarray(sure | ((weight > SPECK) & ((weight * size > PEEK_WEIGHT) | (size > PEEK))))


def _boxes(points: Floats, owner: Ints, n: int) -> tuple[Floats, Floats]:
    """Lower left and upper right corners (n, 2) of the boxes round the points (k, 2) of each of n owners."""
    low, high = np.full((n, 2), np.inf), np.full((n, 2), -np.inf)
    for axis in range(2):
        np.minimum.at(low[:, axis], owner, points[:, axis])
        np.maximum.at(high[:, axis], owner, points[:, axis])
    return low, high


def _with_those(patches: Patches, kept: Bools) -> Patches:
    """The patches `kept` (p,) alone, under new numbers."""
    if kept.all():
        return patches
    on = kept[patches.of_element.values]
    left, number = patches.of_element.kept(on), np.cumsum(kept) - 1
    return replace(
        patches,
        of_element=Ragged(left.start, number[left.values]),
        nodes=patches.nodes[kept],
        half=patches.half[kept],
        n_of_lattice=int(kept.sum()),
    )


def _with_crumbs(elements: Elements, patches: Patches, cracks: Sequence[CrackGeometry]) -> Patches:
    """The patches, those of crumbs replaced by three each.

    A piece that holds a tip is no crumb: linear functions don't see a tip.
    """
    edges, links = elements.edges, np.flatnonzero(elements.passable)
    label = connected(elements.n, edges.left[links], edges.right[links])
    n = int(label.max(initial=-1)) + 1
    low, high = _boxes(elements.vertices[elements.rings.start], label[elements.rings.face], n)
    size, cell = (high - low).max(axis=1), np.zeros(n)
    np.maximum.at(cell, label, elements.size)
    small = size <= LARGEST_CRUMB * cell
    for crack, beside in zip(cracks, elements.lines, strict=False):
        small[label[[beside.beside(at_end)[0] for at_end in crack.tips()]]] = False
    if not small.any():
        return patches
    inside, number = small[label], np.cumsum(small) - 1
    kept = np.ones(len(patches.nodes), dtype=bool)
    kept[patches.of_element.values[np.repeat(inside, patches.of_element.counts)]] = False
    rest = _with_those(patches, kept)
    counts = np.where(inside, 3, rest.of_element.counts)
    start, linear = starts_of(counts), np.repeat(inside, counts)
    values = np.empty(start[-1], dtype=np.int64)
    values[~linear] = rest.of_element.values
    values[linear] = (rest.n_of_lattice + 3 * number[label[inside], None] + np.arange(3)).ravel()
    corners = 0.5 * (low + high)[small, None] + AROUND * size[small, None, None]
    nodes = np.concatenate([rest.nodes, corners.reshape(-1, 2)])
    half = np.concatenate([rest.half, np.repeat(np.ptp(corners[:, :, 0], axis=1) / 2.0, 3)])
    return Patches(Ragged(start, values), nodes, half, rest.n_of_lattice, inside)
