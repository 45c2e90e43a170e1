"""Reuse of the entries of the stiffness matrix that have not changed since the configuration before.

The key of an element is a hash of all data that its integrals depend on; the key of a function is a hash of the keys of
its elements and of its position on each of them. If no element of a function has changed, and the functions on these
elements are the same as before, its rows are copied from the matrix before with the new numbers of the functions.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from crackgrow.arrays import Bools, Floats, Ints
from crackgrow.compiled import kernel

if TYPE_CHECKING:
    from crackgrow.solid.stiffness import Stiffness

Keys = NDArray[np.uint64]

FIRST, SECOND = np.uint64(0x9E3779B97F4A7C15), np.uint64(0xC2B2AE3D27D4EB4F)
"""Odd factors of two hashes, of which a change is seen by one at least (golden ratio; Collet 2012, xxHash)."""


@kernel
def _mix(key: Keys, word: np.uint64) -> None:
    """Take a word into both hashes of a key (2,)."""
    key[0] = (key[0] ^ word) * FIRST
    key[0] ^= key[0] >> np.uint64(29)
    key[1] = (key[1] + word) * SECOND
    key[1] ^= key[1] >> np.uint64(32)


@kernel
def _mix_rows(key: Keys, table: Floats, begin: int, end: int) -> None:
    """Take the rows `begin` to `end` of a table into a key, and their number."""
    _mix(key, np.uint64(end - begin))
    words = table[begin:end].view(np.uint64)
    for row in range(end - begin):
        for column in range(table.shape[1]):
            _mix(key, words[row, column])


@kernel
def element_keys(
    arrays: Any, inside: tuple[Ints, Floats, Floats], rim: tuple[Ints, Floats, Floats], material: Floats
) -> Keys:
    """Keys (elements, 2) of all that elements are integrated from; the arguments are as of the integrals themselves."""
    nodes, half, patch_at, patch, pair_at, tip_of, side, carrier_at, _, share_at, place, share, tips = arrays
    (inside_at, points, weights), (rim_at, places, normals) = inside, rim
    weight, halves, sides, shares = (
        weights.reshape(-1, 1),
        half.reshape(-1, 1),
        side.reshape(-1, 1),
        share.reshape(-1, 1),
    )
    keys = np.zeros((len(patch_at) - 1, 2), np.uint64)
    for e in range(len(keys)):
        key = keys[e]
        _mix_rows(key, material, e, e + 1)
        for table, at in ((points, inside_at), (places, rim_at), (normals, rim_at)):
            _mix_rows(key, table, at[e], at[e + 1])
        _mix_rows(key, weight, inside_at[e], inside_at[e + 1])
        for p in patch[patch_at[e] : patch_at[e + 1]]:
            _mix_rows(key, nodes, p, p + 1)
            _mix_rows(key, halves, p, p + 1)
        for pair in range(pair_at[e], pair_at[e + 1]):
            _mix_rows(key, tips, tip_of[pair], tip_of[pair] + 1)
            _mix_rows(key, sides, pair, pair + 1)
            for carrier in range(carrier_at[pair], carrier_at[pair + 1]):
                _mix_rows(key, shares, share_at[carrier], share_at[carrier + 1])
                for part in place[share_at[carrier] : share_at[carrier + 1]]:
                    _mix(key, np.uint64(part))
    return keys


@kernel
def elements_of(at: Ints, function: Ints, n: int) -> tuple[Ints, Ints]:
    """The elements of n functions, ascending: starts (n + 1,) and elements, from the functions of elements."""
    of = np.zeros(n + 1, np.int64)
    for i in function:
        of[i + 1] += 1
    of = np.cumsum(of)
    element, free = np.empty(len(function), np.int64), of[:-1].copy()
    for e in range(len(at) - 1):
        for p in range(at[e], at[e + 1]):
            element[free[function[p]]] = e
            free[function[p]] += 1
    return of, element


def reuse_unchanged(matrix: tuple[Any, ...], before: Stiffness) -> Bools:
    """Put the entries of a matrix that are known from `before` into its blocks; say which functions (n,) are changed.

    matrix: functions of elements, elements of functions, keys of elements, rows and columns and blocks of the triangle
    """
    on, of, keys, start, column, block = matrix
    known, lower = (before.on.start, before.on.values), (before.matrix.start, before.matrix.column, before.matrix.block)
    of_known = elements_of(*known, before.matrix.n_functions)
    function = _numbers_before(
        _function_keys(*on, keys, len(of[0]) - 1), _function_keys(*known, before.keys, len(of_known[0]) - 1)
    )
    element = _numbers_before(keys, before.keys)
    _leave_split(*on, *of, *known, element, function)
    _copy(*on, *of, *known, element, function, (start, column, block), lower)
    return np.asarray(function < 0)


def _numbers_before(keys: Keys, known: Keys) -> Ints:
    """The place (n,) of each of some keys (n, 2) among those that are `known` (m, 2), -1 for none."""
    if len(known) == 0:
        return np.full(len(keys), -1)
    order = np.argsort(known[:, 0])
    place = order[np.minimum(np.searchsorted(known[order, 0], keys[:, 0]), len(known) - 1)]
    return np.where((known[place] == keys).all(axis=1), place, -1)


@kernel
def _function_keys(at: Ints, function: Ints, keys: Keys, n: int) -> Keys:
    """Keys (n, 2) of functions by the elements that they act on, and their places on each."""
    found, own = np.zeros((n, 2), np.uint64), np.empty(2, np.uint64)
    for e in range(len(at) - 1):
        for p in range(at[e], at[e + 1]):
            own[:] = keys[e]
            _mix(own, np.uint64(p - at[e]))
            found[function[p]] += own
    return found


@kernel
def _leave_split(
    at: Ints, function: Ints, of: Ints, element: Ints, at_known: Ints, known: Ints, element_before: Ints, before: Ints
) -> None:
    """Put `before` (n,) at -1 where functions that one meets on its elements were one before, or are one now.

    A patch can fall in two, or two can join, far from the elements that it has in common with another one.
    """
    n_known = known.max() + 1 if len(known) else 0
    seen, was = np.full(len(before), -1), np.empty(len(before), np.int64)
    seen_known, became = np.full(n_known, -1), np.empty(n_known, np.int64)
    for i in range(len(before)):
        if before[i] < 0:
            continue
        for e in element[of[i] : of[i + 1]]:
            there = at_known[element_before[e]]
            for p in range(at[e], at[e + 1]):
                j, other = function[p], known[there + p - at[e]]
                if seen[j] != i:
                    seen[j], was[j] = i, other
                if seen_known[other] != i:
                    seen_known[other], became[other] = i, j
                if was[j] != other or became[other] != j:
                    before[i] = -1


@kernel
def _copy(
    at: Ints, function: Ints, of: Ints, element: Ints, at_known: Ints, known: Ints, element_before: Ints,
    before: Ints, matrix: tuple[Ints, Ints, Floats], matrix_before: tuple[Ints, Ints, Floats],
) -> None:  # fmt: skip
    """Copy the blocks of all pairs of which one function is known `before` (n,), -1 for those that are not."""
    start, column, block = matrix
    start_before, column_before, block_before = matrix_before
    done = np.full(len(before), -1)
    for i in range(len(before)):
        if before[i] < 0:
            continue
        for e in element[of[i] : of[i + 1]]:
            there = at_known[element_before[e]]
            for p in range(at[e], at[e + 1]):
                j = function[p]
                if done[j] == i or (j > i and before[j] >= 0):  # a pair of two known ones is copied with the second
                    continue
                done[j] = i
                row, col, other = max(i, j), min(i, j), known[there + p - at[e]]
                to = start[row] + np.searchsorted(column[start[row] : start[row + 1]], col)
                first, last = max(before[i], other), min(before[i], other)
                begin, end = start_before[first], start_before[first + 1]
                source = begin + np.searchsorted(column_before[begin:end], last)
                if (row == i) == (first == before[i]):
                    block[to] = block_before[source]
                else:
                    block[to] = block_before[source].T
