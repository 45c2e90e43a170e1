"""Multifrontal factorization L D L' of a sparse symmetric quasi-definite matrix, with dense kernels (Duff, Reid 1983).

The matrix is [[A, B'], [B, -M]] with M positive semidefinite, and A positive definite, or made so by the multipliers
that are eliminated early. D is 1 for the unknowns of A and -1 for those of M, so that each front takes a Cholesky
factorization for each of its groups of unknowns. Fronts that equal one factorized before share its factors.

No rows are exchanged: a pivot that is but round-off of its entry on the diagonal is replaced (static pivoting: Li,
Demmel 1998), and whoever solves takes the effect away by refinement.

All dense blocks are stored by rows. LAPACK, which stores by columns, is handed their transposes.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.linalg.blas import dgemm, dsyrk, dtrsm
from scipy.linalg.lapack import dpotrf, dtpttr, dtrttp
from scipy.sparse import csr_array

from crackgrow.arrays import Floats, Ints
from crackgrow.direct.contents import Contents
from crackgrow.direct.fronts import Fronts
from crackgrow.direct.matrix import SymmetricMatrix

ROUND_OFF = 1e-13
"""Of its entry on the diagonal: a pivot below is what round-off has left of zero. So it is with slivers of rock between
a crack and an outline, or with many functions on little rock, which then depend on each other."""

SMALL = 1e-9
"""Of its entry on the diagonal: no pivot of a front in which one is round-off stays smaller. Along what moves no rock
the solution stays small instead of arbitrary. At 1e-12 such a wedge, with pivots of 7e-15 to 4e-10, left a pivot of
-1e-6 and wrong loads; from 1e-9 to 1e-8 loads are the same to 1e-4, with residuals of 1e-10."""


class _NoPivotError(Exception):
    """A front has a pivot that must be replaced."""


@dataclass(frozen=True, slots=True, eq=False)
class Factor:
    """Columns of L that a front eliminates, and what it leaves to its parent."""

    diagonal: Floats  # (p, p) lower triangle
    below: Floats  # (b, p)
    packed: Floats  # (b (b + 1) / 2,) the rows of the lower triangle of `update`: most of what is kept
    sizes: Floats  # (b,) what the front and those below it have put on the diagonal

    @property
    def update(self) -> Floats:
        """What the front leaves to its parent, (b, b) lower triangle."""
        n = len(self.sizes)
        return np.asarray(dtpttr(n, self.packed, uplo="U")[0].T) if n else np.zeros((0, 0))


@dataclass(frozen=True, slots=True, eq=False)
class _Placed:
    """The factor of a front and the places of its unknowns."""

    factor: Factor
    start: int
    end: int
    signs: list[tuple[int, int]]  # the ranges of unknowns with D = -1
    coupled: Ints  # (b,) the later unknowns that it is coupled to
    boundary: list[tuple[int, int, int]]  # runs of it: the first unknown, begin and end in `below`


@dataclass(frozen=True, slots=True, eq=False)
class _Passed:
    """What elimination leaves of sparse right-hand sides to later unknowns."""

    columns: Ints  # (c,) the right-hand sides, ascending
    at: Ints  # (b,) the unknowns, ascending
    values: Floats  # (c, b)


class Multifrontal:
    """A factorized matrix."""

    def __init__(self, matrix: SymmetricMatrix, fronts: Fronts, known: Mapping[bytes, Factor] | None = None) -> None:
        """Factorize `matrix` (n, n) by `fronts`; `known` are factors of another matrix, by their keys."""
        contents = Contents(matrix, fronts)
        keys = contents.keys()
        known = {} if known is None else known
        self.factors: dict[bytes, Factor] = {}
        self.n_factorized = 0
        self.n_fronts = fronts.n
        self._order = fronts.order
        self._placed: list[_Placed] = []
        sizes = zip(fronts.n_early.tolist(), fronts.n_placed.tolist(), strict=True)
        for k, (n_early, n_placed) in enumerate(sizes):
            start, end = fronts.starts[k : k + 2].tolist()
            if start == end:
                continue
            factor = self.factors.get(keys[k]) or known.get(keys[k])
            if factor is None:
                late = n_early + n_placed
                groups = [(0, n_early, -1.0), (n_early, late, 1.0), (late, end - start, -1.0)]
                below = contents.children(k)
                children = [(contents.local(k, fronts.boundary[c]), self.factors[keys[c]]) for c in below]
                try:
                    factor = _eliminated(*_assembled(contents, k, children), groups, _cholesky)
                except _NoPivotError:
                    factor = _eliminated(*_assembled(contents, k, children), groups, _cholesky_replacing)
                self.n_factorized += 1
            self.factors[keys[k]] = factor
            signs = [(a, b) for a, b in ((0, n_early), (n_early + n_placed, end - start)) if b > a]
            self._placed.append(_Placed(factor, start, end, signs, fronts.boundary[k], _runs(fronts.boundary[k], -1)))

    def solve(self, right: Floats) -> Floats:
        """Solution (n,) or (n, m) for the right-hand sides `right`."""
        x = np.ascontiguousarray(right.reshape(len(right), -1)[self._order])
        for placed in self._placed:
            mine, factor = x[placed.start : placed.end], placed.factor
            if not mine.any():
                continue
            dtrsm(1.0, factor.diagonal.T, mine.T, side=1, lower=0, overwrite_b=1)
            for first, a, b in placed.boundary:
                later = x[first : first + b - a].T
                dgemm(-1.0, mine.T, factor.below[a:b].T, beta=1.0, c=later, overwrite_c=1)
            for a, b in placed.signs:
                mine[a:b] *= -1.0
        for placed in reversed(self._placed):
            mine, factor = x[placed.start : placed.end], placed.factor
            for first, a, b in placed.boundary:
                later = x[first : first + b - a].T
                dgemm(-1.0, later, factor.below[a:b].T, beta=1.0, c=mine.T, trans_b=1, overwrite_c=1)
            dtrsm(1.0, factor.diagonal.T, mine.T, side=1, lower=0, trans_a=1, overwrite_b=1)
        solution = np.empty_like(x)
        solution[self._order] = x
        return solution.reshape(right.shape)

    def products(self, right: csr_array) -> Floats:
        """R' A^-1 R (k, k), symmetric to the last bit, for sparse right-hand sides R (n, k), by elimination alone.

        With A = L D L' it is Y' D Y with Y = L^-1 R. In a front only those columns are at work that have entries in its
        subtree; what it takes off later rows goes to its parent, and Y is never held as a whole.
        """
        rows = csr_array(right[self._order])
        rows.sum_duplicates()
        total = np.zeros((rows.shape[1], rows.shape[1]))
        ends = [placed.end for placed in self._placed]
        passed: dict[int, list[_Passed]] = {}
        for number, placed in enumerate(self._placed):
            columns, y = _gathered(placed, rows, passed.pop(number, []))
            if not len(columns):
                continue
            factor, p = placed.factor, placed.end - placed.start
            mine = np.ascontiguousarray(y[:, :p])
            dtrsm(1.0, factor.diagonal.T, mine.T, lower=0, trans_a=1, overwrite_b=1)
            product = mine @ mine.T
            for a, b in placed.signs:
                product -= 2.0 * (mine[:, a:b] @ mine[:, a:b].T)
            total[np.ix_(columns, columns)] += product
            if len(placed.coupled):
                left = y[:, p:] - mine @ factor.below.T
                parent = bisect_right(ends, int(placed.coupled[0]))
                passed.setdefault(parent, []).append(_Passed(columns, placed.coupled, left))
        return total


def _gathered(placed: _Placed, rows: csr_array, children: list[_Passed]) -> tuple[Ints, Floats]:
    """Right-hand sides that are at work in a front, ascending, and their entries (c, p + b) there, one a row.

    They are those of the sparse `rows` (n, k) of the front's own unknowns, and what its `children` pass on.
    """
    pointers = rows.indptr[placed.start : placed.end + 1]
    entries = slice(pointers[0], pointers[-1])
    columns = np.unique(np.concatenate([rows.indices[entries], *(child.columns for child in children)]))
    p = placed.end - placed.start
    y = np.zeros((len(columns), p + len(placed.coupled)))
    if not len(columns):
        return columns, y
    y[np.searchsorted(columns, rows.indices[entries]), np.repeat(np.arange(p), np.diff(pointers))] = rows.data[entries]
    for child in children:
        mine = np.searchsorted(columns, child.columns)
        on_boundary = p + np.searchsorted(placed.coupled, child.at)
        for first, a, b in _runs(np.where(child.at < placed.end, child.at - placed.start, on_boundary), p):
            y[mine, first : first + b - a] += child.values[:, a:b]
    return columns, y


def _extend_add(front: Floats, rest: Floats, at: Ints, update: Floats) -> None:
    """Add the lower triangle of an `update` (b, b) to the rows and columns `at` (b,), ascending, of a front.

    Its columns are `front` (p + b', p) and then `rest` (b', b'). The places are few runs without gaps.
    """
    p = front.shape[1]
    runs = _runs(at, p)
    for index, (row, top, bottom) in enumerate(runs):
        for column, left, right in runs[: index + 1]:
            block = update[top:bottom, left:right]
            target, corner = (front, (row, column)) if column < p else (rest, (row - p, column - p))
            target[corner[0] : corner[0] + bottom - top, corner[1] : corner[1] + right - left] += block


def _runs(at: Ints, cut: int) -> list[tuple[int, int, int]]:
    """Runs without gaps of ascending numbers `at` (b,): first number, begin and end in `at`; split at `cut`."""
    breaks = np.flatnonzero((np.diff(at) != 1) | (at[1:] == cut)) + 1
    ends = [0, *breaks.tolist(), len(at)]
    return [(int(at[a]), a, b) for a, b in pairwise(ends)] if len(at) else []


def _assembled(contents: Contents, front: int, children: list[tuple[Ints, Factor]]) -> tuple[Floats, Floats, Floats]:
    """Columns (p + b, p) of a front, the rest (b, b), and what has been put on the diagonal (p + b,).

    The children come with the places of their boundaries in the front.
    """
    own, rest = contents.assembled(front)
    sizes = np.abs(np.concatenate([own.diagonal(), rest.diagonal()]))
    for at, child in children:
        _extend_add(own, rest, at, child.update)
        sizes[at] += child.sizes
    return own, rest, sizes


def _eliminated(
    own: Floats,
    rest: Floats,
    sizes: Floats,
    groups: list[tuple[int, int, float]],
    cholesky: Callable[[Floats, Floats], None],
) -> Factor:
    """Factor of a front from its columns (p + b, p) and the rest (b, b), both replaced.

    `sizes` (p + b,) are of the entries on the diagonal, `groups` ranges of its unknowns and the sign of D there.
    """
    p = own.shape[1]
    diagonal, below = own[:p], own[p:]
    groups = [group for group in groups if group[1] > group[0]]
    if len(groups) == 1 and groups[0][2] > 0.0:
        cholesky(diagonal, sizes[:p])
    else:
        for begin, end, sign in groups:
            block, left = sign * diagonal[begin:end, begin:end], sign * diagonal[end:, begin:end]
            cholesky(block, sizes[begin:end])
            if len(left):
                dtrsm(1.0, block.T, left.T, lower=0, trans_a=1, overwrite_b=1)
                diagonal[end:, end:] -= sign * (left @ left.T)
            diagonal[begin:end, begin:end], diagonal[end:, begin:end] = block, left
    if len(below):
        dtrsm(1.0, diagonal.T, below.T, lower=0, trans_a=1, overwrite_b=1)
        for begin, end, sign in groups:
            part = np.ascontiguousarray(below[:, begin:end])
            dsyrk(-sign, part.T, 1.0, rest.T, trans=1, lower=0, overwrite_c=1)
            if sign < 0.0:
                below[:, begin:end] *= -1.0
    packed = dtrttp(rest.T, uplo="U")[0] if len(below) else np.empty(0)
    return Factor(diagonal, below, packed, sizes[p:])


def _cholesky(matrix: Floats, sizes: Floats) -> None:
    """Replace the lower triangle of `matrix` (p, p) by its Cholesky factor; `sizes` (p,) are of its diagonal."""
    _, info = dpotrf(matrix.T, lower=0, clean=0, overwrite_a=1)
    if info or (np.square(matrix.diagonal()) < ROUND_OFF * sizes).any():
        raise _NoPivotError


def _cholesky_replacing(matrix: Floats, sizes: Floats) -> None:
    """As `_cholesky`, column by column; small pivots are replaced."""
    for k, size in enumerate(sizes.tolist()):
        column = matrix[k:, k] - matrix[k:, :k] @ matrix[k, :k]
        column[0] = max(column[0], SMALL * size)
        matrix[k:, k] = column / np.sqrt(column[0])
