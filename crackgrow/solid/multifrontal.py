"""Multifrontal factorization L D L' of a sparse symmetric quasi-definite matrix, with dense kernels (Duff, Reid 1983).

The matrix is [[A, B'], [B, -M]] with A positive definite and M positive semidefinite: D is 1 for the unknowns of A and
-1 for those of M, which in every front come last, so that each front takes two Cholesky factorizations.

All dense blocks are stored by rows. LAPACK, which stores by columns, is handed their transposes.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.blas import dgemm, dsyrk, dtrsm
from scipy.linalg.lapack import dpotrf
from scipy.sparse import csc_array

from crackgrow.errors import SolveError
from crackgrow.solid.dissection import Fronts, dissect

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


class NotQuasiDefiniteError(SolveError):
    """The matrix is not quasi-definite, as far as round-off can tell."""


@dataclass(frozen=True, slots=True, eq=False)
class _Factor:
    """Columns of L that a front eliminates."""

    start: int
    end: int
    n_placed: int  # the first of them, with D = 1
    boundary: list[tuple[int, int, int]]  # runs of it: the first unknown, begin and end in `below`
    diagonal: Floats  # (p, p) lower triangle
    below: Floats  # (b, p)


class Multifrontal:
    """A factorized matrix."""

    def __init__(self, matrix: csc_array, places: Floats) -> None:
        """Factorize `matrix` (n, n); its first unknowns have `places` (k, 2), the others are multipliers.

        Raises NotQuasiDefiniteError where the matrix is not quasi-definite.
        """
        fronts = dissect(matrix, places)
        self._order = fronts.order
        self._factors = _factorize(matrix, fronts)

    @property
    def n_entries(self) -> int:
        """Number of entries stored."""
        return sum(factor.diagonal.size + factor.below.size for factor in self._factors)

    def solve(self, right: Floats) -> Floats:
        """Solution (n,) or (n, m) for the right-hand sides `right`."""
        x = np.ascontiguousarray(right.reshape(len(right), -1)[self._order])
        for factor in self._factors:
            mine = x[factor.start : factor.end]
            if not mine.any():
                continue
            dtrsm(1.0, factor.diagonal.T, mine.T, side=1, lower=0, overwrite_b=1)
            for first, a, b in factor.boundary:
                later = x[first : first + b - a].T
                dgemm(-1.0, mine.T, factor.below[a:b].T, beta=1.0, c=later, overwrite_c=1)
            mine[factor.n_placed :] *= -1.0
        for factor in reversed(self._factors):
            mine = x[factor.start : factor.end]
            for first, a, b in factor.boundary:
                later = x[first : first + b - a].T
                dgemm(-1.0, later, factor.below[a:b].T, beta=1.0, c=mine.T, trans_b=1, overwrite_c=1)
            dtrsm(1.0, factor.diagonal.T, mine.T, side=1, lower=0, trans_a=1, overwrite_b=1)
        solution = np.empty_like(x)
        solution[self._order] = x
        return solution.reshape(right.shape)


def _factorize(matrix: csc_array, fronts: Fronts) -> list[_Factor]:
    """All fronts, children before parents."""
    place_of = np.empty(len(fronts.order), dtype=np.int64)
    place_of[fronts.order] = np.arange(len(fronts.order))
    columns = csc_array(matrix[:, fronts.order])
    rows = place_of[columns.indices]
    local = np.empty(len(fronts.order), dtype=np.int64)
    updates: list[list[tuple[Ints, Floats]]] = [[] for _ in range(fronts.n)]
    factors = []
    for k, boundary in enumerate(fronts.boundary):
        start, end = int(fronts.starts[k]), int(fronts.starts[k + 1])
        p, b = end - start, len(boundary)
        local[start:end] = np.arange(p)
        local[boundary] = np.arange(p, p + b)
        front, rest = np.zeros((p + b, p)), np.zeros((b, b))
        pointers = columns.indptr[start : end + 1]
        entries = slice(pointers[0], pointers[-1])
        column = np.repeat(np.arange(p), np.diff(pointers))
        own = rows[entries] >= start
        front.ravel()[local[rows[entries][own]] * p + column[own]] = columns.data[entries][own]
        for border, update in updates[k]:
            _extend_add(front, rest, local[border], update)
        updates[k] = []
        n_placed = int(fronts.n_placed[k])
        diagonal, below = front[:p], front[p:]
        _eliminate(diagonal, below, n_placed)
        if b:
            for sign, part in ((-1.0, below[:, :n_placed]), (1.0, below[:, n_placed:])):
                if part.shape[1]:
                    dsyrk(sign, np.ascontiguousarray(part).T, 1.0, rest.T, trans=1, lower=0, overwrite_c=1)
            updates[fronts.parent[k]].append((boundary, rest))
        factors.append(_Factor(start, end, n_placed, _runs(boundary, -1), diagonal, below))
    return factors


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


def _eliminate(diagonal: Floats, below: Floats, n_placed: int) -> None:
    """Replace `diagonal` (p, p) and `below` (b, p) of a front by their columns of L."""
    if n_placed == len(diagonal):
        _cholesky(diagonal)
    else:
        placed, multipliers = diagonal[:n_placed, :n_placed].copy(), diagonal[n_placed:, n_placed:]
        coupling = diagonal[n_placed:, :n_placed].copy()
        if n_placed:
            _cholesky(placed)
            dtrsm(1.0, placed.T, coupling.T, lower=0, trans_a=1, overwrite_b=1)
        remaining = coupling @ coupling.T - multipliers
        _cholesky(remaining)
        diagonal[:n_placed, :n_placed], diagonal[n_placed:, :n_placed] = placed, coupling
        diagonal[n_placed:, n_placed:] = remaining
    if len(below):
        dtrsm(1.0, diagonal.T, below.T, lower=0, trans_a=1, overwrite_b=1)
        below[:, n_placed:] *= -1.0


def _cholesky(matrix: Floats) -> None:
    """Replace the lower triangle of `matrix` (p, p) by its Cholesky factor."""
    _, info = dpotrf(matrix.T, lower=0, clean=0, overwrite_a=1)
    if info:
        raise NotQuasiDefiniteError(f"pivot {info} of {len(matrix)} in a front has the wrong sign")
