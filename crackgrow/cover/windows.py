"""Windows: the nodes over a tile, as they lie round its cell, in sides of the cell.

Tiles with equal windows have equal functions, whatever their size. Where all cells round a tile are of its size the
window is the regular one: whole numbers of sides, and one half width.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from crackgrow.arrays import Floats, Ints
from crackgrow.cover.cells import Nodes, Tiles
from crackgrow.cover.squares import Squares

REGULAR = 0
"""Number of the regular window."""

FAR = 1e9
"""Where a window has fewer nodes than the largest one: no point of the cell is near."""


@dataclass(frozen=True, slots=True, eq=False)
class Windows:
    """The windows of all tiles; k is the largest number of nodes."""

    of_tile: Ints  # (tiles,) number of the window
    slot: Ints  # (q,) which place of the window each of the nodes over each tile has
    nodes: Floats  # (windows, k, 2)
    half: Floats  # (windows, k) half widths of their patches
    counts: Ints  # (windows,) number of nodes; what follows them is far away


def regular_window(support: float) -> Floats:
    """Nodes ((2 reach)^2, 2) that can cover a cell, from its lower left corner, x by x."""
    reach = math.ceil(support)
    steps = np.arange(1 - reach, reach + 1, dtype=float)
    return np.stack(np.meshgrid(steps, steps, indexing="ij"), axis=-1).reshape(-1, 2)


def windows_of(cells: Squares, nodes: Nodes, tiles: Tiles, support: float) -> Windows:
    """The windows of all tiles."""
    over = tiles.over
    tile, node = over.row, over.values
    window, reach = regular_window(support), math.ceil(support)
    cell = tiles.cell[tile]
    size, off, half = cells.size[cell], nodes.places[node] - cells.low[cell], nodes.half[node]
    odd = (off % size[:, None] != 0).any(axis=1) | (half != np.rint(support * size))
    irregular = (np.bincount(tile[odd], minlength=over.n) > 0) | (over.counts != _of_regular(cells, tiles, support))
    step = off // size[:, None] + reach - 1
    slot = np.where(irregular[tile], np.arange(len(tile)) - over.start[tile], step[:, 0] * 2 * reach + step[:, 1])
    some = np.flatnonzero(irregular)
    found = np.full((len(some) + 1, max(len(window), int(over.counts[some].max(initial=0))), 3), FAR)
    found[:, :, 2] = 1.0
    found[0, : len(window)] = np.column_stack([window, np.full(len(window), support)])
    at = np.flatnonzero(irregular[tile])
    row = 1 + np.searchsorted(some, tile[at])
    found[row, slot[at]] = np.column_stack([off[at], half[at]]) / size[at, None]
    numbers: dict[bytes, int] = {}
    number = np.array([numbers.setdefault(window.tobytes(), len(numbers)) for window in found], dtype=np.int64)
    different = found[np.unique(number, return_index=True)[1]]
    of_tile = np.full(over.n, REGULAR)
    of_tile[some] = number[1:]
    counts = np.count_nonzero(different[:, :, 0] < FAR, axis=1)
    return Windows(of_tile, slot, different[:, :, :2], different[:, :, 2], counts)


def _of_regular(cells: Squares, tiles: Tiles, support: float) -> Ints:
    """How many nodes of the regular window cover each tile (n,)."""
    low, size = tiles.squares.low, tiles.squares.size
    middle = (low + 0.5 * size[:, None] - cells.low[tiles.cell]) / cells.size[tiles.cell, None]
    steps = np.arange(-math.ceil(support), math.ceil(support) + 2)
    return np.asarray(np.prod(np.count_nonzero(np.abs(steps - middle[:, :, None]) < support, axis=2), axis=1))
