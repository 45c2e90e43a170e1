"""A symmetric matrix as the sum of equal elements and a sparse rest: all that it can is what the dense sum can."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.sparse import csc_array

from crackgrow.direct import matrix as module
from crackgrow.direct.assembly import HalfMatrix, half
from crackgrow.direct.matrix import EqualElements, SymmetricMatrix, blocks_of

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


def some_blocks(rng: np.random.Generator) -> tuple[list[np.ndarray], list[HalfMatrix], np.ndarray]:
    """Four blocks, some of whose pairs of functions are not coupled, and their dense sum."""
    dense, ids, halves = np.zeros((FUNCTIONS, 2, FUNCTIONS, 2)), [], []
    for k in (3, 1, 5, 4):
        coupled = rng.uniform(size=(k, k)) < 0.5
        coupled |= coupled.T | np.eye(k, dtype=bool)
        own = rng.normal(size=(2, 2, k, k)) * coupled
        own += own.transpose(1, 0, 3, 2)
        pairs = np.flatnonzero(np.triu(coupled))
        ids.append(np.sort(rng.permutation(FUNCTIONS)[:k]))
        halves.append(half(k, pairs, own.reshape(2, 2, -1)[:, :, pairs]))
        dense[ids[-1][:, None], :, ids[-1][None], :] += own.transpose(2, 3, 0, 1)
    return ids, halves, dense.reshape(2 * FUNCTIONS, -1)


@pytest.mark.parametrize("n_multipliers", [0, 1])
def test_blocks_are_a_part_of_the_sum(n_multipliers: int) -> None:
    rng = np.random.default_rng(63)
    without, dense = sample(rng, n_multipliers)
    ids, halves, own = some_blocks(rng)
    dense[: len(own), : len(own)] += own
    found = replace(without, blocks=blocks_of(ids, halves, np.array([1, 0, 1, 0])))
    vectors = rng.normal(size=(len(dense), 2))
    np.testing.assert_allclose(found @ vectors, dense @ vectors, atol=1e-13)
    np.testing.assert_allclose(found.tocsc().toarray(), dense, atol=1e-14)
    np.testing.assert_allclose(found.diagonal(), dense.diagonal(), atol=1e-14)
    assert (found.sizes(vectors) >= np.abs(dense) @ np.abs(vectors) - 1e-13).all()
    broken = blocks_of([ids[1]], [half(1, np.array([0]), np.full((2, 2, 1), np.nan))], np.array([0]))
    assert np.isnan(replace(found, blocks=broken).largest())


def test_parts_whose_blocks_are_known_are_taken_over() -> None:
    ids, halves, _ = some_blocks(np.random.default_rng(64))
    group = np.array([0, 0, 1, 1])
    before = blocks_of(ids, halves, group)
    other = half(1, np.array([0]), np.ones((2, 2, 1)))
    after = blocks_of([some + 1 for some in ids], [halves[0], other, *halves[2:]], group, before)
    assert after.parts[1].sum is before.parts[1].sum
    assert after.parts[0].sum is not before.parts[0].sum
    np.testing.assert_array_equal(after.parts[1].dofs, before.parts[1].dofs + 2)
    fresh = blocks_of([some + 1 for some in ids], [halves[0], other, *halves[2:]], group)
    for ours, alone in zip(after.parts, fresh.parts, strict=True):
        assert ours.key == alone.key
        np.testing.assert_array_equal(ours.sum.tocsc().toarray(), alone.sum.tocsc().toarray())
