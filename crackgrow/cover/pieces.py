"""Pieces: outlines, cracks and their extensions, cut wherever they cross the side of a tile.

A crossing is rounded once, for both tiles, and the same for equal segments whichever way they run. Sides of tiles lie
on the grid, so rounding takes no piece out of its closed tile: each tile can be cut by its own pieces alone.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely

from crackgrow.arrays import Floats, Ints
from crackgrow.cover.squares import QUANTA, Squares
from crackgrow.geometry.arrangement import on_grid

PARTS = 8
"""Of each segment, in whose bounding boxes tiles are looked for: that of all of it holds many that it does not meet."""


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
    owner, share, points = [np.arange(len(ends))] * 2, [np.zeros(len(ends)), np.ones(len(ends))], [*ends.swapaxes(0, 1)]
    parts = ends[:, :1] + np.linspace(0.0, 1.0, PARTS + 1)[:, None] * (ends[:, 1:] - ends[:, :1])
    near, tile = tiles.tree.query(
        shapely.linestrings(np.stack([parts[:, :-1], parts[:, 1:]], axis=2).reshape(-1, 2, 2))
    )
    near //= PARTS
    start, step = ends[near, 0].T, (ends[near, 1] - ends[near, 0]).T
    low, high = tiles.low[tile].T / QUANTA, (tiles.low[tile].T + tiles.size[tile]) / QUANTA
    for axis, at in ((0, low), (0, high), (1, low), (1, high)):
        along = 1 - axis  # of the side
        with np.errstate(divide="ignore", invalid="ignore"):
            t = (at[axis] - start[axis]) / step[axis]
            place = on_grid(start[along] + t * step[along])
        hit = np.flatnonzero((t > 0.0) & (t < 1.0) & (low[along] <= place) & (place <= high[along]))
        owner.append(near[hit])
        share.append(t[hit])
        points.append(np.stack([at[0, hit], place[hit]] if axis == 0 else [place[hit], at[1, hit]], axis=1))
    segment, t = np.concatenate(owner), np.concatenate(share)
    order = np.lexsort((np.where(turned[segment], -t, t), segment))
    places, segment = np.concatenate(points)[order], segment[order]
    first = np.flatnonzero((segment[1:] == segment[:-1]) & np.any(places[1:] != places[:-1], axis=1))
    return Pieces(places, first, segment[first])
