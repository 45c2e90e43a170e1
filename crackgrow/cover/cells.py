"""Cells of several sizes: their corners are the nodes, and the edges of patches cut them into tiles.

A node's patch is the square round it with `support` times the side of the largest cell that touches the node as its
half width: with the smallest one there would be gaps between patches. Corners that lie on the side of a larger cell are
no nodes: patches of one size half a cell apart depend on each other (the cubic splines among them, taken with signs in
turn, add up to zero).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from crackgrow.arrays import Floats, Ints
from crackgrow.cover.squares import QUANTA, Squares, quarters_of, squares_of
from crackgrow.geometry.arrangement import as_complex
from crackgrow.ragged import Ragged, by_row, distinct, spans


@dataclass(frozen=True, slots=True, eq=False)
class Nodes:
    """Nodes from left to right and upwards, in quanta."""

    places: Ints  # (n, 2)
    half: Ints  # (n,) half widths of their patches
    largest: Ints  # (n,) the largest cell that touches each


@dataclass(frozen=True, slots=True, eq=False)
class Tiles:
    """Tiles: squares that no edge of a patch crosses."""

    squares: Squares
    cell: Ints  # (tiles,) the cell that each is a part of
    over: Ragged  # tiles -> the nodes, ascending, whose patches hold them
    corners: NDArray[np.complex128]  # (v,) of all tiles, from left to right and upwards, spacings
    ring: Ragged  # tiles -> corners on their rims, those of smaller neighbours too, from the lower left one to the left
    following: Ints  # (places of `ring`,) the next corner

    @property
    def points(self) -> Floats:
        """The corners (v, 2)."""
        return np.stack([self.corners.real, self.corners.imag], axis=1)


def nodes_of(cells: Squares, support: float) -> Nodes:
    """The nodes of cells."""
    corners = cells.corners
    around = cells.around(corners / QUANTA)
    off, there = corners[:, None] - cells.low[around], around >= 0
    is_corner = ((off == 0) | (off == cells.size[around, None])).all(axis=2)
    nodes = (is_corner | ~there).all(axis=1)
    largest = np.where(there, cells.size[around], 0).max(axis=1)[nodes]
    return Nodes(corners[nodes], np.rint(support * largest).astype(np.int64), largest)


def tiles_of(cells: Squares, nodes: Nodes, support: float) -> Tiles:
    """The tiles of cells with these nodes."""
    parts = np.full(cells.n, QUANTA // math.gcd(round(QUANTA * support), QUANTA), dtype=np.int64)
    squares = _squares_of_patches(nodes)
    if len(np.unique(cells.size)) > 1:
        cell, off = _crossings(cells, nodes, *squares)
        np.maximum.at(parts, cell, cells.size[cell] // np.gcd(off, cells.size[cell]))
    low, size, number = cells.low, cells.size, np.arange(cells.n)
    done = []
    while len(size):
        whole = parts[number] * size == cells.size[number]
        done.append((low[whole], size[whole], number[whole]))
        (low, size), number = quarters_of(low[~whole], size[~whole]), np.repeat(number[~whole], 4)
    low, size, number = (np.concatenate(arrays) for arrays in zip(*done, strict=True))
    order = np.lexsort((low[:, 1], low[:, 0]))
    tiles = squares_of(low, size)
    corners = tiles.corners
    ring, following = _rings(tiles, corners)
    return Tiles(tiles, number[order], _covering(tiles, *squares), as_complex(corners / QUANTA), ring, following)


def _squares_of_patches(nodes: Nodes) -> tuple[Ints, Ints, Ints]:
    """The squares that patches are made of, as large as the tree has: of each node (k,), corner (k, 2), side (k,)."""
    low, width = nodes.places - nodes.half[:, None], 2 * nodes.half
    side = np.gcd(np.gcd(low[:, 0], low[:, 1]), width)
    side &= -side
    across = width // side
    node = np.repeat(np.arange(len(width)), across**2)
    steps = np.stack(np.divmod(spans(np.zeros_like(across), across**2), across[node]), axis=1)
    return node, low[node] + side[node, None] * steps, side[node]


def _covering(tiles: Squares, node: Ints, low: Ints, side: Ints) -> Ragged:
    """The nodes, ascending, whose patches hold each tile: those inside of the squares of patches, and round these."""
    inside = tiles.within(low, side)
    none = np.flatnonzero(inside.counts == 0)
    holding = tiles.at(low[none])
    there = holding >= 0
    tile, over = (
        np.concatenate(pair) for pair in ((inside.values, holding[there]), (node[inside.row], node[none[there]]))
    )
    n = int(node[-1]) + 1
    of_tile, of_node = np.divmod(distinct(tile * n + over), n)
    return by_row(of_tile, of_node, tiles.n)


def _crossings(cells: Squares, nodes: Nodes, node: Ints, low: Ints, side: Ints) -> tuple[Ints, Ints]:
    """Cells (m,) that edges of patches cross, larger than squares of these, and how far (m,) from their low corners."""
    cell = cells.at(low)
    larger = np.flatnonzero((cell >= 0) & (cells.size[cell] > side))
    cell, node = cell[larger], node[larger]
    begin = nodes.places[node] - nodes.half[node, None] - cells.low[cell]
    off = np.concatenate([begin, begin + 2 * nodes.half[node, None]], axis=1)
    which, edge = np.nonzero((off > 0) & (off < cells.size[cell, None]))
    return cell[which], off[which, edge]


def _rings(tiles: Squares, corners: Ints) -> tuple[Ragged, Ints]:
    """The corners (v, 2) on the rims of tiles, counter-clockwise from the lower left, and what follows each."""
    around = np.sort(tiles.around(corners / QUANTA), axis=1)
    around[:, 1:][around[:, 1:] == around[:, :-1]] = -1
    corner, column = np.nonzero(around >= 0)
    tile = around[corner, column]
    along = along_rim(corners[corner] - tiles.low[tile], tiles.size[tile])
    order = np.lexsort((along, tile))
    ring = by_row(tile[order], corner[order], tiles.n)
    following = np.roll(ring.values, -1)
    following[ring.start[1:] - 1] = ring.values[ring.start[:-1]]
    return ring, following


def along_rim(off: Floats | Ints, size: Floats | Ints) -> Floats | Ints:
    """How far (n,) round squares of `size` (n,) points on their rims are, from the lower left corner; `off` (n, 2)."""
    x, y = off.T
    found: Floats | Ints = np.select([y == 0, x == size, y == size], [x, size + y, 3 * size - x], 4 * size - y)
    return found
