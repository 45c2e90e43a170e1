"""A symmetric matrix as the sum of equal elements and a sparse rest: all that it can is what the dense sum can."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse import csc_array

from crackgrow.direct import matrix as module
from crackgrow.direct.matrix import EqualElements, SymmetricMatrix

FUNCTIONS = 7


def sample(rng: np.random.Generator, n_multipliers: int = 0) -> tuple[SymmetricMatrix, np.ndarray]:
    """A matrix with two kinds of elements, of three and of four functions, and its dense sum."""
    n = 2 * FUNCTIONS + n_multipliers
    rest = rng.normal(size=(n, n)) * (rng.uniform(size=(n, n)) < 0.2)
    rest += rest.T
    dense, elements = rest.copy(), []
    for k, n_places in ((3, 5), (4, 2)):
        own = rng.normal(size=(2 * k, 2 * k))
        own += own.T
        functions = np.array([rng.permutation(FUNCTIONS)[:k] for _ in range(n_places)])
        elements.append(EqualElements(functions, own, b""))
        for ids in functions:
            dofs = (2 * ids[:, None] + np.arange(2)).ravel()
            dense[np.ix_(dofs, dofs)] += own
    return SymmetricMatrix(tuple(elements), csc_array(rest)), dense


@pytest.mark.parametrize("at_once", [1, 200, 10**6], ids=["one by one", "a few", "all"])
def test_products_are_those_of_the_dense_sum(monkeypatch: pytest.MonkeyPatch, at_once: int) -> None:
    monkeypatch.setattr(module, "AT_ONCE", at_once)
    rng = np.random.default_rng(61)
    found, dense = sample(rng)
    vectors = rng.normal(size=(len(dense), 3))
    np.testing.assert_allclose(found @ vectors, dense @ vectors, atol=1e-13)
    np.testing.assert_allclose(found @ vectors[:, 0], dense @ vectors[:, 0], atol=1e-13)


@pytest.mark.parametrize("n_multipliers", [0, 1, 2])
@pytest.mark.parametrize("at_once", [1, 200, 10**6], ids=["one by one", "a few", "all"])
def test_as_one_matrix_it_is_the_dense_sum(monkeypatch: pytest.MonkeyPatch, at_once: int, n_multipliers: int) -> None:
    monkeypatch.setattr(module, "AT_ONCE", at_once)
    found, dense = sample(np.random.default_rng(61), n_multipliers)
    np.testing.assert_allclose(found.tocsc().toarray(), dense, atol=1e-14)
    np.testing.assert_allclose(found.diagonal(), dense.diagonal(), atol=1e-14)


def test_as_one_matrix_it_is_symmetric_to_the_last_bit() -> None:
    whole = sample(np.random.default_rng(62))[0].tocsc()
    assert whole.nnz > 100
    assert abs(whole - whole.T).max() == 0.0
