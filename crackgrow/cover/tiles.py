"""Tiles: the rectangles between the lines of the lattice and the edges of all patches."""

from __future__ import annotations

import numpy as np

from crackgrow.arrays import Bools, Floats, Ints
from crackgrow.cover.lattice import Lattice
from crackgrow.geometry.tolerance import TOUCH

_TOUCHING = TOUCH * np.array([(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)])


def tiles_at(lattice: Lattice, points: Floats) -> Ints:
    """Tile indices (n, 2) of points (n, 2) in lattice coordinates."""
    cell = np.floor(points)
    part = np.searchsorted(lattice.breaks, points - cell, side="right") - 1
    return (cell * (len(lattice.breaks) - 1) + part).astype(np.int64)


def touched_tiles(lattice: Lattice, samples: Floats, tips: Floats) -> Bools:
    """Which tiles one of `samples` (n, 2) touches, the tiles round each tip (k, 2) included: (tiles x, tiles y) bool.

    Samples may lie on the outermost tile lines.
    """
    parts = len(lattice.breaks) - 1
    touched = np.zeros((lattice.shape[0] * parts, lattice.shape[1] * parts), dtype=bool)
    tiles = tiles_at(lattice, (samples + _TOUCHING[:, None]).reshape(-1, 2))
    inside = np.all((tiles >= 0) & (tiles < touched.shape), axis=1)
    touched[tuple(tiles[inside].T)] = True
    for i, j in tiles_at(lattice, tips).tolist():
        touched[max(i - 1, 0) : i + 2, max(j - 1, 0) : j + 2] = True
    return touched
