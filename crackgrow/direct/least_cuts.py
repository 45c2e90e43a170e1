"""Lines that cut parts where few boxes are crossed by their size: for boxes of several sizes, close together in places.

Of all lines along sides of boxes it is that with the least n_cut n / (n_left n_right): many unknowns on both of its
sides, few between them. In the middle of the plane it would cross what is small and many, and leave next to nothing on
one side.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from crackgrow.arrays import Floats, Ints

FREE = 10
"""Unknowns: to cut fewer saves nothing any more."""


def least_cuts(part: Ints, low: Ints, high: Ints, weight: Ints, n_parts: int) -> tuple[Ints, Ints]:
    """The axis (n_parts,) across which each part is cut, and where on it; before all boxes where no line parts them.

    Boxes from `low` to `high` (k, 2) belong to the parts `part` (k,) and have `weight` (k,) unknowns.
    """
    across, at = np.zeros(n_parts, dtype=np.int64), np.full(n_parts, np.iinfo(np.int64).min)
    least = np.full(n_parts, np.inf)
    for axis in range(2):
        of, place, cost = _lines(part, low[:, axis], high[:, axis], weight, n_parts)
        order = np.lexsort((cost, of))
        best = order[np.flatnonzero(np.diff(of[order], prepend=-1))]
        best = best[cost[best] < least[of[best]]]
        across[of[best]], at[of[best]], least[of[best]] = axis, place[best], cost[best]
    return across, at


def _lines(part: Ints, low: Ints, high: Ints, weight: Ints, n_parts: int) -> tuple[Ints, Ints, Floats]:
    """Lines across an axis: the part (m,) that each cuts, where, and what it costs; inf where one side is empty."""
    first = low.min(initial=0)
    width = int(high.max(initial=0) - first) + 1
    begins, ends = part * width + low - first, part * width + high - first
    lines = np.unique(np.concatenate([begins, ends]))
    of, place = np.divmod(lines, width)
    total = np.bincount(part, weight, n_parts)[of]
    before = np.append(0.0, np.cumsum(np.bincount(part, weight, n_parts)))[of]  # unknowns of parts of lower number
    left = _up_to(ends, weight, lines, "right") - before
    right = total - (_up_to(begins, weight, lines, "left") - before)
    cost = np.full(len(lines), np.inf)
    both = (left > 0.0) & (right > 0.0)
    n_cut = (total - left - right)[both]
    cost[both] = (n_cut + FREE) * total[both] / (left[both] * right[both])
    return of, place + first, cost


def _up_to(keys: Ints, weight: Ints, lines: Ints, side: Literal["left", "right"]) -> Floats:
    """The weight of the keys (k,) that are less than each of `lines` (m,), or (`side` "right") equal to it."""
    order = np.argsort(keys)
    sums = np.append(0.0, np.cumsum(weight[order]))
    return np.asarray(sums[np.searchsorted(keys[order], lines, side)])
