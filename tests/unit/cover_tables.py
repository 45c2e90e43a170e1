"""What a cover lists, as tables of everything by everything: the plain form that tests compare with."""

from __future__ import annotations

import math

import numpy as np
import shapely
from scipy.sparse import csr_array

from crackgrow.approximation.basis import Basis
from crackgrow.cover.cover import Cover
from crackgrow.cover.elements import Elements
from crackgrow.cover.lattice import Lattice
from crackgrow.cover.squares import QUANTA


def patch_table(cover: Cover) -> np.ndarray:
    """Physical patch (elements, nodes) of every node round an element's cell, -1 for none; of cells of one size."""
    of_element, reach = cover.patches.of_element, math.ceil(cover.lattice.support)
    step = (cover.patches.nodes[of_element.values] - cells_of(cover)[of_element.row]).astype(int) + reach - 1
    table = np.full((of_element.n, (2 * reach) ** 2), -1)
    table[of_element.row, 2 * reach * step[:, 0] + step[:, 1]] = of_element.values
    return table


def cells_of(cover: Cover) -> np.ndarray:
    """Lower left corners (elements, 2) of the cells that elements lie in, spacings."""
    return cover.lattice.cells.low[cover.lattice.tiles.cell[cover.elements.tile]] / QUANTA


def function_table(cover: Cover) -> np.ndarray:
    """First of the four functions of every tip on every patch (tips, n_patches), -1 for none."""
    table = np.full((len(cover.tips), len(cover.patches.nodes)), -1)
    for row, tip in zip(table, cover.tips, strict=True):
        row[tip.patches] = tip.functions
    return table


def tile_boxes(lattice: Lattice, tiles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Lower left and upper right corners (n, 2) of tiles (n,)."""
    low = lattice.tile_low[tiles]
    return low, low + lattice.tile_size[tiles, None]


def areas(lattice: Lattice, elements: Elements) -> np.ndarray:
    """Areas (n,) of all elements, squared spacings."""
    whole = lattice.tile_size[elements.tile[: elements.n_whole]] ** 2
    return np.concatenate([whole, shapely.area(elements.polygons)])


def gradient_rows(basis: Basis) -> tuple[csr_array, csr_array]:
    """The derivatives (n, n_functions) by x and by y of all functions at the points of a basis; zeros stay entries."""
    shape = basis.rows.shape
    by_x, by_y = (csr_array((values, basis.functions, basis.start), shape=shape) for values in basis.values[1:])
    return by_x, by_y
