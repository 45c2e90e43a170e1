"""Physical patches: the connected pieces into which cracks and outlines cut the mathematical patches.

A mathematical patch of whole tiles only is one physical patch. Ways are followed in the others.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from crackgrow.arrays import Bools, Floats, Ints
from crackgrow.cover.elements import Elements
from crackgrow.cover.lattice import Lattice
from crackgrow.cover.squares import QUANTA
from crackgrow.geometry.arrangement import connected
from crackgrow.ragged import Ragged, starts_of

SPECK = 1e-15
"""A patch whose weight is nowhere larger than this contributes less than round-off."""

PEEK, PEEK_WEIGHT = 0.03, 1e-10
"""Nor has a patch functions whose rock is smaller than `PEEK` cells, with no larger weight times size than this.
Such patches a kink cuts off at their edge, where it peeks over a tile line, and they nearly depend on each other: the
compliance of contact lost its symmetry or was singular. Of 135 random kinks 2e-6 is the worst left."""

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


def physical_patches(lattice: Lattice, elements: Elements) -> Patches:
    """The patches of all nodes, before crumbs have theirs.

    Two elements of one mathematical patch belong to the same physical patch if a way inside the patch leads from one
    to the other without crossing a crack or leaving the body. Patches are numbered along the lattice, those of one node
    by their first elements.
    """
    over = lattice.tiles.over
    plain = _uncut_nodes(lattice, elements)
    _, place = over.places(elements.tile)
    node = over.values[place]
    cut = ~plain[node]
    start = starts_of(over.counts[elements.tile])
    piece = _pieces_in_patches(elements, Ragged(start, node).kept(cut))

    is_first = np.diff(np.maximum.accumulate(piece), prepend=-1) > 0  # pieces are numbered in order of their first ones
    node_of_piece = node[cut][is_first]
    order = np.argsort(node_of_piece, kind="stable")
    n_pieces = np.bincount(node_of_piece, minlength=plain.size)
    first_piece = starts_of(n_pieces)
    rank = np.empty(len(order), dtype=np.int64)
    rank[order] = np.arange(len(order)) - first_piece[node_of_piece[order]]
    n_patches = n_pieces + plain
    first = starts_of(n_patches)
    patch = first[node]
    patch[cut] = (first[node_of_piece] + rank)[piece]
    of_node = np.repeat(np.arange(plain.size), n_patches)
    nodes, half = lattice.node_points[of_node], lattice.nodes.half[of_node] / QUANTA
    return Patches(Ragged(start, patch), nodes, half, len(nodes), np.zeros(elements.n, dtype=bool))


def without_specks(lattice: Lattice, elements: Elements, patches: Patches) -> Patches:
    """Leave out physical patches that would give rows of zeros, or rows that depend on others but for round-off.

    The weight of a patch grows as the cube of the depth inside of the patch, per axis. Patches that hold a whole tile
    are none of them: a tile is no smaller than an eighth of the cells of a node.
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
    low, high = np.full((2, 2, len(nodes)), np.inf)
    high, deepest = -high, np.zeros(len(nodes))
    np.maximum.at(deepest, used, np.prod(np.maximum(1.0 - np.abs(from_node), 0.0), axis=1) ** 3)
    for axis in range(2):
        np.minimum.at(low[axis], used, from_node[:, axis])
        np.maximum.at(high[axis], used, from_node[:, axis])
    return with_those(patches, sure | _is_kept(deepest, lattice.support * (high - low).max(axis=0, initial=0.0)))


def with_those(patches: Patches, kept: Bools) -> Patches:
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


def _is_kept(weight: Floats, size: Floats) -> Bools:
    """Whether patches with these largest weights, and sizes in cells, are no specks."""
    return np.asarray((weight > SPECK) & ((weight * size > PEEK_WEIGHT) | (size > PEEK)))


def _uncut_nodes(lattice: Lattice, elements: Elements) -> Bools:
    """Which nodes (n,) have patches of whole tiles only.

    Whole tiles beside each other belong to the same body: where bodies meet tiles are cut.
    """
    over, size = lattice.tiles.over, lattice.tiles.squares.size
    whole = elements.whole_of_tile >= 0
    half = lattice.nodes.half
    area = np.bincount(over.values, np.repeat(whole * size.astype(float) ** 2, over.counts), len(half))
    return np.asarray(area == 4.0 * half.astype(float) ** 2)


def _pieces_in_patches(elements: Elements, cut: Ragged) -> Ints:
    """Connected piece (p,) of each of the pairs (p,) of an element and a node, ascending, whose patch is `cut`."""
    n_nodes = int(cut.values.max(initial=0)) + 1
    keys = cut.row * n_nodes + cut.values
    mine = cut.counts > 0
    left, right = elements.edges.left, elements.edges.right
    chosen = np.flatnonzero(mine[left] & mine[right] & elements.passable)
    which, one = cut.places(left[chosen])
    wanted = right[chosen][which] * n_nodes + cut.values[one]
    other = np.minimum(np.searchsorted(keys, wanted), len(keys) - 1)
    joined = keys[other] == wanted if len(keys) else np.zeros(0, dtype=bool)
    return connected(len(keys), one[joined], other[joined])
