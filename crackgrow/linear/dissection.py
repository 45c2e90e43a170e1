"""Nested dissection by lines: the order in which functions are eliminated (George 1973).

Every function has a box, its support, and is coupled only to functions whose boxes overlap its own. A line sends the
boxes on its two sides into two parts that are not coupled; those that it crosses are eliminated after both. Of all
lines along ends of boxes it is that with the least (n_cut + FREE)^2 n / (n_left n_right): many on both of its sides,
few between them, for the work of a front grows faster than it does. Where boxes are of several sizes the middle of the
plane would cross what is small and many.

Functions on the two sides of a crack are not coupled, though their boxes overlap. Where a line and the cracks together
leave a part in several pieces, each is a part of its own, at no cost: as one they would fill each other's rows. Ties
across the cracks are eliminated after both sides: where they are more than the functions that the line crosses, the
pieces that they hold together are cut as one.
"""

from __future__ import annotations

import numpy as np

from crackgrow.arrays import Ints
from crackgrow.compiled import kernel

LEAF = 50
"""Parts with at most so many functions are not cut."""

FREE = 10
"""Functions: to cut fewer saves nothing any more."""


def dissected(low: Ints, high: Ints, couplings: tuple[Ints, Ints], ties: tuple[Ints, Ints]) -> tuple[Ints, Ints, Ints]:
    """The part (n,) of each box from `low` to `high` (n, 2), the parent (parts,) of each part, and an order (n,).

    `couplings` are those that each is joined to, by stiffness or by a constraint, before it and itself: where they
    begin (n + 1,), and they (q,). `ties` are the ties that act on each, (n + 1,) and (s,).
    Children come before parents, the last part has no parent (-1). The order goes along the plane, whatever the parts.
    """
    ends = np.stack([low[:, 0], low[:, 1], high[:, 0], high[:, 1]])
    orders = np.argsort(ends, axis=1, kind="stable")
    along = np.lexsort((low[:, 1], low[:, 0]))
    part, parent = _cut(ends, orders, couplings, ties)
    return part, parent, along


@kernel
def _cut(ends: Ints, orders: Ints, couplings: tuple[Ints, Ints], ties: tuple[Ints, Ints]) -> tuple[Ints, Ints]:
    """Parts as of `dissected`, of boxes with `ends` (4, n), low x and y, high x and y, in the order of each (4, n)."""
    n = ends.shape[1]
    side, kept, above = np.zeros(n, np.int64), np.empty(n, np.int64), np.empty(n, np.int64)
    begin, end, parent = [0], [0], [-1]  # the last part, for what is in several pieces from the beginning
    part = np.zeros(n, np.int64)
    met = np.full(ties[1].max() + 1 if len(ties[1]) else 0, -1)
    _add_pieces(orders, 0, n, 0, 0, couplings, (*ties, met), (side, above, kept), (begin, end, parent))
    current = 1
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
        for k in range(a, b):
            part[orders[0, k]] = current
        if best < np.inf:
            left, right = 0, 0
            for k in range(a, b):
                i = orders[0, k]
                side[i] = 0 if ends[2 + axis, i] <= at else 1 if ends[axis, i] >= at else 2
                left += side[i] == 0
                right += side[i] == 1
            for row in orders:
                _sort(row, a, b, side, np.array([a, a + left, a + left + right]), kept)
            for first, last in ((a, a + left), (a + left, a + left + right)):
                n_cut = b - a - left - right
                _add_pieces(
                    orders, first, last, current, n_cut, couplings, (*ties, met), (side, above, kept),
                    (begin, end, parent),
                )  # fmt: skip
        current += 1
    # numbered so that a subtree is in one piece, children before parents
    size = np.ones(current, np.int64)
    for p in range(current - 1, 0, -1):
        size[parent[p]] += size[p]
    number, free = np.empty(current, np.int64), np.empty(current, np.int64)
    number[0], free[0] = current - 1, 0
    up = np.full(current, -1)
    for p in range(1, current):
        over = parent[p]
        free[p] = free[over]
        free[over] += size[p]
        number[p] = free[p] + size[p] - 1
        up[number[p]] = number[over]
    for i in range(n):
        part[i] = number[part[i]]
    return part, up


@kernel
def _add_pieces(
    orders: Ints,
    a: int,
    b: int,
    current: int,
    n_cut: int,
    couplings: tuple[Ints, Ints],
    ties: tuple[Ints, Ints, Ints],
    work: tuple[Ints, Ints, Ints],
    parts: tuple[list[int], list[int], list[int]],
) -> None:
    """Add the pieces that the functions at the places a to b hang together in as parts, with the parent `current`.

    Small pieces are one part as long as it is not cut. In `orders` (4, n) those of a part come to lie together.
    """
    (start, column), (side, above, kept), (begin, end, parent) = couplings, work, parts
    for i in orders[0, a:b]:
        side[i], above[i], kept[i] = -1, i, -1
    for i in orders[0, a:b]:  # what is coupled gets the same first one (Tarjan 1975)
        for j in column[start[i] : start[i + 1] - 1]:
            if side[j] == -1:
                one, other = _first(above, i), _first(above, j)
                above[max(one, other)] = min(one, other)
    _join_tied(orders[0, a:b], above, ties, n_cut)
    size, n = np.zeros(b - a, np.int64), 0
    for i in orders[0, a:b]:
        first = _first(above, i)
        if kept[first] < 0:
            kept[first] = n
            n += 1
        size[kept[first]] += 1
    of_piece, place, small, m = np.empty(n, np.int64), np.empty(n, np.int64), -1, 0
    at = np.zeros(n + 1, np.int64)
    for piece in range(n):
        joins = size[piece] <= LEAF and small >= 0 and at[small] + size[piece] <= LEAF
        of_piece[piece] = small if joins else m
        at[of_piece[piece]] += size[piece]
        if not joins:
            small = m if size[piece] <= LEAF else small
            m += 1
    for i in orders[0, a:b]:
        side[i] = of_piece[kept[_first(above, i)]]
    last = a
    for p in range(m):
        begin.append(last)
        end.append(last + at[p])
        parent.append(current)
        last, place[p] = last + at[p], last
    if m > 1:
        for row in orders:
            _sort(row, a, b, side, place.copy(), kept)


@kernel
def _join_tied(functions: Ints, above: Ints, ties: tuple[Ints, Ints, Ints], n_cut: int) -> None:
    """Join pieces that more ties hold together than functions were cut.

    `ties` are those of each function, where they begin and they, and for each one of them room for a number.
    """
    tie_start, tie, met = ties
    if len(met) == 0:
        return
    n_between = 0
    for i in functions:
        for t in tie[tie_start[i] : tie_start[i + 1]]:
            met[t] = -1
    for i in functions:
        first = _first(above, i)
        for t in tie[tie_start[i] : tie_start[i + 1]]:
            if met[t] == -1:
                met[t] = first
            elif met[t] >= 0 and met[t] != first:
                n_between += 1
                met[t] = -2
    if n_between <= n_cut + FREE:
        return
    for i in functions:
        for t in tie[tie_start[i] : tie_start[i + 1]]:
            met[t] = -1
    for i in functions:
        for t in tie[tie_start[i] : tie_start[i + 1]]:
            if met[t] == -1:
                met[t] = i
            else:
                one, other = _first(above, i), _first(above, met[t])
                above[max(one, other)] = min(one, other)


@kernel
def _first(above: Ints, i: int) -> int:
    """Find the one that stands for the piece of i; what is passed is set to what stood above it."""
    while above[i] != i:
        above[i] = above[above[i]]
        i = above[i]
    return i


@kernel
def _sort(row: Ints, a: int, b: int, side: Ints, place: Ints, kept: Ints) -> None:
    """Sort the numbers at the places a to b of `row` by `side`, whose values begin at `place`; the sort is stable."""
    kept[a:b] = row[a:b]
    for k in range(a, b):
        i = kept[k]
        row[place[side[i]]] = i
        place[side[i]] += 1
