"""Pieces: outlines, cracks and their extensions, cut wherever they cross a tile line.

A crossing is rounded once, for both tiles, and the same for equal segments whichever way they run. Tile lines lie on
the grid, so rounding takes no piece out of its closed tile: each tile can be cut by its own pieces alone.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from crackgrow.arrays import Floats, Ints
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


def cut_in_pieces(segments: Floats, x: Floats, y: Floats) -> Pieces:
    """Cut `segments` (n, 2, 2) at the tile lines `x` (i,) and `y` (j,), all between the outermost."""
    ends = on_grid(segments)
    (x0, y0), (x1, y1) = ends[:, 0].T, ends[:, 1].T
    turned = (x0 > x1) | ((x0 == x1) & (y0 > y1))
    ends[turned] = ends[turned, ::-1]
    start, step = ends[:, 0], ends[:, 1] - ends[:, 0]
    every = np.arange(len(ends))
    owner, share, points = [every, every], [np.zeros(len(ends)), np.ones(len(ends))], [start, ends[:, 1]]
    for axis, lines in enumerate((x, y)):
        low, high = np.minimum(start, ends[:, 1])[:, axis], np.maximum(start, ends[:, 1])[:, axis]
        begin = np.searchsorted(lines, low, side="right")
        n = np.maximum(np.searchsorted(lines, high, side="left") - begin, 0)
        which = np.repeat(every, n)
        at = lines[spans(begin, n)]
        t = (at - start[which, axis]) / step[which, axis]
        place = start[which] + t[:, None] * step[which]
        place[:, axis] = at
        owner.append(which)
        share.append(t)
        points.append(place)
    segment, along = np.concatenate(owner), np.concatenate(share)
    order = np.lexsort((np.where(turned[segment], -along, along), segment))
    places, segment = on_grid(np.concatenate(points))[order], segment[order]
    is_piece = (segment[1:] == segment[:-1]) & np.any(places[1:] != places[:-1], axis=1)
    first = np.flatnonzero(is_piece)
    return Pieces(places, first, segment[first])
