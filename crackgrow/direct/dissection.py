"""Nested dissection of the lattice: the order in which unknowns are eliminated, the same for a whole run.

Unknowns sit on nodes of the lattice and are coupled only if their nodes are at most `reach` apart along both axes. So a
band `reach` nodes wide separates what lies on its two sides, and is eliminated after both (George 1973). Bands lie on
lines one `PERIOD` apart, so that most boxes between them are translations of each other and have equal factors.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from crackgrow.arrays import Ints

PERIOD = 12
"""Nodes from one band to the next. A multiple of `clusters.BLOCK`: clusters then lie alike in all boxes."""

TREES = 4
"""So many dissections are remembered."""


@dataclass(frozen=True, slots=True, eq=False)
class Places:
    """Where unknowns are on a lattice; those whose nodes are further than `reach` apart on an axis aren't coupled."""

    nodes: Ints  # (n, 2), from (0, 0) on
    shape: tuple[int, int]  # nodes of the lattice along x and y
    reach: int


@dataclass(frozen=True, slots=True, eq=False)
class Box:
    """A rectangle of nodes, and the band that separates it, or all of it where none does.

    The nodes eliminated in it have the ranks `begin` to `end`, those of its band `band` to `end`.
    """

    low: tuple[int, int]  # its first node, outside of the lattice for boxes that overlap its rim
    begin: int
    band: int
    end: int
    around: tuple[slice, slice]  # nodes of the box and those within reach of it


@dataclass(frozen=True, slots=True, eq=False)
class Dissection:
    """The tree of boxes, children before parents."""

    rank: Ints  # (nx, ny) place of each node in the order of elimination
    boxes: tuple[Box, ...]
    parent: Ints  # (boxes,), -1 for none
    begin: Ints  # (boxes,) of the boxes
    band: Ints
    end: Ints
    rings: dict[int, Ints]  # by box, found when needed

    def ring(self, number: int) -> Ints:
        """Ranks (k,), ascending, of the nodes outside of a box within reach of it: all are eliminated later."""
        if number not in self.rings:
            ranks = self.rank[self.boxes[number].around].ravel()
            self.rings[number] = np.sort(ranks[ranks >= self.boxes[number].end])
        return self.rings[number]


@lru_cache(maxsize=TREES)
def dissect(shape: tuple[int, int], reach: int) -> Dissection:
    """Dissection of a lattice of `shape` nodes for couplings that `reach` so many nodes far."""
    period = max(PERIOD, 2 * reach + 2)
    rank = np.full(shape, -1, dtype=np.int64)
    boxes: list[Box] = []
    parent: list[int] = []
    done = 0

    def inside(low: int, high: int, axis: int) -> slice:
        return slice(min(max(low, 0), shape[axis]), min(max(high, 0), shape[axis]))

    def add(low: tuple[int, int], high: tuple[int, int]) -> int:
        """Dissect the box of the nodes from `low` to before `high`; its number."""
        nonlocal done
        begin, children = done, []
        cut, (first, last) = _band(low, high, period, reach)
        if last > first:
            for part in ((low[cut], first), (last, high[cut])):
                ends = [(low[axis], high[axis]) if axis != cut else part for axis in (0, 1)]
                children.append(add((ends[0][0], ends[1][0]), (ends[0][1], ends[1][1])))
        else:
            first, last = low[cut], high[cut]
        band, ranges = done, [(low[0], high[0]), (low[1], high[1])]
        ranges[cut] = (first, last)
        x, y = (inside(*ends, axis) for axis, ends in enumerate(ranges))
        size = (x.stop - x.start, y.stop - y.start)
        numbers = np.arange(done, done + size[0] * size[1])
        rank[x, y] = numbers.reshape(size[::-1]).T if cut == 0 else numbers.reshape(size)  # along the band
        done += len(numbers)
        around = tuple(inside(low[axis] - reach, high[axis] + reach, axis) for axis in (0, 1))
        boxes.append(Box(low, begin, band, done, (around[0], around[1])))
        parent.append(-1)
        for child in children:
            parent[child] = len(boxes) - 1
        return len(boxes) - 1

    n_boxes = [max(1, -(-(n + reach) // period)) for n in shape]
    start = [-((k * period - reach - n) // 2) for k, n in zip(n_boxes, shape, strict=True)]
    end = [s + k * period - reach for k, s in zip(n_boxes, start, strict=True)]
    add((start[0], start[1]), (end[0], end[1]))
    begins, bands, ends = (np.array([getattr(box, name) for box in boxes]) for name in ("begin", "band", "end"))
    return Dissection(rank, tuple(boxes), np.array(parent), begins, bands, ends, {})


def _band(low: tuple[int, int], high: tuple[int, int], period: int, reach: int) -> tuple[int, tuple[int, int]]:
    """The axis that a box from `low` to before `high` is cut across, and the nodes of the band; none if it is small.

    Boxes of several periods are cut between two of them, those of one in their middle.
    """
    lengths = [high[axis] - low[axis] for axis in (0, 1)]
    axis = 0 if lengths[0] >= lengths[1] else 1
    length = lengths[axis]
    n_periods = (length + reach) // period
    first = (n_periods // 2) * period - reach if n_periods >= 2 else (length - reach) // 2
    if first <= 0:
        return axis, (0, 0)
    return axis, (low[axis] + first, low[axis] + first + reach)
