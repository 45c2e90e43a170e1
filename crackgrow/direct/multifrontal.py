"""Multifrontal factorization L D L' of a sparse symmetric quasi-definite matrix, with dense kernels (Duff, Reid 1983).

The matrix is [[A, B'], [B, -M]] with M positive semidefinite, and A positive definite, or made so by the multipliers
that are eliminated early. D is 1 for the unknowns of A and -1 for those of M, so that each front takes a Cholesky
factorization for each of its groups of unknowns. Fronts that equal one factorized before share its factors.

No rows are exchanged: a pivot that is but round-off of its entry on the diagonal is replaced (static pivoting: Li,
Demmel 1998), and whoever solves takes the effect away by refinement.

All dense blocks are stored by rows. LAPACK, which stores by columns, is handed their transposes.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.linalg.blas import dgemm, dsyrk, dtrsm, dtrsv
from scipy.linalg.lapack import dpotrf, dtrttp
from scipy.sparse import csr_array

from crackgrow.arrays import Floats, Ints
from crackgrow.direct.contents import Contents
from crackgrow.direct.factor import Factor, Placed, runs
from crackgrow.direct.fronts import Fronts
from crackgrow.direct.matrix import SymmetricMatrix
from crackgrow.direct.products import Reduced, products

ROUND_OFF = 1e-13
"""Of its entry on the diagonal: a pivot below is what round-off has left of zero. So it is with slivers of rock between
a crack and an outline, or with many functions on little rock, which then depend on each other."""

SMALL = 1e-9
"""Of its entry on the diagonal: no pivot of a front in which one is round-off stays smaller. Along what moves no rock
the solution stays small instead of arbitrary. At 1e-12 such a wedge, with pivots of 7e-15 to 4e-10, left a pivot of
-1e-6 and wrong loads; from 1e-9 to 1e-8 loads are the same to 1e-4, with residuals of 1e-10."""


FEW_FRONTS = 15
"""A subtree of at most so many fronts keeps what it leaves to its parent only once something has grown there: before it
is made again from the factors when it is asked for. Of 50 flaws 43 MB are kept at first; all are 370 MB, twice the
factors."""


class _NoPivotError(Exception):
    """A front has a pivot that must be replaced."""


@dataclass(frozen=True, slots=True, eq=False)
class Kept:
    """What the factorization of another matrix may have in common with one, by keys."""

    factors: dict[bytes, Factor]
    reduced: dict[bytes, Reduced]
    handed_over: bool = False  # whoever takes over from it lets go of all else before it makes its own


NOTHING = Kept({}, {})


class Multifrontal:
    """A factorized matrix."""

    def __init__(self, matrix: SymmetricMatrix, fronts: Fronts, known: Kept = NOTHING) -> None:
        """Factorize `matrix` (n, n) by `fronts`; `known` is what is kept of another one."""
        elimination = _Elimination(Contents(matrix, fronts), fronts, known)
        self.factors = elimination.factors
        self.n_factorized = elimination.n_factorized
        self.n_fronts = fronts.n
        self._order = fronts.order
        self._placed: list[Placed] | None = elimination.placed  # None: it is handed over
        self._reduced = known.reduced

    @property
    def kept(self) -> Kept:
        """What the factorization of another matrix may take over; of products, what the last one has left."""
        return Kept(self.factors, self._reduced, handed_over=self._placed is None)

    def hand_over(self) -> None:
        """Solve no more: the factorization that comes next is the last to need what is kept."""
        self._placed = None

    @property
    def _fronts(self) -> list[Placed]:
        if self._placed is None:
            raise RuntimeError("the factors are handed over: nothing can be solved with them any more")
        return self._placed

    def solve(self, right: Floats) -> Floats:
        """Solution (n,) or (n, m) for the right-hand sides `right`."""
        x = np.ascontiguousarray(right.reshape(len(right), -1)[self._order])
        if x.shape[1] == 1:
            self._solve_one(x[:, 0])
        else:
            self._solve_many(x)
        solution = np.empty_like(x)
        solution[self._order] = x
        return solution.reshape(right.shape)

    def _solve_one(self, x: Floats) -> None:
        """Replace a right-hand side (n,), in the order of elimination: factors are read once on each way."""
        for placed in self._fronts:
            mine, factor = x[placed.start : placed.end], placed.factor
            if not mine.any():
                continue
            mine[:] = dtrsv(factor.diagonal.T, mine, lower=0, trans=1)
            if len(placed.coupled):
                x[placed.coupled] -= factor.below @ mine
            for a, b in placed.signs:
                mine[a:b] *= -1.0
        for placed in reversed(self._fronts):
            mine, factor = x[placed.start : placed.end], placed.factor
            if len(placed.coupled):
                mine -= x[placed.coupled] @ factor.below
            mine[:] = dtrsv(factor.diagonal.T, mine, lower=0)

    def _solve_many(self, x: Floats) -> None:
        """Replace right-hand sides (n, m), in the order of elimination."""
        for placed in self._fronts:
            mine, factor = x[placed.start : placed.end], placed.factor
            if not mine.any():
                continue
            dtrsm(1.0, factor.diagonal.T, mine.T, side=1, lower=0, overwrite_b=1)
            for first, a, b in placed.boundary:
                later = x[first : first + b - a].T
                dgemm(-1.0, mine.T, factor.below[a:b].T, beta=1.0, c=later, overwrite_c=1)
            for a, b in placed.signs:
                mine[a:b] *= -1.0
        for placed in reversed(self._fronts):
            mine, factor = x[placed.start : placed.end], placed.factor
            for first, a, b in placed.boundary:
                later = x[first : first + b - a].T
                dgemm(-1.0, later, factor.below[a:b].T, beta=1.0, c=mine.T, trans_b=1, overwrite_c=1)
            dtrsm(1.0, factor.diagonal.T, mine.T, side=1, lower=0, trans_a=1, overwrite_b=1)

    def products(self, right: csr_array) -> Floats:
        """R' A^-1 R (k, k), symmetric to the last bit, for sparse right-hand sides R (n, k), by elimination alone."""
        rows = csr_array(right[self._order])
        rows.sum_duplicates()
        total, self._reduced = products(self._fronts, rows, self._reduced)
        return total


class _Elimination:
    """The fronts of a matrix, eliminated one after the other."""

    def __init__(self, contents: Contents, fronts: Fronts, known: Kept) -> None:
        """`known` is what is kept of another matrix."""
        self.factors: dict[bytes, Factor] = {}
        self.placed: list[Placed] = []
        self.n_factorized = 0
        self._contents, self._fronts = contents, fronts
        self._keys = contents.keys()
        if known.handed_over:
            for key in known.factors.keys() - set(self._keys):
                del known.factors[key]
        self._updates: dict[int, Floats] = {}  # that fronts just eliminated leave to parents that come next
        n_below = [1] * fronts.n  # fronts of each subtree
        for k, key in enumerate(self._keys):
            start, end = fronts.starts[k : k + 2].tolist()
            if start == end:
                continue
            n_below[k] += sum(n_below[child] for child in contents.children(k))
            factor = self.factors.get(key) or known.factors.get(key)
            if factor is None:
                factor = self._eliminated(k, n_below[k] > FEW_FRONTS or bool(known.factors))
                self.n_factorized += 1
            self.factors[key] = factor
            for child in contents.children(k):
                self._updates.pop(child, None)
            signs, border = [(a, b) for a, b, sign in self._groups(k) if sign < 0.0], fronts.boundary[k]
            self.placed.append(Placed(factor, key, start, end, signs, border, runs(border, -1)))

    def _groups(self, front: int) -> list[tuple[int, int, float]]:
        """Ranges of unknowns that a front eliminates in turn, and the sign of D there."""
        early, end = int(self._fronts.n_early[front]), int(np.diff(self._fronts.starts[front : front + 2])[0])
        late = early + int(self._fronts.n_placed[front])
        return [(a, b, sign) for a, b, sign in ((0, early, -1.0), (early, late, 1.0), (late, end, -1.0)) if b > a]

    def _eliminated(self, front: int, keeps: bool) -> Factor:
        """The factor of a front; what it leaves to its parent is waiting there, and is kept if it `keeps` it."""
        groups = self._groups(front)
        own, rest, sizes = self._assembled(front)
        p = own.shape[1]
        try:
            _factorize(own, sizes[:p], groups, _cholesky)
        except _NoPivotError:
            own, rest, sizes = self._assembled(front)
            _factorize(own, sizes[:p], groups, _cholesky_replacing)
        below = own[p:]
        _take_off(below, rest, groups)
        for begin, end, sign in groups:
            if sign < 0.0:
                below[:, begin:end] *= -1.0
        if len(below):
            self._updates[front] = rest
        packed = dtrttp(rest.T, uplo="U")[0] if len(below) and keeps else None
        return Factor(own[:p], below, packed, sizes[p:])

    def _assembled(self, front: int) -> tuple[Floats, Floats, Floats]:
        """Columns (p + b, p) of a front, the rest (b, b), and what has been put on the diagonal (p + b,)."""
        own, rest = self._contents.assembled(front)
        sizes = np.abs(np.concatenate([own.diagonal(), rest.diagonal()]))
        for child in self._contents.children(front):
            at = self._contents.local(front, self._fronts.boundary[child])
            _extend_add(own, rest, at, self._update(child))
            sizes[at] += self.factors[self._keys[child]].sizes
        return own, rest, sizes

    def _update(self, front: int) -> Floats:
        """What a front leaves to its parent, (b, b) lower triangle."""
        factor = self.factors[self._keys[front]]
        if front in self._updates:
            return self._updates[front]
        if factor.packed is None:
            _, made, _ = self._assembled(front)
            _take_off(factor.below, made, self._groups(front))
            factor.packed = dtrttp(made.T, uplo="U")[0]  # it will be asked for again as the same tip grows on
        return factor.update


def _extend_add(front: Floats, rest: Floats, at: Ints, update: Floats) -> None:
    """Add the lower triangle of an `update` (b, b) to the rows and columns `at` (b,), ascending, of a front.

    Its columns are `front` (p + b', p) and then `rest` (b', b'). The places are few runs without gaps.
    """
    p = front.shape[1]
    places = runs(at, p)
    for index, (row, top, bottom) in enumerate(places):
        for column, left, right in places[: index + 1]:
            block = update[top:bottom, left:right]
            target, corner = (front, (row, column)) if column < p else (rest, (row - p, column - p))
            target[corner[0] : corner[0] + bottom - top, corner[1] : corner[1] + right - left] += block


def _factorize(
    own: Floats, sizes: Floats, groups: list[tuple[int, int, float]], cholesky: Callable[[Floats, Floats], None]
) -> None:
    """Replace the columns (p + b, p) of a front by L, whose rows below have the sign of D still to come.

    `sizes` (p,) are of the entries on the diagonal, `groups` ranges of its unknowns and the sign of D there.
    """
    p = own.shape[1]
    diagonal, below = own[:p], own[p:]
    if len(groups) == 1 and groups[0][2] > 0.0:
        cholesky(diagonal, sizes)
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


def _take_off(below: Floats, rest: Floats, groups: list[tuple[int, int, float]]) -> None:
    """Take off the `rest` (b, b) of a front what its unknowns leave there by `below` (b, p), of whatever sign."""
    if len(below):
        for begin, end, sign in groups:
            part = np.ascontiguousarray(below[:, begin:end])
            dsyrk(-sign, part.T, 1.0, rest.T, trans=1, lower=0, overwrite_c=1)


def _cholesky(matrix: Floats, sizes: Floats) -> None:
    """Replace the lower triangle of `matrix` (p, p) by its Cholesky factor; `sizes` (p,) are of its diagonal."""
    _, info = dpotrf(matrix.T, lower=0, clean=0, overwrite_a=1)
    if info or (np.square(matrix.diagonal()) < ROUND_OFF * sizes).any():
        raise _NoPivotError


def _cholesky_replacing(matrix: Floats, sizes: Floats) -> None:
    """As `_cholesky`, column by column; small pivots are replaced, and what round-off has left below them is dropped.

    It would grow from one replaced pivot to the next.
    """
    for k, size in enumerate(sizes.tolist()):
        column = matrix[k:, k] - matrix[k:, :k] @ matrix[k, :k]
        if column[0] < ROUND_OFF * size:
            column[1:] = 0.0
        column[0] = max(column[0], SMALL * size)
        matrix[k:, k] = column / np.sqrt(column[0])
