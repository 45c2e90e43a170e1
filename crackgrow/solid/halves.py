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

    @property
    def first(self) -> Ints:
        """The first function (p,) of each pair."""
        return np.arange(len(self.counts)).repeat(self.counts)

    @cached_property
    def key(self) -> bytes:
        """A hash of all of it."""
        return key_of((self.counts, self.second, self.entries))

    @cached_property
    def diagonal(self) -> Floats:
        """The diagonal (2 k,) of the matrix."""
        own = np.flatnonzero(self.first == self.second)
        found = np.zeros((len(self.counts), 2))
        for component in (0, 1):
            found[self.second[own], component] = 2.0 * self.entries[component, own, component]
        return found.ravel()

    @cached_property
    def largest(self) -> float:
        """The largest absolute value of a term; nan where a value is none."""
        return float(np.max([np.abs(some).max(initial=0.0) for some in (self.entries, self.diagonal)]))

    def tocsc(self) -> csc_array:
        """The matrix (2 k, 2 k)."""
        n, component = 2 * len(self.counts), np.arange(2)
        rows = np.broadcast_to(2 * self.first[:, None] + component[:, None, None], self.entries.shape)
        columns = np.broadcast_to(2 * self.second[:, None] + component, self.entries.shape)
        return mirrored(csr_array((self.entries.ravel(), (rows.ravel(), columns.ravel())), shape=(n, n)))


def half(n: int, pairs: Ints, matrix: Floats) -> HalfMatrix:
    """Half of a symmetric matrix of n functions that is zero but for some pairs of them.

    pairs: (p,) n times the first function plus the second, which is not the smaller one; ascending
    matrix: (2, 2, p) [component of the first, component of the second, pair]
    """
    first, second = np.divmod(pairs, n)
    entries = matrix.transpose(0, 2, 1) * np.where(first == second, 0.5, 1.0)[:, None]
    return HalfMatrix(np.bincount(first, minlength=n), second.astype(np.int32), np.ascontiguousarray(entries))


def sum_of(parts: Iterable[tuple[Ints, HalfMatrix]], n_functions: int) -> HalfMatrix:
    """The sum of matrices; each stands at all of its places, functions (m, k) of `n_functions`."""
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
    rows = np.concatenate([row, n_functions + row])
    each = np.arange(len(rows) + 1, dtype=rows.dtype)
    place = csr_array((np.ones(len(rows)), rows, each), shape=(len(rows), 2 * n_functions))
    total = csr_array(place.T @ halves)  # rows of both components of a function have the same columns in one order
    counts, second = np.diff(total.indptr[: n_functions + 1]), total.indices[: total.nnz // 2]
    return HalfMatrix(counts, second, total.data.view(np.float64).reshape(2, -1, 2))


def mirrored(one: csr_array) -> csc_array:
    """H + H' for H (n, n)."""
    other = csr_array(one.T)
    total = other + csr_array(other.T)  # sorted, unlike `one`
    return csc_array((total.data, total.indices, total.indptr), shape=total.shape)  # it is symmetric to the last bit
