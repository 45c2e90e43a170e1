"""The sum of symmetric matrices of groups of functions, of which the halves are kept.

The half of a symmetric matrix A is H with H + H' = A: every pair of functions once, and half of what a function has
with itself. Summing is a product of sparse matrices, S' H with S the functions of all groups, one below the other.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array, csr_array, get_index_dtype

from crackgrow.arrays import Floats, Ints, key_of


@dataclass(frozen=True, eq=False)
class HalfMatrix:
    """The half of a symmetric matrix of k functions with two components each."""

    counts: Ints  # (k,) pairs that each function is the first one of
    second: NDArray[np.int32]  # (p,) the second function of each pair, those of the first function first
    entries: Floats  # (2, p, 2) component of the first function, pair, component of the second function

    @cached_property
    def key(self) -> bytes:
        """A hash of all of it."""
        return key_of((self.counts, self.second, self.entries))


def half(n: int, pairs: Ints, matrix: Floats) -> HalfMatrix:
    """Half of a symmetric matrix of n functions that is zero but for some pairs of them.

    pairs: (p,) n times the first function plus the second, which is not the smaller one; ascending
    matrix: (2, 2, p) [component of the first, component of the second, pair]
    """
    first, second = np.divmod(pairs, n)
    entries = matrix.transpose(0, 2, 1) * np.where(first == second, 0.5, 1.0)[:, None]
    return HalfMatrix(np.bincount(first, minlength=n), second.astype(np.int32), np.ascontiguousarray(entries))


def sum_of(parts: Iterable[tuple[Ints, HalfMatrix]], n_functions: int) -> csc_array:
    """Sum (2 n_functions, 2 n_functions) of matrices; each stands at all of its places, functions (m, k)."""
    return mirrored(half_sum_of(parts, n_functions))


def half_sum_of(parts: Iterable[tuple[Ints, HalfMatrix]], n_functions: int) -> csr_array:
    """H (2 n_functions, 2 n_functions) with H + H' the sum of matrices, as `sum_of` has them."""
    none = np.empty(0, dtype=np.int32)
    functions, counts, seconds, entries = [none], [none], [none], [np.empty((2, 0, 2))]
    for places, part in parts:
        n_places, ids = len(places), places.astype(np.int32)  # short numbers: products read and hold less
        functions.append(ids.ravel())
        counts.append(np.tile(part.counts, n_places))
        seconds.append(ids[:, part.second].ravel())
        entries.append(np.tile(part.entries, (1, n_places, 1)) if n_places > 1 else part.entries)
    row, second = np.concatenate(functions), np.concatenate(seconds)
    ends = np.append(0, np.cumsum(np.tile(np.concatenate(counts), 2)))
    ends = ends.astype(get_index_dtype(maxval=2 * int(ends[-1])))
    pairs = np.concatenate(entries, axis=1).view(np.complex128).ravel()  # both components of the second function
    halves = csr_array((pairs, np.tile(second, 2), ends), shape=(2 * len(row), n_functions))
    rows = np.concatenate([2 * row, 2 * row + 1])
    each = np.arange(len(rows) + 1, dtype=rows.dtype)
    place = csr_array((np.ones(len(rows)), rows, each), shape=(len(rows), 2 * n_functions))
    total = csr_array(place.T @ halves)
    columns = (2 * total.indices[:, None] + np.arange(2, dtype=total.indices.dtype)).ravel()
    return csr_array((total.data.view(np.float64), columns, 2 * total.indptr), shape=(2 * n_functions, 2 * n_functions))


def mirrored(one: csr_array) -> csc_array:
    """H + H' for H (n, n)."""
    other = csr_array(one.T)
    total = other + csr_array(other.T)  # sorted, unlike `one`
    return csc_array((total.data, total.indices, total.indptr), shape=total.shape)  # it is symmetric to the last bit
