"""Tiles: the rectangles between the lines of the lattice and the edges of all patches."""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import NDArray

from crackgrow.cover.lattice import Lattice
from crackgrow.geometry.tolerance import TOUCH

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]


def tile_lines(lattice: Lattice) -> tuple[Floats, Floats]:
    """Lattice coordinates of all tile lines in x and in y."""
    inner = lattice.breaks[:-1]
    x, y = (np.append((np.arange(n)[:, None] + inner).ravel(), float(n)) for n in lattice.shape)
    return x, y


def tiles_at(lattice: Lattice, points: Floats) -> Ints:
    """Tile indices (n, 2) of points (n, 2) in lattice coordinates."""
    cell = np.floor(points)
    part = np.searchsorted(lattice.breaks, points - cell, side="right") - 1
    return (cell * (len(lattice.breaks) - 1) + part).astype(np.int64)


def touched_tiles(lattice: Lattice, segments: Floats, tips: Floats) -> Bools:
    """Which tiles a segment (n, 2, 2) touches, the tiles round each tip (k, 2) included: (tiles x, tiles y) bool.

    Segments may end on the outermost tile lines.
    """
    x, y = tile_lines(lattice)
    touched = np.zeros((len(x) - 1, len(y) - 1), dtype=bool)
    if len(segments):
        samples = np.concatenate([crossings_and_middles(segment, x, y) for segment in segments])
        for dx in (-TOUCH, TOUCH):
            for dy in (-TOUCH, TOUCH):
                tiles = tiles_at(lattice, samples + np.array([dx, dy]))
                inside = np.all((tiles >= 0) & (tiles < touched.shape), axis=1)
                touched[tuple(tiles[inside].T)] = True
    for i, j in tiles_at(lattice, tips) if len(tips) else ():
        touched[max(i - 1, 0) : i + 2, max(j - 1, 0) : j + 2] = True
    return touched


def crossings_and_middles(segment: Floats, x: Floats, y: Floats) -> Floats:
    """Ends of a segment (2, 2), its crossings with the tile lines, and the middles between those."""
    start, step = segment[0], segment[1] - segment[0]
    parameters = [0.0, 1.0]
    for axis, lines in enumerate((x, y)):
        low, high = np.sort(segment[:, axis])
        between = lines[(lines > low) & (lines < high)]
        if len(between):
            parameters.extend((between - start[axis]) / step[axis])
    t = np.unique(np.clip(parameters, 0.0, 1.0))
    t = np.concatenate([t, 0.5 * (t[1:] + t[:-1])])
    return np.asarray(start + t[:, None] * step)


def tile_outlines(lattice: Lattice, tiles: Ints) -> NDArray[np.object_]:
    """Closed outlines of tiles (n, 2), as line strings."""
    x, y = tile_lines(lattice)
    i, j = tiles.T
    corners = np.stack([(x[i], y[j]), (x[i + 1], y[j]), (x[i + 1], y[j + 1]), (x[i], y[j + 1]), (x[i], y[j])])
    return np.asarray(shapely.linestrings(corners.transpose(2, 0, 1)))
