"""The lattice of mathematical nodes; it matches no boundary."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from crackgrow.arrays import Floats, Ints
from crackgrow.case.units import Metres
from crackgrow.cover.cells import Nodes, Tiles, nodes_of, tiles_of
from crackgrow.cover.squares import QUANTA, Squares, squares_of
from crackgrow.errors import GeometryError

MOST_ACROSS = 2**13
"""Cells along a side: their quanta, two together, are numbers of 64 bits."""


@dataclass(frozen=True, slots=True, eq=False)
class Lattice:
    """Square cells with nodes at their corners; a mathematical patch is a square round its node.

    Lattice coordinates are (x - origin) / spacing. The edges of all patches cut the cells into tiles, so that a tile
    lies wholly inside or outside of any patch.
    """

    spacing: float  # m, side of the largest cells
    support: float  # half width of a patch, in sides of the largest cell at its node
    origin: Floats  # (2,) m, position of the lower left corner
    shape: tuple[int, int]  # spacings in x and y
    cells: Squares
    nodes: Nodes
    tiles: Tiles
    map_origin: tuple[float, float] = (0.0, 0.0)  # m, on the map that the scene comes from

    @property
    def tile_low(self) -> Floats:
        """Lower left corners (tiles, 2)."""
        return np.asarray(self.tiles.squares.low / QUANTA)

    @property
    def tile_size(self) -> Floats:
        """Sides (tiles,) of the tiles, spacings."""
        return np.asarray(self.tiles.squares.size / QUANTA)

    def tiles_at(self, points: Floats) -> Ints:
        """The tile (n,) that each of `points` (n, 2) lies in, the upper right one of several; -1 for none."""
        return self.tiles.squares.at(np.floor(points * QUANTA).astype(np.int64))

    def to_lattice(self, points: Floats) -> Floats:
        """Lattice coordinates of points (..., 2) in metres."""
        return np.asarray((points - self.origin) / self.spacing)

    def to_metres(self, points: Floats) -> Floats:
        """Positions in metres of points (..., 2) in lattice coordinates."""
        return np.asarray(points * self.spacing + self.origin)

    def to_map(self, points: Floats) -> Floats:
        """The same on the map, for what is told of places."""
        return self.to_metres(points) + self.map_origin


def place_lattice(
    lower: Floats, upper: Floats, spacing: float, support: float, offset: tuple[float, float] = (0.0, 0.0)
) -> Lattice:
    """Lattice of `spacing` (m) over the box from `lower` to `upper` (2,) (m).

    Its centre is a node or the centre of a cell, per axis, whichever leaves the box's sides nearer to the middle of
    a cell: the scene's symmetries are the lattice's, and no patch overlaps the body by a sliver only. `offset` moves
    it from there, by parts of a spacing between -1/2 and 1/2: where it lies must not matter.
    """
    reach = math.ceil(support)
    half = 0.5 * (upper - lower) / spacing
    centre_offset = np.where(np.abs(half % 1.0 - 0.5) <= np.abs((half + 0.5) % 1.0 - 0.5), 0.0, 0.5)
    below = np.ceil(half - centre_offset).astype(int) + reach  # whole cells from the box's centre to the lattice's edge
    cells = 2 * below + (2 * centre_offset).astype(int)
    if cells.max() > MOST_ACROSS:
        wide = f"the specimen is {cells.max():,} cells of {Metres(spacing):.4g} wide or high"
        raise GeometryError(f"{wide}, and at most {MOST_ACROSS:,} have places: use a larger numerics.spacing")
    origin = 0.5 * (lower + upper) - (below + centre_offset - np.array(offset)) * spacing
    places = np.stack(np.meshgrid(*map(np.arange, cells.tolist()), indexing="ij"), axis=-1).reshape(-1, 2)
    return lattice_of(spacing, support, origin, squares_of(QUANTA * places, np.full(len(places), QUANTA)))


def lattice_of(spacing: float, support: float, origin: Floats, cells: Squares) -> Lattice:
    """The lattice of cells whose lower left corner is `origin` (2,) m."""
    nodes = nodes_of(cells, support)
    tiles = tiles_of(cells, nodes, support)
    width, height = ((cells.low + cells.size[:, None]).max(axis=0) // QUANTA).tolist()
    return Lattice(spacing, support, origin, (width, height), cells, nodes, tiles)
