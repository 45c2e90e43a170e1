"""Lengths along a surface in cells: what counts spacings on equal cells counts the cells that are there.

With h(s) the side of the cells beside a surface at the arc length s, the larger of those on its two faces,

    xi(s) = integral of ds / h(s).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from crackgrow.arrays import Floats
from crackgrow.cover.face_edges import FaceEdges


@dataclass(frozen=True, slots=True, eq=False)
class CellLengths:
    """xi along one surface, from its start: piecewise linear."""

    s: Floats  # (k,) arc lengths of both ends, and between them of the places where h changes, lattice units
    cells: Floats  # (k,) xi there

    @property
    def total(self) -> float:
        """Length of the surface, cells."""
        return float(self.cells[-1])

    def at(self, s: Floats) -> Floats:
        """The lengths xi (n,) from the start to arc lengths s (n,)."""
        return np.interp(s, self.s, self.cells)

    def place(self, cells: Floats) -> Floats:
        """The arc lengths s (n,) at which the lengths from the start are `cells` (n,)."""
        return np.interp(cells, self.cells, self.s)

    def size(self, s: Floats) -> Floats:
        """Side (n,) of the cells round arc lengths s (n,), lattice units: the mean along one cell, half of it each way.

        Where cells of two sizes meet it must not matter which end of the surface is its start.
        """
        xi = self.at(s)
        low, high = np.maximum(xi - 0.5, 0.0), np.minimum(xi + 0.5, self.total)
        return np.asarray((self.place(high) - self.place(low)) / (high - low))


def sizes_beside(edges: FaceEdges, sizes: Floats) -> Floats:
    """Side (n,) of the cells beside each edge, of the larger on its two faces; `sizes` (elements,) are all sides."""
    minus = np.where(edges.minus >= 0, sizes[edges.minus], 0.0)  # a foundation has none
    return np.maximum(sizes[edges.plus], minus)


def cell_lengths(length: float, edges: FaceEdges, size: Floats) -> CellLengths:
    """Lengths along a surface of this arc length, beside whose `edges` (e,) cells have a `size` (e,)."""
    first = np.concatenate([[0], np.flatnonzero(np.diff(size)) + 1])  # edges of each part with cells of one size
    s = np.concatenate([[0.0], edges.s[first[1:], 0], [length]])
    cells = np.concatenate([[0.0], np.cumsum(np.diff(s) / size[first])])
    return CellLengths(s, cells)
