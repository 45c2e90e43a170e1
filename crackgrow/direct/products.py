"""Products R' A^-1 R of sparse right-hand sides R by elimination alone, subtree by subtree.

With A = L D L' it is Y' D Y with Y = L^-1 R. In a front only those columns are at work that have entries in its
subtree; what it takes off later rows goes to its parent, and Y is never held as a whole. What a subtree makes of its
columns follows from its factors and from these columns alone: where neither has changed it is taken over.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg.blas import dsyrk, dtrsm
from scipy.sparse import csr_array

from crackgrow.arrays import Floats, Ints, key_of
from crackgrow.direct.factor import Placed, runs
from crackgrow.direct.panels import fill_upper, lower_panels


@dataclass(frozen=True, slots=True, eq=False)
class Reduced:
    """What elimination in a subtree makes of the right-hand sides (c,) that are at work there."""

    product: Floats  # (c, c) Y' D Y of the rows of Y that are eliminated in it: the lower triangle alone is to be read
    left: Floats  # (c, b) what it leaves to the later unknowns that it is coupled to


@dataclass(frozen=True, slots=True, eq=False)
class _Passed:
    """What the subtree of a front hands to its parent."""

    placed: Placed
    columns: Ints  # (c,) the right-hand sides, ascending
    key: bytes
    reduced: Reduced


def products(
    fronts: Sequence[Placed], rows: csr_array, known: Mapping[bytes, Reduced]
) -> tuple[Floats, dict[bytes, Reduced]]:
    """R' A^-1 R (k, k), symmetric to the last bit, of `rows` R (n, k) in the order of elimination.

    Also what another product may have in common with it, by keys; `known` is that of another one. A tree whose root is
    new has a new product: roots are not kept.
    """
    total = np.zeros((rows.shape[1], rows.shape[1]))
    ends = [placed.end for placed in fronts]
    kept: dict[bytes, Reduced] = {}
    waiting: dict[int, list[_Passed]] = {}
    for number, placed in enumerate(fronts):
        children = waiting.pop(number, [])
        own = slice(*rows.indptr[[placed.start, placed.end]])
        columns = np.unique(np.concatenate([rows.indices[own], *(child.columns for child in children)]))
        if not len(columns):
            continue
        key = _key(placed, rows, columns, children)
        reduced = kept.get(key) or known.get(key) or _reduced(placed, rows, columns, children)
        if len(placed.coupled):
            kept[key] = reduced
            parent = bisect_right(ends, int(placed.coupled[0]))
            waiting.setdefault(parent, []).append(_Passed(placed, columns, key, reduced))
        else:
            _add(total, columns, reduced.product)
    fill_upper(total)
    return total, kept


def _key(placed: Placed, rows: csr_array, columns: Ints, children: Sequence[_Passed]) -> bytes:
    """A hash of all that a subtree's `Reduced` depends on, its columns told apart by their order alone."""
    pointers = rows.indptr[placed.start : placed.end + 1]
    own = slice(pointers[0], pointers[-1])
    parts = [np.frombuffer(placed.key, dtype=np.uint8), np.diff(pointers), rows.data[own]]
    parts.append(np.searchsorted(columns, rows.indices[own]))
    for child in children:
        parts.append(np.frombuffer(child.key, dtype=np.uint8))
        parts += [np.array([placed.start - child.placed.start]), np.searchsorted(columns, child.columns)]
    return key_of(parts)


def _reduced(placed: Placed, rows: csr_array, columns: Ints, children: Sequence[_Passed]) -> Reduced:
    """What a front makes of its `columns` (c,), with what its children have made of them."""
    factor, p = placed.factor, placed.end - placed.start
    y = _gathered(placed, rows, columns, children)
    mine = np.ascontiguousarray(y[:, :p])
    dtrsm(1.0, factor.diagonal.T, mine.T, lower=0, trans_a=1, overwrite_b=1)
    left = y[:, p:] - mine @ factor.below.T
    del y
    product = dsyrk(1.0, mine.T, trans=1).T
    for a, b in placed.signs:
        product = dsyrk(-2.0, np.ascontiguousarray(mine[:, a:b]).T, 1.0, product.T, trans=1, overwrite_c=1).T
    for child in children:
        _add(product, np.searchsorted(columns, child.columns), child.reduced.product)
    return Reduced(product, left)


def _add(total: Floats, at: Ints, some: Floats) -> None:
    """Add `some` (c, c) to the rows and columns `at` (c,), ascending, of a `total` (k, k): lower triangles of both."""
    for rows, columns in lower_panels(len(at)):
        total[np.ix_(at[rows], at[columns])] += some[rows, columns]


def _gathered(placed: Placed, rows: csr_array, columns: Ints, children: Sequence[_Passed]) -> Floats:
    """Entries (c, p + b) in a front of the right-hand sides `columns`, one a row.

    They are those of the sparse `rows` (n, k) of the front's own unknowns, and what its `children` pass on.
    """
    pointers = rows.indptr[placed.start : placed.end + 1]
    own = slice(pointers[0], pointers[-1])
    p = placed.end - placed.start
    y = np.zeros((len(columns), p + len(placed.coupled)))
    y[np.searchsorted(columns, rows.indices[own]), np.repeat(np.arange(p), np.diff(pointers))] = rows.data[own]
    for child in children:
        mine, at = np.searchsorted(columns, child.columns), child.placed.coupled
        on_boundary = p + np.searchsorted(placed.coupled, at)
        for first, a, b in runs(np.where(at < placed.end, at - placed.start, on_boundary), p):
            y[mine, first : first + b - a] += child.reduced.left[:, a:b]
    return y
