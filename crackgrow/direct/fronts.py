"""The fronts of the multifrontal method: which unknowns each eliminates, and which later ones they are coupled to.

A front belongs to a part of the dissection. It is coupled to the unknowns whose boxes overlap those of its part and of
the parts below, and to the multipliers of the constraints that act there.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array

from crackgrow.arrays import Bools, Ints
from crackgrow.direct.dissection import Dissection, Places, dissect
from crackgrow.errors import SolveError
from crackgrow.ragged import spans

WITHIN = 1 << 12
"""More than the unknowns at one place."""

ACROSS = 1 << 25
"""More than the places along an axis."""

MULTIPLIER = 1 << 62
"""The code of multipliers, which have no place: above ACROSS^2 WITHIN, within 64 bits."""


@dataclass(frozen=True, slots=True, eq=False)
class Fronts:
    """The elimination tree of n unknowns with places and of m multipliers, which are numbered behind them.

    Front k eliminates the unknowns order[starts[k] : starts[k + 1]], children before parents: first `n_early[k]`
    multipliers, then `n_placed[k]` unknowns with places, then the other multipliers.
    """

    order: Ints  # (n + m,)
    position: Ints  # (n + m,) of each unknown in `order`
    starts: Ints  # (fronts + 1,)
    n_early: Ints  # (fronts,)
    n_placed: Ints  # (fronts,)
    parent: Ints  # (fronts,), -1 for none, and for fronts without unknowns
    boundary: tuple[Ints, ...]  # front by front, ascending positions of later unknowns coupled to the subtree
    code: Ints  # (n + m,) middle of its box and number there of the unknown at each position; or `MULTIPLIER`
    corner: Ints  # (fronts,) code of the corner of the front's part: codes less this are alike in parts alike

    @property
    def n(self) -> int:
        """Number of fronts."""
        return len(self.parent)


@dataclass(frozen=True, slots=True, eq=False)
class _Rows:
    """Where multipliers are eliminated."""

    front: Ints  # (m,)
    narrow: Bools  # (m,)
    passed: list[tuple[Ints, Ints]]  # fronts and multipliers: those that act in a front's subtree, eliminated later


@dataclass(frozen=True, slots=True, eq=False)
class _Boxes:
    """The different boxes of unknowns."""

    low: Ints  # (k, 2)
    high: Ints  # (k, 2)
    code: Ints  # (k,)
    of: Ints  # (n,) box of each unknown
    count: Ints  # (k,) its unknowns


def fronts_of(places: Places, constraints: csr_array) -> tuple[Fronts, Bools]:
    """Fronts of unknowns (n,) at `places` and of the multipliers of `constraints` (m, n).

    Also says of which constraints (m,) all the unknowns may be coupled with each other: they are narrow, their boxes
    overlap each other, or all are in one front. The multipliers of the others are eliminated early.
    """
    n, m = len(places.low), constraints.shape[0]
    boxes = _boxes(places)
    tree = dissect(places, boxes.low, boxes.high, boxes.count)
    rank = np.empty(len(tree.order), dtype=np.int64)
    rank[tree.order] = np.arange(len(rank))
    order = np.argsort(rank[boxes.of], kind="stable")
    before = np.append(0, np.cumsum(boxes.count[tree.order]))  # unknowns of boxes of lower rank
    ends = np.searchsorted(tree.part[tree.order], np.arange(tree.n + 1))  # ranks of the boxes of each front
    n_placed = np.diff(before[ends])
    front_of = np.repeat(np.arange(tree.n), n_placed)  # of the placed unknowns, in their order
    rows = _rows(places, constraints, tree.part[boxes.of], tree)

    counts = np.stack([np.bincount(rows.front[which], minlength=tree.n) for which in (~rows.narrow, rows.narrow)])
    starts = np.append(0, np.cumsum(n_placed + counts.sum(axis=0)))
    shift = starts[:-1] + counts[0] - before[ends[:-1]]
    position = np.empty(n + m, dtype=np.int64)
    position[order] = np.arange(n) + shift[front_of]
    for which, begins in ((~rows.narrow, starts[:-1]), (rows.narrow, starts[:-1] + counts[0] + n_placed)):
        mine = np.flatnonzero(which)
        mine = mine[np.argsort(rows.front[mine], kind="stable")]
        front = rows.front[mine]
        position[n + mine] = begins[front] + np.arange(len(mine)) - np.searchsorted(front, front)
    boundary = _boundaries([rank[ring] for ring in _rings(tree, boxes, ends)], before, shift, front_of)
    for fronts, multipliers in rows.passed:
        for front in np.unique(fronts).tolist():
            boundary[front] = np.union1d(boundary[front], position[n + multipliers[fronts == front]])
    first_later = [b[0] if len(b) and size else -1 for b, size in zip(boundary, np.diff(starts), strict=True)]
    parent = np.searchsorted(starts, first_later, side="right") - 1

    code = np.full(n + m, MULTIPLIER)
    code[position[order]] = boxes.code[boxes.of[order]] * WITHIN + np.arange(n) - before[rank[boxes.of[order]]]
    corner = _code(2 * tree.low) * WITHIN
    return Fronts(_inverse(position), position, starts, counts[0], n_placed, parent, tuple(boundary), code, corner), (
        rows.narrow
    )


def _code(middle: Ints) -> Ints:
    """One number (k,) for places (k, 2)."""
    return np.asarray(ACROSS * middle[:, 0] + middle[:, 1])


def _boxes(places: Places) -> _Boxes:
    """The boxes. Raises ValueError where two have one middle and not one size."""
    middle = places.low + places.high
    code, first, of, count = np.unique(_code(middle), return_index=True, return_inverse=True, return_counts=True)
    extent = int(np.ptp(middle, axis=0).max(initial=0)) if len(middle) else 0
    _check_codes(int(count.max(initial=0)), extent + 1)
    boxes = _Boxes(places.low[first], places.high[first], code, of, count)
    if not np.array_equal(boxes.low[of], places.low):
        raise ValueError("boxes with one middle must be of one size")
    return boxes


def _rings(tree: Dissection, boxes: _Boxes, ends: Ints) -> list[Ints]:
    """Part by part, the boxes (b,) of parts above it that overlap one of its own or below it, as far as these reach."""
    corners = np.concatenate([boxes.low, -boxes.high], axis=1)
    farthest = np.full((tree.n, 4), np.iinfo(np.int64).max)  # the least of `corners` of all boxes below
    np.minimum.at(farthest, tree.part, corners)
    for part, up in enumerate(tree.parent[:-1].tolist()):
        np.minimum(farthest[up], farthest[part], out=farthest[up])
    beyond = -farthest[:, [2, 3, 0, 1]]
    rings = [np.empty(0, dtype=np.int64)] * tree.n
    for part in range(tree.n - 2, -1, -1):
        up = tree.parent[part]
        above = np.concatenate([tree.order[ends[up] : ends[up + 1]], rings[up]])
        rings[part] = above[(corners[above] < beyond[part]).all(axis=1)]
    return rings


def _check_codes(n_within: int, n_across: int) -> None:
    """Raise SolveError where codes of unknowns would be those of others: factors are known by them."""
    for what, n, most in (("unknowns at one place", n_within, WITHIN), ("places along an axis", n_across, ACROSS)):
        if n > most:
            raise SolveError(
                f"{n} {what}, at most {most} can be told apart: use larger cells (numerics.spacing, "
                "numerics.refine), or fewer tips at one place"
            )


def _rows(places: Places, constraints: csr_array, front_of: Ints, tree: Dissection) -> _Rows:
    """Where the multipliers of `constraints` (m, n) go: the lowest front above all unknowns that they act on.

    `front_of` (n,) are the fronts of the unknowns.
    """
    m = constraints.shape[0]
    row = np.repeat(np.arange(m), np.diff(constraints.indptr))
    fronts = front_of[constraints.indices]
    lowest, highest = np.full(m, tree.n - 1), np.zeros(m, dtype=np.int64)
    np.minimum.at(lowest, row, fronts)
    np.maximum.at(highest, row, fronts)
    narrow = lowest == highest
    low, high = np.full((m, 2), places.low.min(initial=0)), np.full((m, 2), places.high.max(initial=0))
    np.maximum.at(low, row, places.low[constraints.indices])
    np.minimum.at(high, row, places.high[constraints.indices])
    narrow |= (low < high).all(axis=1)
    front = np.maximum(highest, lowest)  # of no unknown: the last
    while True:
        outside = tree.begin[front] > lowest
        if not outside.any():
            break
        front = np.where(outside, tree.parent[front], front)
    passed = []
    pairs = np.unique(fronts * m + row)
    while len(pairs):
        at, which = np.divmod(pairs, m)
        below = at != front[which]
        at, which = at[below], which[below]
        if len(at):
            passed.append((at, which))
        pairs = np.unique(tree.parent[at] * m + which)
    return _Rows(front, narrow, passed)


def _boundaries(rings: list[Ints], before: Ints, shift: Ints, front_of: Ints) -> list[Ints]:
    """Positions, ascending, of the unknowns whose boxes have the ranks of each ring."""
    ranks = np.concatenate([np.sort(ring) for ring in rings])
    length = before[ranks + 1] - before[ranks]
    ends = np.append(0, np.cumsum(length))
    placed = spans(before[ranks], length)
    positions = placed + shift[front_of[placed]]
    return np.split(positions, ends[np.cumsum([len(ring) for ring in rings])][:-1])


def _inverse(permutation: Ints) -> Ints:
    """The place of every number in a permutation."""
    places = np.empty(len(permutation), dtype=np.int64)
    places[permutation] = np.arange(len(permutation))
    return places
