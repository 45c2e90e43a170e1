"""A symmetric matrix by its lower blocks: all that it can is what the dense matrix can."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.sparse import csc_array

from crackgrow.linear import SymmetricMatrix, symmetric


def sample(n: int, seed: int = 61) -> tuple[SymmetricMatrix, np.ndarray]:
    """A random matrix of n functions, some of which have no block with themselves."""
    rng = np.random.default_rng(seed)
    dense = rng.normal(size=(2 * n, 2 * n)) * (rng.uniform(size=(2 * n, 2 * n)) < 0.2)
    dense += dense.T
    return symmetric(csc_array(dense)), dense


@pytest.mark.parametrize("n", [1, 2, 9])
def test_products_are_those_of_the_dense_matrix(n: int) -> None:
    found, dense = sample(n)
    vectors = np.random.default_rng(n).normal(size=(2 * n, 3))
    for some in (vectors, vectors[:, 0]):
        np.testing.assert_allclose(found @ some, dense @ some, atol=1e-14)
        np.testing.assert_allclose(found.sizes(some), np.abs(dense) @ np.abs(some), atol=1e-14)


def test_whole_and_diagonal_are_those_of_the_dense_matrix() -> None:
    found, dense = sample(9)
    whole = found.tocsc()
    np.testing.assert_array_equal(whole.toarray(), dense)
    assert whole.nnz == np.count_nonzero(dense)
    np.testing.assert_array_equal(found.diagonal(), dense.diagonal())
    assert found.largest() == np.abs(dense).max()


def test_rows_ascend_to_their_diagonal_block() -> None:
    found, _ = sample(9)
    for row in range(9):
        columns = found.column[found.start[row] : found.start[row + 1]]
        assert (np.diff(columns) > 0).all()
        assert columns[-1] == row


def test_a_diagonal_may_be_added() -> None:
    found, dense = sample(5)
    places, values = np.array([0, 3, 3, 8]), np.array([1.0, 2.0, 4.0, 8.0])
    more = found.with_diagonal(places, values)
    np.add.at(dense, (places, places), values)
    np.testing.assert_array_equal(more.tocsc().toarray(), dense)
    np.testing.assert_array_equal(found.tocsc().toarray(), sample(5)[1])


def test_the_largest_entry_is_none_where_one_is_none() -> None:
    found, _ = sample(5)
    block = found.block.copy()
    block[3, 1, 0] = np.nan
    assert np.isnan(replace(found, block=block).largest())
