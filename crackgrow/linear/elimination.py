"""Kernels of the multifrontal method: a front is assembled, eliminated, and solved with (Duff, Reid 1983).

A front is [[A, B], [B', C]] of its own p unknowns and its border of b. It becomes the rows [U, V] of L' with
A = U' D U, and leaves C - V' D V to its parent. D is 1 for functions and -1 for multipliers, which come last.
Arrays hold upper triangles.
"""

from __future__ import annotations

import numpy as np

from crackgrow.arrays import Bools, Floats, Ints
from crackgrow.compiled import add_product, add_square, cholesky, dependent_of, kernel, solve_upper

ROUND_OFF = 1e-13
"""Of its entry on the diagonal: a pivot below is what round-off has left of zero. So it is with slivers of rock between
a crack and an outline, or with many functions on little rock, which then depend on each other."""

DEPENDENT = 1e-11
"""Of its entry on the diagonal, when the largest pivots come first: a smaller pivot is that of a function that depends
on others, or of a constraint that repeats others of its front."""

ROWS = 64
"""Of a large matrix, that are worked on together."""

STIFF = 1e100
"""Times its entry on the diagonal: what is held like this does not move."""


@kernel
def enter(start: Ints, block: Ints, turned: Bools, column: Ints, blocks: Floats, U: Floats, V: Floats) -> None:
    """Add those of the `blocks` (q, 2, 2) of a matrix that a front's functions have, from start[k] on for each.

    They are the numbers `block`, transposed where they are `turned`.
    """
    p = len(U)
    for k in range(len(start) - 1):
        a = 2 * k
        for q in range(start[k], start[k + 1]):
            c = column[q]
            for i in range(2):
                for j in range(2):
                    value = blocks[block[q], j, i] if turned[q] else blocks[block[q], i, j]
                    if c >= p:
                        V[a + i, c + j - p] += value
                    elif c + j >= a + i:
                        U[a + i, c + j] += value


@kernel
def hold(
    held: Ints, start: Ints, column: Ints, values: Floats, multiplier: Ints, rho: Floats, U: Floats, V: Floats,
    C: Floats,
) -> None:  # fmt: skip
    """Add [[C' rho C, C'], [C, 0]] of the constraints `held` that begin in a front.

    Those of constraint r are `values` at `column` from start[r] on, `multiplier` and `rho`.
    """
    p = len(U)
    for r in held:
        for s in range(start[r], start[r + 1]):
            for t in range(start[r], start[r + 1] + 1):
                a, b = column[s], column[t] if t < start[r + 1] else multiplier[r]
                value = rho[r] * values[s] * values[t] if t < start[r + 1] else values[s]
                if b < a:
                    continue
                if b < p:
                    U[a, b] += value
                elif a < p:
                    V[a, b - p] += value
                else:
                    C[a - p, b - p] += value


@kernel
def tie(start: Ints, entry: Ints, column: Ints, values: Floats, softness: Floats, U: Floats, V: Floats) -> None:
    """Add what ties act on a front's functions by, the `values` (s, 2) from start[k] on for each, and -B of its ties.

    `softness` (p,) is B of the front's own multipliers, zero at its functions.
    """
    p = len(U)
    for k in range(len(start) - 1):
        for q in range(start[k], start[k + 1]):
            c = column[q]
            for i in range(2):
                if c >= p:
                    V[2 * k + i, c - p] += values[entry[q], i]
                else:
                    U[2 * k + i, c] += values[entry[q], i]
    for a in range(p):
        U[a, a] -= softness[a]


@kernel
def extend(left: Floats, into: Ints, U: Floats, V: Floats, C: Floats) -> None:
    """Add the Schur complement `left` (b, b) of a child to the front of its parent, in place.

    `into` (b,) are its unknowns' numbers in the parent, ascending; U (p, p), V (p, c) and C (c, c) are its blocks.
    Upper triangles alone are kept.
    """
    p, b = len(U), len(into)
    n_own = np.searchsorted(into, p)  # they are ascending
    for i in range(b):
        a = into[i]
        if a < p:
            for j in range(i, n_own):
                U[a, into[j]] += left[i, j]
            for j in range(n_own, b):
                V[a, into[j] - p] += left[i, j]
        else:
            for j in range(i, b):
                C[a - p, into[j] - p] += left[i, j]


@kernel
def eliminate(U: Floats, V: Floats, C: Floats, size: Floats, n_placed: int, careful: bool) -> bool:
    """Replace U and V by the rows of L', C by what is left; `size` (n_placed,) are of the diagonal of functions.

    False, with nothing of use, where a pivot is round-off. If it is `careful` functions that depend on others are held
    at zero before, as multipliers of constraints that repeat others of the front always are: the others give all.
    """
    p, k = len(U), n_placed
    own, beside = U[:k, :k], U[:k, k:]
    if careful:
        for i in _hold(own, size[:k]):
            beside[i] = 0.0
            V[i] = 0.0
    if not _is_factorized(own, size[:k]):
        return False
    solve_upper(own, V[:k], True)
    solve_upper(own, beside, True)
    if p > k:
        between, after = U[k:, k:], V[k:]
        add_square(beside, between, -1.0)
        add_product(beside, V[:k], after, -1.0, True)
        between *= -1.0  # D
        after *= -1.0
        met = np.diag(between).copy()
        for i in _hold(between, met):
            after[i] = 0.0
        if not _is_factorized(between, met):
            return False
        solve_upper(between, after, True)
    add_square(V[:n_placed], C, -1.0)  # C - V' D V
    add_square(V[n_placed:], C, 1.0)
    return True


@kernel
def _is_factorized(matrix: Floats, size: Floats) -> bool:
    """Replace the upper triangle by its Cholesky factor; False where a pivot is round-off of its `size`."""
    if cholesky(matrix) != 0:
        return False
    return bool(np.all(np.diag(matrix) ** 2 >= ROUND_OFF * size))  # false for what is not a number


@kernel
def _hold(matrix: Floats, size: Floats) -> Ints:
    """Hold the unknowns of a matrix (n, n) that depend on others, of the `size` (n,) on the diagonal; return which."""
    n, scaled = len(size), np.empty(matrix.shape)
    scale = np.ones(n)
    for i in range(n):
        if size[i] > 0.0:
            scale[i] = 1.0 / np.sqrt(size[i])
    for i in range(n):
        for j in range(i, n):
            scaled[i, j] = scale[i] * matrix[i, j] * scale[j]
    held: Ints = dependent_of(scaled, DEPENDENT)
    for i in held:
        matrix[:i, i] = 0.0
        matrix[i] = 0.0
        matrix[i, i] = STIFF * (size[i] if size[i] > 0.0 else 1.0)
    return held


@kernel
def forward(U: Floats, V: Floats, n_placed: int, begin: int, border: Ints, x: Floats) -> None:
    """Replace what right-hand sides x (n, k) have at a front by D^-1 U'^-1 of it, and take it off the border's."""
    p, b, n_columns = len(U), V.shape[1], x.shape[1]
    active = np.zeros(n_columns, np.bool_)  # loads act on few fronts each
    for a in range(begin, begin + p):
        for k in range(n_columns):
            active[k] |= x[a, k] != 0.0
    columns = np.flatnonzero(active)
    m = len(columns)
    if m == 0:
        return
    mine, off = np.empty((p, m)), np.zeros((b, m))
    for a in range(p):
        for k in range(m):
            mine[a, k] = x[begin + a, columns[k]]
    solve_upper(U, mine, True)
    add_product(V, mine, off, 1.0, True)
    for a in range(p):
        for k in range(m):
            x[begin + a, columns[k]] = mine[a, k] if a < n_placed else -mine[a, k]
    for j in range(b):
        for k in range(m):
            x[border[j], columns[k]] -= off[j, k]


@kernel
def backward(U: Floats, V: Floats, begin: int, border: Ints, x: Floats) -> None:
    """Replace what x (n, k) has at a front by U^-1 (x - V times the border's)."""
    later, mine = np.empty((len(border), x.shape[1])), x[begin : begin + len(U)]
    for j in range(len(border)):
        later[j] = x[border[j]]
    add_product(V, later, mine, -1.0, False)
    solve_upper(U, mine, False)


@kernel
def gather(left: Floats, into: Ints, at: Ints, y: Floats, rest: Floats) -> None:
    """Add what a child's subtree takes off later rows of its columns to its parent's, which are `at` (c,) there."""
    p = len(y)
    for j in range(len(into)):
        target = y[into[j]] if into[j] < p else rest[into[j] - p]
        for k in range(len(at)):
            target[at[k]] += left[j, k]


@kernel
def reduce(U: Floats, V: Floats, n_placed: int, y: Floats, rest: Floats, columns: Ints, total: Floats) -> None:
    """Replace y (p, c) of a front by U'^-1 y, take it off `rest` (b, c), add y' D y to the upper part of `total`.

    There it is at `columns` (c,), ascending.
    """
    solve_upper(U, y, True)
    add_product(V, y, rest, -1.0, True)
    c = len(columns)
    for first in range(0, c, ROWS):  # never all of it at once
        last = min(first + ROWS, c)
        product = np.zeros((last - first, c - first))
        add_product(y[:n_placed, first:last], y[:n_placed, first:], product, 1.0, True)
        add_product(y[n_placed:, first:last], y[n_placed:, first:], product, -1.0, True)
        for i in range(first, last):
            row = total[columns[i]]
            for k in range(i, c):
                row[columns[k]] += product[i - first, k - first]


@kernel
def mirror(matrix: Floats) -> None:
    """Make the lower triangle of a matrix (n, n) that of its transpose."""
    n = len(matrix)
    for a in range(0, n, ROWS):
        for b in range(a, n, ROWS):
            for i in range(a, min(a + ROWS, n)):
                for j in range(max(b, i + 1), min(b + ROWS, n)):
                    matrix[j, i] = matrix[i, j]
