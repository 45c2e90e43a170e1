"""What a factorization takes over from another one is what it would find alone, to the last bit; no more is kept."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.sparse import csr_array

from crackgrow.direct import multifrontal as module
from crackgrow.direct.fronts import Fronts
from crackgrow.direct.matrix import SymmetricMatrix
from crackgrow.direct.multifrontal import Multifrontal
from tests.conftest import Build
from tests.unit.direct.test_direct_multifrontal import plate

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@pytest.fixture(scope="module")
def rock() -> tuple[SymmetricMatrix, Fronts]:
    """A plate of many fronts, some of which are alike."""
    return plate(Build, 60)


def changed(matrix: SymmetricMatrix, dof: int) -> SymmetricMatrix:
    """The matrix, stiffer at one unknown."""
    return matrix.with_diagonal(np.array([dof]), np.array([0.5]))


def test_factors_handed_over_are_held_once(rock: tuple[SymmetricMatrix, Fronts]) -> None:
    """What the next factorization does not take over is let go of, and nothing is solved with the rest."""
    matrix, fronts = rock
    later = changed(matrix, matrix.shape[0] // 3)
    before, alone = Multifrontal(matrix, fronts), Multifrontal(later, fronts)
    known = before.kept.factors
    assert known.keys() - alone.factors.keys()
    before.hand_over()
    after = Multifrontal(later, fronts, before.kept)
    assert 0 < after.n_factorized < alone.n_factorized
    assert known.keys() < after.factors.keys()
    assert all(after.factors[key] is factor for key, factor in known.items())
    load = np.random.default_rng(1).normal(size=matrix.shape[0])
    np.testing.assert_array_equal(after.solve(load), alone.solve(load))
    with pytest.raises(RuntimeError, match="handed over"):
        before.solve(load)


def right_hand_sides(n: int, rows: Ints) -> csr_array:
    """One of each of some rows, and of the one after it."""
    k = len(rows)
    values = np.random.default_rng(60).normal(size=(k, 2))
    columns = np.repeat(np.arange(k), 2)
    return csr_array((values.ravel(), ((rows[:, None] + np.arange(2)).ravel(), columns)), shape=(n, k))


def test_products_taken_over_are_those_found_alone(rock: tuple[SymmetricMatrix, Fronts]) -> None:
    """After a change at one unknown, and a right-hand side more near it: columns behind it have other numbers then."""
    matrix, fronts = rock
    n = matrix.shape[0]
    rows = np.sort(np.random.default_rng(61).choice(n - 1, 80, replace=False))
    before = Multifrontal(matrix, fronts)
    before.products(right_hand_sides(n, rows))
    old = before.kept
    more = csr_array(right_hand_sides(n, np.append(rows, n // 3))[:, np.insert(np.arange(80), 20, 80)])
    after, alone = Multifrontal(changed(matrix, n // 3), fronts, old), Multifrontal(changed(matrix, n // 3), fronts)
    np.testing.assert_array_equal(after.products(more), alone.products(more))
    ours, theirs = after.kept.reduced, old.reduced
    assert ours.keys() == alone.kept.reduced.keys()
    assert all(ours[key] is theirs[key] for key in ours.keys() & theirs.keys())
    assert len(ours.keys() - theirs.keys()) < 0.4 * len(ours)
    solved = more.T @ after.solve(more.toarray())
    np.testing.assert_allclose(after.products(more), solved, atol=1e-12 * np.abs(solved).max())


@pytest.mark.parametrize("change", ["value", "place", "order", "fewer", "one subtree for another"])
def test_all_that_products_depend_on_is_in_their_keys(rock: tuple[SymmetricMatrix, Fronts], change: str) -> None:
    matrix, fronts = rock
    n = matrix.shape[0]
    rows = np.sort(np.random.default_rng(62).choice(n - 1, 30, replace=False))
    known = Multifrontal(matrix, fronts)
    right = right_hand_sides(n, rows)
    known.products(right)
    twins = np.flatnonzero(fronts.n_placed == np.bincount(fronts.n_placed[:-1]).argmax())  # fronts that may be alike
    others = {
        "value": right * np.where(np.arange(30) == 7, 1.5, 1.0),
        "place": right_hand_sides(n, np.sort(np.append(rows[1:], rows[0] + 3))),
        "order": csr_array(right[:, ::-1]),
        "fewer": csr_array(right[:, 3:]),
    }
    if change == "one subtree for another":
        first, second = (right_hand_sides(n, fronts.order[fronts.starts[twins[k]] + np.arange(2)]) for k in (0, -1))
        known.products(first)
        others[change] = second
    after = Multifrontal(matrix, fronts, known.kept)
    np.testing.assert_array_equal(after.products(others[change]), Multifrontal(matrix, fronts).products(others[change]))


def test_products_of_the_last_matrix_alone_are_kept(rock: tuple[SymmetricMatrix, Fronts]) -> None:
    """However many changes there are, one after the other."""
    matrix, fronts = rock
    n = matrix.shape[0]
    right = right_hand_sides(n, np.arange(0, n - 1, n // 50))
    last = Multifrontal(matrix, fronts)
    counts = []
    for dof in np.linspace(0, n - 1, 5).astype(np.int64).tolist():
        last = Multifrontal(changed(matrix, dof), fronts, last.kept)
        last.products(right)
        counts.append(len(last.kept.reduced))
    assert max(counts) <= fronts.n - 1


@pytest.mark.parametrize("few", [0, 3, 10**6])
def test_what_fronts_leave_is_the_same_whether_kept_or_made_again(
    rock: tuple[SymmetricMatrix, Fronts], few: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """All of it kept at first, that of most, that of none but twins; what was made again is kept from then on."""
    matrix, fronts = rock
    n = matrix.shape[0]
    right = np.random.default_rng(63).normal(size=(n, 2))
    expected = Multifrontal(changed(matrix, n // 3), fronts).solve(right)
    monkeypatch.setattr(module, "FEW_FRONTS", few)
    before = Multifrontal(matrix, fronts)
    n_kept = []
    for _ in range(3):
        n_kept.append(sum(factor.packed is not None for factor in before.factors.values()))
        after = Multifrontal(changed(matrix, n // 3), fronts, before.kept)
        assert 0 < after.n_factorized < 0.3 * fronts.n
        np.testing.assert_array_equal(after.solve(right), expected)
    assert n_kept[0] < n_kept[1] == n_kept[2] or few == 0


def test_small_subtrees_do_not_keep_what_they_leave(rock: tuple[SymmetricMatrix, Fronts]) -> None:
    """It is more than half of it all."""
    factors = Multifrontal(*rock).factors.values()
    all_of_it = sum(len(factor.sizes) * (len(factor.sizes) + 1) // 2 for factor in factors)
    kept = sum(factor.packed.size for factor in factors if factor.packed is not None)
    assert 0 < kept < 0.5 * all_of_it


def test_one_load_is_solved_for_as_many_are(rock: tuple[SymmetricMatrix, Fronts]) -> None:
    """Though by other kernels; also with multipliers."""
    matrix, fronts = rock
    solver = Multifrontal(matrix, fronts)
    loads = np.random.default_rng(64).normal(size=(matrix.shape[0], 3))
    together = solver.solve(loads)
    for load, u in zip(loads.T, together.T, strict=True):
        np.testing.assert_allclose(solver.solve(load), u, atol=1e-12 * np.abs(u).max())
