"""Pieces: outlines, cracks and their extensions, cut wherever they cross the side of a tile.

A crossing is rounded once, for both tiles, and the same for equal segments whichever way they run. Sides of tiles lie
on the grid, so rounding takes no piece out of its closed tile: each tile can be cut by its own pieces alone.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from crackgrow.arrays import Bools, Floats, Ints
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
    for crossings in _crossings(ends, tiles):
        t, place = crossings.places(ends)
        owner.append(crossings.segment)
        share.append(t)
        points.append(place)
    segment, along = np.concatenate(owner), np.concatenate(share)
    order = np.lexsort((np.where(turned[segment], -along, along), segment))
    places, segment = on_grid(np.concatenate(points))[order], segment[order]
    is_piece = (segment[1:] == segment[:-1]) & np.any(places[1:] != places[:-1], axis=1)
    first = np.flatnonzero(is_piece)
    return Pieces(places, first, segment[first])


@dataclass(frozen=True, slots=True, eq=False)
class _Crossings:
    """Where segments cross lines between squares."""

    segment: Ints  # (k,)
    axis: Ints  # (k,) that the line is across
    at: Floats  # (k,) its coordinate on this axis

    def places(self, ends: Floats) -> tuple[Floats, Floats]:
        """Shares (k,) of the segments with these ends (n, 2, 2), and points (k, 2)."""
        start, rows = ends[self.segment, 0], np.arange(len(self.segment))
        step = ends[self.segment, 1] - start
        t = (self.at - start[rows, self.axis]) / step[rows, self.axis]
        places = start + t[:, None] * step
        places[rows, self.axis] = self.at
        return t, places


@dataclass(frozen=True, slots=True, eq=False)
class _Parts:
    """Parts of segments, each between two shares of its length."""

    ends: Floats  # (n, 2, 2) of all segments
    segment: Ints  # (m,)
    begin: Floats  # (m,)
    end: Floats  # (m,)

    def beside(self, tiles: Squares) -> Ints:
        """The tiles (m, 4) round their middles, -1 for none."""
        step = self.ends[self.segment, 1] - self.ends[self.segment, 0]
        return tiles.around(self.ends[self.segment, 0] + (0.5 * (self.begin + self.end))[:, None] * step)

    def taken(self, some: Bools) -> _Parts:
        """Some (m,) of them."""
        return _Parts(self.ends, self.segment[some], self.begin[some], self.end[some])

    def divided(self, crossings: _Crossings) -> _Parts:
        """They, divided there; what lies between two parts of a segment comes with them."""
        t, _ = crossings.places(self.ends)
        owner = np.concatenate([self.segment, self.segment, crossings.segment])
        limits = np.concatenate([self.begin, self.end, t])
        order = np.lexsort((limits, owner))
        owner, limits = owner[order], limits[order]
        first = np.flatnonzero((owner[1:] == owner[:-1]) & (limits[1:] > limits[:-1]))
        return _Parts(self.ends, owner[first], limits[first], limits[first + 1])

    def halving(self, part: Ints, middles: Floats) -> _Crossings:
        """Where parts (k,) cross the lines through the `middles` (k, 2) of squares, each place once."""
        part, axis, at = np.repeat(part, 2), np.tile(np.arange(2), len(part)), middles.ravel()
        ends = self.ends[self.segment[part]]
        rows = np.arange(len(part))
        moving = np.flatnonzero(ends[rows, 0, axis] != ends[rows, 1, axis])
        part, found = part[moving], _Crossings(self.segment[part[moving]], axis[moving], at[moving])
        t, _ = found.places(self.ends)
        inside = np.flatnonzero((self.begin[part] < t) & (t < self.end[part]))
        inside = inside[np.lexsort((found.at[inside], found.axis[inside], found.segment[inside]))]
        each = (found.segment[inside], found.axis[inside], found.at[inside])
        once = inside[np.any([np.diff(values, prepend=-1) != 0 for values in each], axis=0)]
        return _Crossings(found.segment[once], found.axis[once], found.at[once])


def _crossings(ends: Floats, tiles: Squares) -> Iterator[_Crossings]:
    """Size by size of squares, from the largest on: where segments cross the lines between squares of this size.

    Smaller squares are looked at only where a part of a segment, between the lines before, runs through or along one.
    """
    size, n = int(tiles.size.max()), len(ends)
    found = _lines_between(ends.min(axis=1), ends.max(axis=1), size / QUANTA)
    yield found
    parts = _Parts(ends, np.arange(n), np.zeros(n), np.ones(n)).divided(found)
    while len(parts.segment):
        tile = parts.beside(tiles)
        smaller = (tile >= 0) & (tiles.size[tile] < size)
        middles = (tiles.low[tile[smaller]] // size + 0.5) * (size / QUANTA)
        found = parts.halving(np.nonzero(smaller)[0], np.asarray(middles, dtype=np.float64))
        yield found
        parts = parts.taken(np.asarray(smaller.any(axis=1))).divided(found)
        size //= 2


def _lines_between(low: Floats, high: Floats, size: float) -> _Crossings:
    """Where segments from `low` to `high` (n, 2) cross lines at multiples of `size`."""
    first = np.floor(low / size).astype(np.int64) + 1
    counts = np.maximum(np.ceil(high / size).astype(np.int64) - first, 0).ravel()
    segment, axis = np.divmod(np.repeat(np.arange(low.size), counts), 2)
    return _Crossings(segment, axis, np.asarray(size * spans(first.ravel(), counts), dtype=np.float64))
