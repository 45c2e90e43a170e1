"""Nested dissection by lines: the order in which unknowns are eliminated (George 1973).

Every unknown has a box, the support of its function, and is coupled only to unknowns whose boxes overlap its own. A
line sends the boxes on its two sides into two parts that are not coupled; those that it crosses are eliminated after
both. Where boxes are of one size lines are one period apart where a part is that large, so that most parts between them
are translations of each other and have equal factors; they lie where the plane alone says, so that they stay where they
are while cracks grow. Where boxes are of several sizes lines lie where they cross few.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from crackgrow.arrays import Ints
from crackgrow.direct.least_cuts import least_cuts

PERIOD = 12
"""Cells from one line to the next. A multiple of `clusters.BLOCK`: clusters then lie alike in all parts."""

LEAF = 200
"""Parts with at most so many unknowns are not cut."""


@dataclass(frozen=True, slots=True, eq=False)
class Places:
    """The boxes of n unknowns, and the rectangle that is cut: whole numbers of a unit of length."""

    low: Ints  # (n, 2) lower left corners
    high: Ints  # (n, 2) upper right corners
    first: Ints  # (2,) lower left corner of all
    last: Ints  # (2,) upper right corner of all
    cell: int  # lines go through `first` or lie a whole number of cells from it, where boxes are
    even: bool = True  # all of one size, but for a few

    @property
    def period(self) -> int:
        """From one line to the next."""
        width = int((self.high - self.low).max(initial=0))
        return max(PERIOD, 2 * -(-width // self.cell)) * self.cell


@dataclass(frozen=True, slots=True, eq=False)
class Dissection:
    """The tree of parts, children before parents. The boxes of a part are those that its line crosses, or all."""

    part: Ints  # (k,) of each of the boxes
    order: Ints  # (k,) of elimination: part by part, along the line
    parent: Ints  # (parts,), -1 for none
    begin: Ints  # (parts,) the first part of the tree below it
    low: Ints  # (parts, 2) lower left corner of the rectangle

    @property
    def n(self) -> int:
        """Number of parts."""
        return len(self.parent)


def dissect(places: Places, low: Ints, high: Ints, weight: Ints) -> Dissection:
    """Dissection of the boxes from `low` to `high` (k, 2), each of which `weight` (k,) unknowns have."""
    period = places.period
    n_periods = np.maximum(1, -(-(places.last - places.first) // period))
    over = (n_periods * period - (places.last - places.first)) // (2 * places.cell) * places.cell
    first = places.first - over
    levels = [_Level(np.array([-1]), first[None], (first + n_periods * period)[None])]
    part, moving, begin = np.zeros(len(low), dtype=np.int64), np.arange(len(low)), 0
    axes: list[Ints] = []
    while True:
        level, mine = levels[-1], part[moving] - begin
        if places.even:
            across, at = level.cut(places.cell, period)
        else:
            across, at = least_cuts(mine, low[moving], high[moving], weight[moving], level.n)
        axes.append(across)
        cut = (np.bincount(mine, weight[moving], level.n) > LEAF) & (at > level.low[np.arange(level.n), across])
        moving, mine = moving[cut[mine]], mine[cut[mine]]
        right = low[moving, across[mine]] >= at[mine]
        apart = right | (high[moving, across[mine]] <= at[mine])
        moving, side = moving[apart], (2 * mine + right)[apart]
        there = np.bincount(side, minlength=2 * level.n) > 0
        begin += level.n
        part[moving] = begin + (np.cumsum(there) - 1)[side]
        if not len(moving):
            break
        levels.append(level.divided(np.flatnonzero(there), across, at, begin - level.n))
    parent = np.concatenate([level.parent for level in levels])
    along = 1 - np.concatenate(axes)[part]
    number, below = _children_first(parent)
    by_number, rows = np.argsort(number), np.arange(len(low))
    order = np.lexsort((low[rows, 1 - along], low[rows, along], number[part]))
    up = np.where(parent >= 0, number[parent], -1)
    corners = np.concatenate([level.low for level in levels])
    return Dissection(number[part], order, up[by_number], below[by_number], corners[by_number])


@dataclass(frozen=True, slots=True, eq=False)
class _Level:
    """Parts equally far from the root."""

    parent: Ints  # (parts,)
    low: Ints  # (parts, 2) corners of the rectangle
    high: Ints  # (parts, 2)

    @property
    def n(self) -> int:
        """Number of parts."""
        return len(self.parent)

    def cut(self, cell: int, period: int) -> tuple[Ints, Ints]:
        """The axis (parts,) across which each is cut, the longer one, and where on it.

        Parts of several periods are cut between two of them, others in their middle.
        """
        size = self.high - self.low
        across = np.where(size[:, 0] >= size[:, 1], 0, 1)
        rows = np.arange(self.n)
        length = size[rows, across]
        n_periods = length // period
        half = np.where(n_periods >= 2, n_periods // 2 * period, length // (2 * cell) * cell)
        return across, self.low[rows, across] + half

    def divided(self, children: Ints, across: Ints, at: Ints, begin: int) -> _Level:
        """The parts behind lines: child 2 i is what lies left of that of part i, or below it, 2 i + 1 the rest."""
        part, right = np.divmod(children, 2)
        low, high = self.low[part], self.high[part]
        for corner, side in ((high, 0), (low, 1)):
            mine = np.flatnonzero(right == side)
            corner[mine, across[part[mine]]] = at[part[mine]]
        return _Level(begin + part, low, high)


def _children_first(parent: Ints) -> tuple[Ints, Ints]:
    """Numbers (parts,) of a tree, whose parents come first, with children first; and the first one below each."""
    size = [1] * len(parent)
    above = parent.tolist()
    for part in range(len(above) - 1, 0, -1):
        size[above[part]] += size[part]
    begin, free = [0] * len(above), [0] * len(above)
    for part in range(1, len(above)):
        up = above[part]
        begin[part] = free[part] = free[up]
        free[up] += size[part]
    return np.array(begin) + np.array(size) - 1, np.array(begin)
