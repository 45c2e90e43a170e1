"""Which cells are divided: those near a place that asks for smaller ones, then neighbours, until none is more than
twice as large as another that it touches.

A quadtree balanced so keeps patches of like size beside each other: all nodes over a point have half widths within a
factor of four.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import shapely
from numpy.typing import NDArray

from crackgrow.arrays import Floats, Ints
from crackgrow.cover.lattice import Lattice, lattice_of
from crackgrow.cover.squares import QUANTA, Squares, quarters_of, squares_of
from crackgrow.geometry.tolerance import TOUCH

MOST_LEVELS = 15
"""Halvings of the largest cells: `QUANTA` leaves room for them, for quartered cells and for quarters of supports."""


@dataclass(frozen=True, slots=True, eq=False)
class SizeField:
    """A mesh size field: places, and the largest cells that they allow."""

    shapes: NDArray[np.object_]  # (n,) geometries, lattice coordinates
    size: Floats  # (n,) the largest cells that they allow at the place, spacings
    rings: Floats  # (n,) cells of each size round the place


def refined(lattice: Lattice, field: SizeField, *, quartered: bool = False) -> Lattice:
    """The lattice with `divided` cells, each `quartered` if that is asked for; itself where they are the same."""
    cells = divided(lattice, field)
    cells = cells.quartered() if quartered else cells
    if cells.equal(lattice.cells):
        return lattice
    finer = lattice_of(lattice.spacing, lattice.support, lattice.origin, cells)
    return replace(finer, map_origin=lattice.map_origin)


def divided(lattice: Lattice, field: SizeField) -> Squares:
    """The cells of a lattice, divided where `field` asks for that, some cells of each size round every place.

    A cell is divided if a place no farther than its rings of the cell's sides, along both axes, asks for smaller ones.
    Just at that distance it is, whatever rounding makes of it: symmetric scenes have symmetric cells, and no larger
    patches hold a tip within rounding of a corner, if it has as many rings as the support. Sizes that differ by
    rounding are equal: a scene in other units has the same cells.
    """
    if not len(field.size):
        return lattice.cells
    each = field.rings
    classes = [(n, shapely.STRtree(field.shapes[each == n]), field.size[each == n]) for n in np.unique(each).tolist()]
    fixed: list[tuple[Ints, Ints]] = []
    low, size = lattice.cells.low, lattice.cells.size
    least = max(float(field.size.min()) * QUANTA, QUANTA / 2**MOST_LEVELS)
    while len(size):
        side = size / QUANTA
        x, y = (low / QUANTA).T
        asked = np.zeros(len(size), dtype=bool)
        for rings, tree, depth in classes:
            room = (rings + TOUCH) * side
            cell, place = tree.query(shapely.box(x - room, y - room, x + side + room, y + side + room), "intersects")
            asked[cell[depth[place] < (1.0 - TOUCH) * side[cell]]] = True
        asked &= size > least
        fixed.append((low[~asked], size[~asked]))
        low, size = quarters_of(low[asked], size[asked])
    return balanced(squares_of(*(np.concatenate(arrays) for arrays in zip(*fixed, strict=True))))


def balanced(cells: Squares) -> Squares:
    """The cells, divided where one is more than twice as large as another that it touches, corners included."""
    steps = np.array([(x, y) for x in (-1, 0, 1) for y in (-1, 0, 1) if (x, y) != (0, 0)])
    while True:
        around = cells.low[:, None] + np.where(steps > 0, cells.size[:, None, None], steps)  # a place in each neighbour
        neighbour = cells.at(around.reshape(-1, 2)).reshape(around.shape[:2])
        large = (neighbour >= 0) & (cells.size[neighbour] > 2 * cells.size[:, None])
        if not large.any():
            return cells
        is_large = np.zeros(cells.n, dtype=bool)
        is_large[neighbour[large]] = True
        quarters = quarters_of(cells.low[is_large], cells.size[is_large])
        cells = squares_of(
            *(np.concatenate([a[~is_large], b]) for a, b in zip((cells.low, cells.size), quarters, strict=True))
        )
