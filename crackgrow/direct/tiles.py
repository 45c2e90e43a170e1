"""Tiles of large dense matrices that are symmetric: of their lower triangle one after the other, each in cache."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from crackgrow.arrays import Floats

TILE = 256
"""Rows and columns of a tile."""


def lower_tiles(k: int) -> Iterator[tuple[slice, slice]]:
    """Rows and columns of the tiles that the lower triangle of a matrix (k, k) has a part in."""
    for first in range(0, k, TILE):
        for before in range(0, first + 1, TILE):
            yield slice(first, first + TILE), slice(before, before + TILE)


def mirror(lower: Floats) -> None:
    """Make a matrix (k, k) symmetric to the last bit by its lower triangle."""
    for rows, columns in lower_tiles(len(lower)):
        tile = lower[rows, columns]
        if rows == columns:
            tile[...] = np.tril(tile) + np.tril(tile, -1).T
        else:
            lower[columns, rows] = tile.T
