"""Windows: the nodes over a tile, as they lie round its cell.

Where all cells round a tile are of its size the window is the regular one: nodes whole numbers of sides away, and one
half width. Tiles at the same place of their cells then have equal functions, whatever their size.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from crackgrow.arrays import Bools, Floats, Ints
from crackgrow.cover.cells import Nodes, Tiles
from crackgrow.cover.squares import Squares


@dataclass(frozen=True, slots=True, eq=False)
class Windows:
    """The windows of all tiles."""

    regular: Bools  # (tiles,) which are the regular one
    slot: Ints  # (q,) which place of its window each of the nodes over each tile has


def regular_window(support: float) -> Floats:
    """Nodes ((2 reach)^2, 2) that can cover a cell, from its lower left corner, x by x."""
    reach = math.ceil(support)
    steps = np.arange(1 - reach, reach + 1, dtype=float)
    return np.stack(np.meshgrid(steps, steps, indexing="ij"), axis=-1).reshape(-1, 2)


def windows_of(cells: Squares, nodes: Nodes, tiles: Tiles, support: float) -> Windows:
    """The windows of all tiles."""
    over = tiles.over
    tile, node = over.row, over.values
    reach = math.ceil(support)
    cell = tiles.cell[tile]
    size, off, half = cells.size[cell], nodes.places[node] - cells.low[cell], nodes.half[node]
    odd = (off % size[:, None] != 0).any(axis=1) | (half != np.rint(support * size))
    irregular = (np.bincount(tile[odd], minlength=over.n) > 0) | (over.counts != _of_regular(cells, tiles, support))
    step = off // size[:, None] + reach - 1
    slot = np.where(irregular[tile], np.arange(len(tile)) - over.start[tile], step[:, 0] * 2 * reach + step[:, 1])
    return Windows(~irregular, slot)


def _of_regular(cells: Squares, tiles: Tiles, support: float) -> Ints:
    """How many nodes of the regular window cover each tile (n,)."""
    low, size = tiles.squares.low, tiles.squares.size
    middle = (low + 0.5 * size[:, None] - cells.low[tiles.cell]) / cells.size[tiles.cell, None]
    steps = np.arange(-math.ceil(support), math.ceil(support) + 2)
    return np.asarray(np.prod(np.count_nonzero(np.abs(steps - middle[:, :, None]) < support, axis=2), axis=1))
