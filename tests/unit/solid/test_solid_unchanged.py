"""What a stiffness takes over from the one before, told by elements and functions."""

from __future__ import annotations

import numpy as np
import pytest

from crackgrow.linear import SymmetricMatrix
from crackgrow.ragged import Ragged, starts_of
from crackgrow.solid.stiffness import Stiffness, _pattern
from crackgrow.solid.unchanged import elements_of, take_over

SHARES = (1.0, 10.0, 100.0)
"""What each element adds to the entries of all pairs of functions on it."""


def summed(lists: list[list[int]]) -> tuple[tuple, tuple, np.ndarray]:
    """Functions of elements, elements of functions, and the dense sum, for elements with these functions."""
    on = (starts_of(np.array([len(own) for own in lists])), np.concatenate(lists).astype(np.int64))
    n = int(on[1].max()) + 1
    dense = np.zeros((n, n))
    for share, own in zip(SHARES, lists, strict=True):
        dense[np.ix_(own, own)] += share
    return on, elements_of(*on, n), dense


@pytest.mark.parametrize(
    ("before", "after", "known"),
    [
        ([[0, 1], [0, 1], [1]], [[0, 1], [0, 1], [1]], [0]),
        ([[0, 1], [0, 1], [1]], [[0, 1], [0, 2], [1]], []),  # a patch falls in two, far from what 0 meets it on
        ([[0, 1], [0, 2], [1]], [[0, 1], [0, 1], [1]], []),  # two join
        ([[0, 1], [0, 1], [1]], [[1, 2], [1, 2], [0, 2]], [1]),  # under other numbers
    ],
)
def test_only_entries_that_are_as_before_are_taken_over(
    before: list[list[int]], after: list[list[int]], known: list[int]
) -> None:
    """The third element is another one; entries of pairs with a known function are the sums that there are now."""
    keys = np.random.default_rng(0).integers(0, 2**63, (3, 2)).astype(np.uint64)
    on, of, dense = summed(before)
    start, column = _pattern(*on, *of)
    row = np.repeat(np.arange(len(start) - 1), np.diff(start))
    matrix = SymmetricMatrix(start, column, dense[row, column][:, None, None] * np.array([[1.0, 2.0], [3.0, 4.0]]))
    earlier = Stiffness(matrix, Ragged(*on), keys, 3)
    keys = keys.copy()
    keys[2] += np.uint64(5)
    on, of, dense = summed(after)
    start, column = _pattern(*on, *of)
    block = np.zeros((len(column), 2, 2))
    changed = take_over((on, of, keys, start, column, block), earlier)
    np.testing.assert_array_equal(np.flatnonzero(~changed), known)
    row = np.repeat(np.arange(len(start) - 1), np.diff(start))
    taken = ~(changed[row] & changed[column])
    np.testing.assert_array_equal(block[taken, 0, 0], dense[row, column][taken])
    np.testing.assert_array_equal(block[~taken], 0.0)
