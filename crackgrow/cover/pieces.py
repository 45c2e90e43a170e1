"""Pieces: outlines, cracks and their extensions, cut wherever they cross the side of a tile.

A crossing is rounded once, for both tiles, and the same for equal segments whichever way they run. Sides of tiles lie
on the grid, so rounding takes no piece out of its closed tile: each tile can be cut by its own pieces alone.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from crackgrow.arrays import Floats, Ints
from crackgrow.cover.squares import QUANTA, Squares
from crackgrow.geometry.arrangement import on_grid
from crackgrow.ragged import spans


@dataclass(frozen=True, slots=True, eq=False)
class Pieces:
    """The pieces of segments, in order along each."""

    points: Floats  # (n, 2) all their ends, on the grid; those of one segment follow each other
    first: Ints  # (p,) number of the point where a piece begins; it ends at the next one
    segment: Ints  # (p,) the segment it belongs to

    @property
    def ends(self) -> Floats:
        """Both ends (p, 2, 2)."""
        return np.asarray(self.points[self.first[:, None] + np.arange(2)])


def cut_in_pieces(segments: Floats, tiles: Squares) -> Pieces:
    """Cut `segments` (n, 2, 2), all inside of the tiles, at the sides of these."""
    ends = on_grid(segments)
    (x0, y0), (x1, y1) = ends[:, 0].T, ends[:, 1].T
    turned = (x0 > x1) | ((x0 == x1) & (y0 > y1))
    ends[turned] = ends[turned, ::-1]
    every = np.arange(len(ends))
    owner = [every, every]
    share, points = [np.zeros(len(ends)), np.ones(len(ends))], [ends[:, 0], ends[:, 1]]
    for which, axis, at in _crossings(ends, tiles):
        t, place = _places(ends, which, axis, at)
        owner.append(which)
        share.append(t)
        points.append(place)
    segment, along = np.concatenate(owner), np.concatenate(share)
    order = np.lexsort((np.where(turned[segment], -along, along), segment))
    places, segment = on_grid(np.concatenate(points))[order], segment[order]
    is_piece = (segment[1:] == segment[:-1]) & np.any(places[1:] != places[:-1], axis=1)
    first = np.flatnonzero(is_piece)
    return Pieces(places, first, segment[first])


def _places(ends: Floats, which: Ints, axis: Ints, at: Floats) -> tuple[Floats, Floats]:
    """Where segments `which` (k,) of `ends` (n, 2, 2) cross lines at `at` (k,): share (k,), point (k, 2)."""
    start, step, rows = ends[which, 0], ends[which, 1] - ends[which, 0], np.arange(len(which))
    t = (at - start[rows, axis]) / step[rows, axis]
    places = start + t[:, None] * step
    places[rows, axis] = at
    return t, places


def _crossings(ends: Floats, tiles: Squares) -> Iterator[tuple[Ints, Ints, Floats]]:
    """Size by size of squares, from the largest on: segments (k,), axes (k,) and coordinates (k,) at which they cross
    the lines between squares of this size.

    Smaller squares are looked at only where a part of a segment, between the lines before, runs through or along one.
    """
    size = int(tiles.size.max())
    found = _lines_between(ends.min(axis=1), ends.max(axis=1), size / QUANTA)
    yield found
    every = np.arange(len(ends))
    owner, begin, end = _divided(ends, every, np.zeros(len(ends)), np.ones(len(ends)), *found)
    while len(owner):
        tile = tiles.around(ends[owner, 0] + (0.5 * (begin + end))[:, None] * (ends[owner, 1] - ends[owner, 0]))
        smaller = (tile >= 0) & (tiles.size[tile] < size)
        part, column = np.nonzero(smaller)
        square = tiles.low[tile[part, column]] // size
        part, axis = np.repeat(part, 2), np.tile(np.arange(2), len(part))
        at = np.asarray((square + 0.5) * (size / QUANTA), dtype=np.float64).ravel()
        moving = np.flatnonzero(ends[owner[part], 0, axis] != ends[owner[part], 1, axis])
        part, axis, at = part[moving], axis[moving], at[moving]
        t, _ = _places(ends, owner[part], axis, at)
        inside = (begin[part] < t) & (t < end[part])
        lines = np.unique(np.column_stack([owner[part], axis, at])[inside], axis=0)
        found = lines[:, 0].astype(np.int64), lines[:, 1].astype(np.int64), lines[:, 2]
        yield found
        some = smaller.any(axis=1)
        owner, begin, end = _divided(ends, owner[some], begin[some], end[some], *found)
        size //= 2


def _lines_between(low: Floats, high: Floats, size: float) -> tuple[Ints, Ints, Floats]:
    """Boxes (k,), axes (k,) and coordinates (k,) of multiples of `size` between `low` and `high` (n, 2)."""
    first = np.floor(low / size).astype(np.int64) + 1
    counts = np.maximum(np.ceil(high / size).astype(np.int64) - first, 0).ravel()
    which, axis = np.divmod(np.repeat(np.arange(low.size), counts), 2)
    return which, axis, np.asarray(size * spans(first.ravel(), counts), dtype=np.float64)


def _divided(
    ends: Floats, owner: Ints, begin: Floats, end: Floats, which: Ints, axis: Ints, at: Floats
) -> tuple[Ints, Floats, Floats]:
    """Parts of segments, by owner (m,) and shares, divided where segments `which` (k,) cross lines at `at` (k,).

    What lies between two parts of a segment comes with them.
    """
    t, _ = _places(ends, which, axis, at)
    owners, limits = np.concatenate([owner, owner, which]), np.concatenate([begin, end, t])
    order = np.lexsort((limits, owners))
    owners, limits = owners[order], limits[order]
    first = np.flatnonzero((owners[1:] == owners[:-1]) & (limits[1:] > limits[:-1]))
    return owners[first], limits[first], limits[first + 1]
