"""The uniform lattice of mathematical nodes; it matches no boundary."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from crackgrow.arrays import Floats, Ints
from crackgrow.geometry.arrangement import on_grid


@dataclass(frozen=True, slots=True, eq=False)
class Lattice:
    """Nodes at integer lattice coordinates; a mathematical patch is the square of half width `support` round its node.

    Lattice coordinates are (x - origin) / spacing. The edges of all patches cut every unit cell into tiles, so that
    a tile lies wholly inside or outside of any patch.
    """

    spacing: float  # m
    support: float  # half width of a patch, in spacings
    origin: Floats  # (2,) m, position of node (0, 0)
    shape: tuple[int, int]  # number of cells in x and y; nodes are one more
    breaks: Floats  # (k + 1,) tile lines inside a unit cell, from 0 to 1
    tile_lines: tuple[Floats, Floats]  # lattice coordinates of all tile lines in x and in y, on the arrangement's grid

    @property
    def reach(self) -> int:
        """Nodes on each side of a point, per axis, that can cover it."""
        return math.ceil(self.support)

    @property
    def offsets(self) -> Ints:
        """Nodes that can cover a point, relative to its cell's lower left node: ((2 reach)^2, 2)."""
        steps = np.arange(1 - self.reach, self.reach + 1)
        return np.stack(np.meshgrid(steps, steps, indexing="ij"), axis=-1).reshape(-1, 2)

    def to_lattice(self, points: Floats) -> Floats:
        """Lattice coordinates of points (..., 2) in metres."""
        return np.asarray((points - self.origin) / self.spacing)

    def to_metres(self, points: Floats) -> Floats:
        """Positions in metres of points (..., 2) in lattice coordinates."""
        return np.asarray(points * self.spacing + self.origin)


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
    origin = 0.5 * (lower + upper) - (below + centre_offset - np.array(offset)) * spacing
    fraction = support % 1.0
    breaks = np.unique([0.0, fraction, 1.0 - fraction if fraction else 0.0, 1.0])
    shape = (int(cells[0]), int(cells[1]))
    x, y = (on_grid(np.append((np.arange(n)[:, None] + breaks[:-1]).ravel(), float(n))) for n in shape)
    return Lattice(spacing, support, origin, shape, breaks, (x, y))
