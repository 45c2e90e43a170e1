"""Physical patches: the connected pieces into which cracks and outlines cut the mathematical patches.

A mathematical patch of whole tiles only is one physical patch. Ways are followed in the others.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from crackgrow.cover.elements import Elements
from crackgrow.cover.lattice import Lattice
from crackgrow.geometry.arrangement import connected

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]

SPECK = 1e-15
"""A patch whose weight is nowhere larger than this contributes less than round-off."""

PEEK, PEEK_WEIGHT = 0.03, 1e-10
"""Nor has a patch functions whose rock is smaller than `PEEK` spacings, with no larger weight times size than this.
Such patches a kink cuts off at their edge, where it peeks over a tile line, and they nearly depend on each other: the
compliance of contact lost its symmetry or was singular. Of 135 random kinks 2e-6 is the worst left."""


def covered_tiles(lattice: Lattice) -> Bools:
    """Whether the patch of a node covers a tile, along an axis: (parts of a cell, places of the node in the window)."""
    middle = 0.5 * (lattice.breaks[1:] + lattice.breaks[:-1])
    return np.asarray(np.abs(np.arange(1 - lattice.reach, lattice.reach + 1) - middle[:, None]) < lattice.support)


def physical_patches(lattice: Lattice, elements: Elements) -> tuple[Ints, Ints]:
    """Physical patch of every node of an element's window (n, window), -1 where none; node of every patch (p, 2).

    Two elements of one mathematical patch belong to the same physical patch if a way inside the patch leads from one
    to the other without crossing a crack or leaving the body. Patches are numbered along the lattice, those of one node
    by their first elements.
    """
    cell, part = np.divmod(elements.tile, len(lattice.breaks) - 1)
    along = covered_tiles(lattice)
    patterns = (along[:, None, :, None] & along[None, :, None, :]).reshape(len(along), len(along), -1)
    plain = _uncut_nodes(lattice, elements, along)
    offset, rows = lattice.offsets + lattice.reach - 1, plain.shape[1]  # plain[0, 0] belongs to node 1 - reach
    node = (cell[:, 0] * rows + cell[:, 1])[:, None] + (offset[:, 0] * rows + offset[:, 1])
    covers = None if patterns.all() else patterns[part[:, 0], part[:, 1]]
    cut = ~plain.ravel()[node]
    if covers is not None:
        cut &= covers
    places = np.flatnonzero(cut)
    piece = _pieces_in_patches(lattice, elements, cell, cut, places)

    is_first = np.diff(np.maximum.accumulate(piece), prepend=-1) > 0  # pieces are numbered in order of their first ones
    node_of_piece = node.ravel()[places[is_first]]
    order = np.argsort(node_of_piece, kind="stable")
    n_pieces = np.bincount(node_of_piece, minlength=plain.size)
    first_piece = np.cumsum(n_pieces) - n_pieces
    rank = np.empty(len(order), dtype=np.int64)
    rank[order] = np.arange(len(order)) - first_piece[node_of_piece[order]]
    n_patches = n_pieces + plain.ravel()
    first = np.cumsum(n_patches) - n_patches
    patch = first[node]
    if covers is not None:
        patch[~covers] = -1
    patch.ravel()[places] = (first[node_of_piece] + rank)[piece]
    nodes = np.stack(np.divmod(np.repeat(np.arange(plain.size), n_patches), rows), axis=1)
    return patch, nodes + 1 - lattice.reach


def without_specks(lattice: Lattice, elements: Elements, patch: Ints, nodes: Ints) -> tuple[Ints, Ints]:
    """Leave out physical patches that would give rows of zeros, or rows that depend on others but for round-off.

    The weight of a patch grows as the cube of the depth inside of the patch, per axis. Patches that hold a whole tile
    are none of them, if tiles are not too small.
    """
    tile = np.diff(lattice.breaks).min(keepdims=True)
    skipped = elements.n_whole if _is_kept((tile / lattice.support) ** 6, tile) else 0
    sure = np.zeros(len(nodes) + 1, dtype=bool)
    sure[patch[:skipped]] = True
    sure[-1] = True  # the last entry serves the index -1
    ring = slice(4 * skipped, None)
    low, high = np.full((2, 2, len(nodes)), np.inf)
    high, deepest = -high, np.zeros(len(nodes))
    for owner, points in (
        (elements.ring_element[ring], elements.vertices[elements.ring_start[ring]]),
        (np.arange(skipped, elements.n), elements.reference[skipped:]),
    ):
        used = patch[owner]
        which, slot = np.nonzero(~sure[used])
        used = used[which, slot]
        from_node = points[which] - nodes[used]
        np.maximum.at(deepest, used, np.prod(np.maximum(1.0 - np.abs(from_node) / lattice.support, 0.0), axis=1) ** 3)
        for axis in range(2):
            np.minimum.at(low[axis], used, from_node[:, axis])
            np.maximum.at(high[axis], used, from_node[:, axis])
    kept = sure[:-1] | _is_kept(deepest, (high - low).max(axis=0, initial=0.0))
    if kept.all():
        return patch, nodes
    number = np.append(np.where(kept, np.cumsum(kept) - 1, -1), -1)
    return number[patch], nodes[kept]


def _is_kept(weight: Floats, size: Floats) -> Bools:
    """Whether patches with these largest weights, and sizes in spacings, are no specks."""
    return np.asarray((weight > SPECK) & ((weight * size > PEEK_WEIGHT) | (size > PEEK)))


def _uncut_nodes(lattice: Lattice, elements: Elements, along: Bools) -> Bools:
    """Which nodes have patches of whole tiles only, `reach` - 1 rows round the lattice included: (nodes x, nodes y).

    Whole tiles beside each other belong to the same body: where bodies meet tiles are cut.
    """
    whole = elements.whole_of_tile >= 0
    count = np.zeros((whole.shape[0] + 1, whole.shape[1] + 1), dtype=np.int64)
    count[1:, 1:] = whole.cumsum(axis=0).cumsum(axis=1)
    parts = len(along)
    part, place = np.nonzero(along)
    tile = part - (place + 1 - lattice.reach) * parts  # seen from the node
    low, n = tile.min(), tile.max() + 1 - tile.min()
    ends = []
    for cells, tiles in zip(lattice.shape, whole.shape, strict=True):
        start = np.arange(1 - lattice.reach, cells + lattice.reach) * parts + low
        ends.append((np.clip(start, 0, tiles), np.clip(start + n, 0, tiles)))
    (x0, x1), (y0, y1) = ends
    inside = (count[x1] - count[x0])[:, y1] - (count[x1] - count[x0])[:, y0]
    return np.asarray(inside == n * n)


def _pieces_in_patches(lattice: Lattice, elements: Elements, cell: Ints, cut: Bools, places: Ints) -> Ints:
    """Connected piece (p,) of each of the `places` of (element, node of its window) that `cut` (n, window) marks."""
    number = np.full(cut.size + 1, -1, dtype=np.int64)
    number[places] = np.arange(len(places))
    mine = np.asarray(cut.any(axis=1))
    left, right = elements.edges.left, elements.edges.right
    chosen = np.flatnonzero(mine[left] & mine[right] & elements.passable)
    first, second = left[chosen], right[chosen]
    shift = cell[first] - cell[second] + 1
    rows = first[:, None] * lattice.window + np.arange(lattice.window)
    slot = _same_node(lattice)[shift[:, 0], shift[:, 1]]
    columns = np.where(slot < 0, cut.size, second[:, None] * lattice.window + slot)
    rows, columns = number[rows], number[columns]
    joined = (rows >= 0) & (columns >= 0)
    return connected(len(places), rows[joined], columns[joined])


def _same_node(lattice: Lattice) -> Ints:
    """Place in the window of a cell of each node in that of a cell up to one further on, -1 if none: (3, 3, window)."""
    side = 2 * lattice.reach
    shift = np.arange(-1, 2)[:, None] + np.arange(side)
    x, y = shift[:, None, :, None], shift[None, :, None, :]
    inside = (x >= 0) & (x < side) & (y >= 0) & (y < side)
    return np.where(inside, x * side + y, -1).reshape(3, 3, -1)
