"""Nested dissection by lines: the order in which functions are eliminated (George 1973).

Every function has a box, its support, and is coupled only to functions whose boxes overlap its own. A line sends the
boxes on its two sides into two parts that are not coupled; those that it crosses are eliminated after both. Of all
lines along ends of boxes it is that with the least (n_cut + FREE)^2 n / (n_left n_right): many on both of its sides,
few between them, for the work of a front grows faster than it does. Where boxes are of several sizes the middle of the
plane would cross what is small and many.
"""

from __future__ import annotations

import numpy as np

from crackgrow.arrays import Ints
from crackgrow.compiled import kernel

LEAF = 50
"""Parts with at most so many functions are not cut."""

FREE = 10
"""Functions: to cut fewer saves nothing any more."""


def dissected(low: Ints, high: Ints) -> tuple[Ints, Ints, Ints]:
    """The part (n,) of each box from `low` to `high` (n, 2), the parent (parts,) of each part, and an order (n,).

    Children come before parents, the last part has no parent (-1). The order goes along the plane, whatever the parts.
    """
    ends = np.stack([low[:, 0], low[:, 1], high[:, 0], high[:, 1]])
    orders = np.argsort(ends, axis=1, kind="stable")
    along = np.lexsort((low[:, 1], low[:, 0]))
    part, parent = _cut(ends, orders)
    return part, parent, along


@kernel
def _cut(ends: Ints, orders: Ints) -> tuple[Ints, Ints]:
    """Parts as of `dissected`, of boxes with `ends` (4, n), low x and y, high x and y, in the order of each (4, n)."""
    n = ends.shape[1]
    side, kept = np.zeros(n, np.int64), np.empty(n, np.int64)
    begin, end, parent = [0], [n], [-1]
    part = np.zeros(n, np.int64)
    current = 0
    while current < len(begin):  # parts that are cut later have larger numbers; they are turned round at the end
        a, b = begin[current], end[current]
        axis, at = 0, 0
        best = np.inf
        if b - a > LEAF:
            for across in range(2):
                lows, highs = orders[across], orders[2 + across]
                started = a
                for k in range(a, b - 1):
                    line = ends[2 + across, highs[k]]
                    if line == ends[2 + across, highs[k + 1]]:
                        continue
                    while started < b and ends[across, lows[started]] < line:
                        started += 1
                    left, right = k + 1 - a, b - started
                    if right == 0:
                        break
                    cost = (b - a - left - right + FREE) ** 2 * (b - a) / (left * right)
                    if cost < best:
                        best, axis, at = cost, across, line
        if best < np.inf:
            left, right = 0, 0
            for k in range(a, b):
                i = orders[0, k]
                side[i] = 0 if ends[2 + axis, i] <= at else 1 if ends[axis, i] >= at else 2
                left += side[i] == 0
                right += side[i] == 1
                if side[i] == 2:
                    part[i] = current
            for row in orders:
                kept[a:b] = row[a:b]
                p, q = a, a + left
                for k in range(a, b):
                    i = kept[k]
                    if side[i] == 0:
                        row[p] = i
                        p += 1
                    elif side[i] == 1:
                        row[q] = i
                        q += 1
            for first, last in ((a, a + left), (a + left, a + left + right)):
                begin.append(first)
                end.append(last)
                parent.append(current)
        else:
            for k in range(a, b):
                part[orders[0, k]] = current
        current += 1
    # numbered so that a subtree is in one piece, children before parents
    size = np.ones(current, np.int64)
    for p in range(current - 1, 0, -1):
        size[parent[p]] += size[p]
    number, free = np.empty(current, np.int64), np.empty(current, np.int64)
    number[0], free[0] = current - 1, 0
    up = np.full(current, -1)
    for p in range(1, current):
        above = parent[p]
        free[p] = free[above]
        free[above] += size[p]
        number[p] = free[p] + size[p] - 1
        up[number[p]] = number[above]
    for i in range(n):
        part[i] = number[part[i]]
    return part, up
