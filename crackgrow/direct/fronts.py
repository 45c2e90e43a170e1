"""The fronts of the multifrontal method: which unknowns each eliminates, and which later ones they are coupled to.

A front belongs to a box of the dissection. Boxes with few unknowns are not cut, all that is in them is one front. A
front is coupled to the unknowns round its box and to the multipliers of the constraints that act inside.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array

from crackgrow.arrays import Bools, Ints
from crackgrow.direct.dissection import Places, dissect
from crackgrow.errors import SolveError

LEAF = 200
"""Boxes with at most so many unknowns are not cut."""

WITHIN = 1 << 12
"""More than the unknowns that one node carries."""

ACROSS = 1 << 20
"""More than the nodes of a lattice along an axis."""

MULTIPLIER = 1 << 60
"""The code of multipliers, which have no place."""


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
    code: Ints  # (n + m,) node and number on it of the unknown at each position; or `MULTIPLIER`
    corner: Ints  # (fronts,) code of the first node of the front's box: codes less this are alike in boxes alike

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


def fronts_of(places: Places, constraints: csr_array) -> tuple[Fronts, Bools]:
    """Fronts of unknowns (n,) at `places` and of the multipliers of `constraints` (m, n).

    Also says of which constraints (m,) all the unknowns may be coupled with each other: they are narrow, within the
    reach of couplings, or all in one front. The multipliers of the others are eliminated early.
    """
    tree = dissect(places.shape, places.reach)
    n, m = len(places.nodes), constraints.shape[0]
    rank = tree.rank[places.nodes[:, 0], places.nodes[:, 1]]
    order = np.argsort(rank, kind="stable")
    before = np.append(0, np.cumsum(np.bincount(rank, minlength=tree.rank.size)))  # unknowns on nodes of lower rank
    weight = before[tree.end] - before[tree.begin]
    cut = (weight > LEAF) & (tree.band > tree.begin)
    box = np.flatnonzero((tree.parent < 0) | cut[tree.parent])
    first, last = np.where(cut[box], tree.band[box], tree.begin[box]), tree.end[box]
    number = np.full(len(tree.parent), -1)
    number[box] = np.arange(len(box))
    up = np.where(tree.parent[box] >= 0, number[tree.parent[box]], -1)
    begin = np.searchsorted(first, tree.begin[box])  # first front of the subtree
    front_of = np.repeat(np.arange(len(box)), before[last] - before[first])  # of the placed unknowns, in their order
    rows = _rows(places, constraints, front_of[_inverse(order)], up, begin)

    counts = np.stack([np.bincount(rows.front[which], minlength=len(box)) for which in (~rows.narrow, rows.narrow)])
    n_placed = before[last] - before[first]
    starts = np.append(0, np.cumsum(n_placed + counts.sum(axis=0)))
    shift = starts[:-1] + counts[0] - before[first]
    position = np.empty(n + m, dtype=np.int64)
    position[order] = np.arange(n) + shift[front_of]
    for which, begins in ((~rows.narrow, starts[:-1]), (rows.narrow, starts[:-1] + counts[0] + n_placed)):
        mine = np.flatnonzero(which)
        mine = mine[np.argsort(rows.front[mine], kind="stable")]
        front = rows.front[mine]
        position[n + mine] = begins[front] + np.arange(len(mine)) - np.searchsorted(front, front)
    boundary = _boundaries([tree.ring(number) for number in box.tolist()], before, shift, front_of)
    for fronts, multipliers in rows.passed:
        for front in np.unique(fronts).tolist():
            boundary[front] = np.union1d(boundary[front], position[n + multipliers[fronts == front]])
    first_later = [b[0] if len(b) and size else -1 for b, size in zip(boundary, np.diff(starts), strict=True)]
    parent = np.searchsorted(starts, first_later, side="right") - 1

    code = np.full(n + m, MULTIPLIER)
    x, y = places.nodes[order].T
    within = np.arange(n) - before[rank[order]]
    _check_codes(int(within.max(initial=-1)) + 1, int(places.nodes.max(initial=-1)) + 1)
    code[position[order]] = (ACROSS * x + y) * WITHIN + within
    low = np.array([tree.boxes[number].low for number in box.tolist()])
    corner = (ACROSS * low[:, 0] + low[:, 1]) * WITHIN
    return Fronts(_inverse(position), position, starts, counts[0], n_placed, parent, tuple(boundary), code, corner), (
        rows.narrow
    )


def _check_codes(n_within: int, n_across: int) -> None:
    """Raise SolveError where codes of unknowns would be those of others: factors are known by them."""
    for what, n, most in (("unknowns at one node", n_within, WITHIN), ("nodes along an axis", n_across, ACROSS)):
        if n > most:
            raise SolveError(
                f"{n} {what}, at most {most} can be told apart: use another numerics.spacing, or fewer "
                "tips at one place"
            )


def _rows(places: Places, constraints: csr_array, front_of: Ints, up: Ints, begin: Ints) -> _Rows:
    """Where the multipliers of `constraints` (m, n) go: the lowest front above all unknowns that they act on."""
    m = constraints.shape[0]
    row = np.repeat(np.arange(m), np.diff(constraints.indptr))
    fronts = front_of[constraints.indices]
    lowest, highest = np.full(m, len(up) - 1), np.zeros(m, dtype=np.int64)
    np.minimum.at(lowest, row, fronts)
    np.maximum.at(highest, row, fronts)
    narrow = lowest == highest
    low, high = np.full((m, 2), places.nodes.max(initial=0)), np.zeros((m, 2), dtype=np.int64)
    np.minimum.at(low, row, places.nodes[constraints.indices])
    np.maximum.at(high, row, places.nodes[constraints.indices])
    narrow |= (high - low).max(axis=1, initial=0) <= places.reach
    front = np.maximum(highest, lowest)  # of no unknown: the last
    while True:
        outside = begin[front] > lowest
        if not outside.any():
            break
        front = np.where(outside, up[front], front)
    passed = []
    pairs = np.unique(fronts * m + row)
    while len(pairs):
        at, which = np.divmod(pairs, m)
        below = at != front[which]
        at, which = at[below], which[below]
        if len(at):
            passed.append((at, which))
        pairs = np.unique(up[at] * m + which)
    return _Rows(front, narrow, passed)


def _boundaries(rings: list[Ints], before: Ints, shift: Ints, front_of: Ints) -> list[Ints]:
    """Positions, ascending, of the unknowns on the nodes (ranks) of each ring."""
    nodes = np.concatenate(rings)
    length = before[nodes + 1] - before[nodes]
    ends = np.append(0, np.cumsum(length))
    placed = _ranges(before[nodes], length)
    positions = placed + shift[front_of[placed]]
    return np.split(positions, ends[np.cumsum([len(ring) for ring in rings])][:-1])


def _inverse(permutation: Ints) -> Ints:
    """The place of every number in a permutation."""
    places = np.empty(len(permutation), dtype=np.int64)
    places[permutation] = np.arange(len(permutation))
    return places


def _ranges(start: Ints, length: Ints) -> Ints:
    """The numbers start, start + 1, ... of each of several ranges, one after another."""
    end = np.cumsum(length)
    return np.asarray(np.repeat(start - end + length, length) + np.arange(end[-1] if len(end) else 0))
