"""Physical patches: the connected pieces into which cracks and outlines cut the mathematical patches.

A mathematical patch of whole tiles only is one physical patch. Ways are followed in the others.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from crackgrow.arrays import Bools, Floats, Ints
from crackgrow.cover.elements import Elements
from crackgrow.cover.lattice import Lattice
from crackgrow.geometry.arrangement import connected

SPECK = 1e-15
"""A patch whose weight is nowhere larger than this contributes less than round-off."""

PEEK, PEEK_WEIGHT = 0.03, 1e-10
"""Nor has a patch functions whose rock is smaller than `PEEK` spacings, with no larger weight times size than this.
Such patches a kink cuts off at their edge, where it peeks over a tile line, and they nearly depend on each other: the
compliance of contact lost its symmetry or was singular. Of 135 random kinks 2e-6 is the worst left."""


@dataclass(frozen=True, slots=True, eq=False)
class _Windows:
    """What the windows of all cells of a lattice have in common."""

    offsets: Ints  # (window, 2) nodes, counted from that of the lattice's first cell that comes first
    covers: Bools | None  # (parts, parts, window) which nodes cover each tile of a cell; None: all cover all
    same_node: Ints  # (3, 3, window) place in the window of a cell of each node in that of one up to a cell further on
    first_tile: int  # of a patch, along an axis, from that right above its node on
    n_tiles: int  # of a patch, along an axis


@lru_cache(maxsize=16)
def _windows(lattice: Lattice) -> _Windows:
    side, parts = 2 * lattice.reach, len(lattice.breaks) - 1
    middle = 0.5 * (lattice.breaks[1:] + lattice.breaks[:-1])
    along = np.abs(np.arange(1 - lattice.reach, lattice.reach + 1) - middle[:, None]) < lattice.support
    covers = (along[:, None, :, None] & along[None, :, None, :]).reshape(parts, parts, -1)
    shift = np.arange(-1, 2)[:, None] + np.arange(side)
    x, y = shift[:, None, :, None], shift[None, :, None, :]
    inside = (x >= 0) & (x < side) & (y >= 0) & (y < side)
    part, place = np.nonzero(along)
    tile = part - (place + 1 - lattice.reach) * parts
    return _Windows(
        lattice.offsets + lattice.reach - 1,
        None if covers.all() else covers,
        np.where(inside, x * side + y, -1).reshape(3, 3, -1),
        int(tile.min()),
        int(np.ptp(tile)) + 1,
    )


def physical_patches(lattice: Lattice, elements: Elements) -> tuple[Ints, Ints]:
    """Physical patch of every node of an element's window (n, window), -1 where none; node of every patch (p, 2).

    Two elements of one mathematical patch belong to the same physical patch if a way inside the patch leads from one
    to the other without crossing a crack or leaving the body. Patches are numbered along the lattice, those of one node
    by their first elements.
    """
    cell, part = np.divmod(elements.tile, len(lattice.breaks) - 1)
    windows = _windows(lattice)
    plain = _uncut_nodes(lattice, elements)
    rows = plain.shape[1]
    node = (cell[:, 0] * rows + cell[:, 1])[:, None] + (windows.offsets[:, 0] * rows + windows.offsets[:, 1])
    covers = None if windows.covers is None else windows.covers[part[:, 0], part[:, 1]]
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
    owner = np.concatenate([elements.ring_element[ring], np.arange(skipped, elements.n)])
    points = np.concatenate([elements.vertices[elements.ring_start[ring]], elements.reference[skipped:]])
    used = patch[owner]
    which, slot = np.nonzero(~sure[used])
    used = used[which, slot]
    from_node = points[which] - nodes[used]
    low, high = np.full((2, 2, len(nodes)), np.inf)
    high, deepest = -high, np.zeros(len(nodes))
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


def _uncut_nodes(lattice: Lattice, elements: Elements) -> Bools:
    """Which nodes have patches of whole tiles only, `reach` - 1 rows round the lattice included: (nodes x, nodes y).

    Whole tiles beside each other belong to the same body: where bodies meet tiles are cut.
    """
    whole = elements.whole_of_tile >= 0
    count = np.zeros((whole.shape[0] + 1, whole.shape[1] + 1), dtype=np.int64)
    count[1:, 1:] = whole.cumsum(axis=0).cumsum(axis=1)
    windows, parts = _windows(lattice), len(lattice.breaks) - 1
    ends = []
    for cells, tiles in zip(lattice.shape, whole.shape, strict=True):
        start = np.arange(1 - lattice.reach, cells + lattice.reach) * parts + windows.first_tile
        ends.append(np.minimum(np.maximum([start, start + windows.n_tiles], 0), tiles))
    (x0, x1), (y0, y1) = ends
    along = count[x1] - count[x0]
    return np.asarray(along[:, y1] - along[:, y0] == windows.n_tiles**2)


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
    slot = _windows(lattice).same_node[shift[:, 0], shift[:, 1]]
    columns = np.where(slot < 0, cut.size, second[:, None] * lattice.window + slot)
    rows, columns = number[rows], number[columns]
    joined = (rows >= 0) & (columns >= 0)
    return connected(len(places), rows[joined], columns[joined])
