"""The constrained solve: exact constraints, repeated and contradicting ones, singular systems; symmetric matrices."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.sparse import csc_array, csr_array, diags_array

from crackgrow.errors import SolveError
from crackgrow.linear import ConstrainedSystem
from crackgrow.linear.factorization import Factorization
from tests.symmetric_matrices import dense_system, one_front, symmetric, whole

N = 30


def chain() -> csc_array:
    """Springs in a row, free at both ends: singular."""
    matrix = diags_array([-np.ones(N - 1), 2 * np.ones(N), -np.ones(N - 1)], offsets=[-1, 0, 1]).tolil()
    matrix[0, 0] = matrix[N - 1, N - 1] = 1.0
    return csc_array(matrix)


def rows(*entries: dict[int, float]) -> csr_array:
    matrix = np.zeros((len(entries), N))
    for row, entry in zip(matrix, entries, strict=True):
        row[list(entry)] = list(entry.values())
    return csr_array(matrix)


def definite(seed: int) -> csc_array:
    a = np.random.default_rng(seed).normal(size=(N, N))
    return csc_array(a @ a.T + np.eye(N))


def test_factorization_solves_badly_scaled_matrices() -> None:
    scale = np.logspace(-6, 6, N)
    matrix = csc_array(scale[:, None] * definite(40).toarray() * scale)
    x = np.random.default_rng(41).normal(size=(N, 3)) / scale[:, None]
    u, _ = Factorization(symmetric(matrix), csr_array((0, N)), one_front(N // 2)).solve(matrix @ x, np.zeros((0, 3)))
    np.testing.assert_allclose(u, x, rtol=1e-8)


APART = rows({0: 1.0}, {4: 0.5, 5: 0.5}, {N - 1: 1.0, 0: 2.0})
REPEATED = rows({0: 1.0}, {0: 1.0}, {0: 2.0, 3: 1.0}, {3: 1.0})


@pytest.mark.parametrize(
    ("matrix", "constraints"), [(definite(42), APART), (chain(), REPEATED)], ids=["apart", "repeated"]
)
def test_solutions_satisfy_both_equations_for_one_load_and_for_many(matrix: csc_array, constraints: csr_array) -> None:
    """With prescribed values that are the same for all loads, or their own; one by one the solutions are the same."""
    rng, system = np.random.default_rng(43), dense_system(matrix, constraints)
    loads, own = rng.normal(size=(N, 4)), constraints @ rng.normal(size=(N, 4))
    for given in (own, own[:, 0], None):
        together, multipliers = system.solve(loads, given)
        for k in range(4):
            mine = given if given is None or given.ndim == 1 else given[:, k]
            u, m = system.solve(loads[:, k], mine)
            np.testing.assert_allclose(constraints @ u, 0.0 if mine is None else mine, atol=1e-12)
            np.testing.assert_allclose(matrix @ u + constraints.T @ m, loads[:, k], atol=1e-11)
            np.testing.assert_allclose(together[:, k], u, atol=1e-13)
            np.testing.assert_allclose(multipliers[:, k], m, atol=1e-12)


def test_answer_does_not_depend_on_the_scale_of_a_constraint() -> None:
    """The penalty that holds a singular matrix changes by a factor of 1e6: u does not, the multiplier scales back."""
    stiffness, constraints = definite(44), rows({0: 1.0}, {7: 1.0})
    loads = np.ones(N)
    given = np.array([0.3, -0.2])
    scale = np.array([1.0, 1e3])
    u, m = dense_system(stiffness, constraints).solve(loads, given)
    scaled_u, scaled_m = dense_system(stiffness, csr_array(diags_array(scale) @ constraints)).solve(
        loads, scale * given
    )
    np.testing.assert_allclose(scaled_u, u, atol=1e-11)
    np.testing.assert_allclose(scale * scaled_m, m, atol=1e-9)


def test_singular_stiffness_is_held_by_constraints() -> None:
    """A chain pulled at its end: displacement grows by one per spring; the support carries the pull."""
    loads = np.zeros(N)
    loads[-1] = 1.0
    u, m = dense_system(chain(), rows({0: 1.0})).solve(loads, np.array([5.0]))
    np.testing.assert_allclose(u, 5.0 + np.arange(N), rtol=1e-12)
    np.testing.assert_allclose(m, [1.0], rtol=1e-11)


def dependent(seed: int) -> csr_array:
    """Three constraints, and a fourth that is the sum of two."""
    own = np.random.default_rng(seed).normal(size=(3, N))
    return csr_array(np.vstack([own, own[0] + own[1]]))


@pytest.mark.parametrize("scale", [1e-30, 1.0, 1e9])
@pytest.mark.parametrize("load", [0.0, 1.0, 1e12])
def test_constraints_that_contradict_are_refused_whatever_acts_besides(load: float, scale: float) -> None:
    """Neither loads, and what they displace, nor what other constraints prescribe hides it; nor other load cases."""
    system, loads = dense_system(definite(45), dependent(7)), np.full(N, load * scale)
    agreed = scale * np.array([1.0, 2.0, 0.0, 3.0])
    contradicting = agreed + scale * np.array([0.0, 0.0, 0.0, 1e-5])
    for given in (contradicting, np.stack([agreed, contradicting], axis=1)):
        with pytest.raises(SolveError, match="contradict each other by"):
            system.solve(loads if given.ndim == 1 else np.stack([loads, loads], axis=1), given)
    assert np.isfinite(system.solve(loads, agreed)[0]).all()
    beside_a_far_larger_value = dense_system(definite(45), csr_array(np.eye(N)[[0, 0, 3]]))
    with pytest.raises(SolveError, match="contradict each other"):
        beside_a_far_larger_value.solve(loads, scale * np.array([1.0, 2.0, 1e7]))


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("given", [0.0, 1e-12])
def test_constraints_that_take_all_loads_do_not_contradict(given: float, seed: int) -> None:
    """Rock at rest on rollers: what is left of displacements is round-off of the loads, not of itself."""
    constraints = dependent(seed)
    loads = constraints.T @ (1e7 * np.random.default_rng(seed).normal(size=4))
    u, _ = dense_system(definite(45), constraints).solve(loads, given * np.array([1.0, 2.0, 0.0, 3.0]))
    assert np.abs(u).max() < 1e-7


@pytest.mark.parametrize("n_rigid", [0, 2])
def test_compliant_constraints_give_way_by_their_forces(n_rigid: int) -> None:
    """C u - B m = g, as the whole system solved densely, for loads, for what is given and for the compliance."""
    rng = np.random.default_rng(3)
    matrix, rows_of = definite(7), rng.normal(size=(n_rigid + 2, N))
    compliance = np.append(np.zeros(n_rigid), [1e-3, 10.0])
    system = ConstrainedSystem(symmetric(matrix), csr_array(rows_of), one_front(N // 2), compliance)
    whole = np.block([[matrix.toarray(), rows_of.T], [rows_of, -np.diag(compliance)]])
    loads, given = rng.normal(size=(N, 3)), rng.normal(size=(n_rigid + 2, 3))
    exact = np.linalg.solve(whole, np.vstack([loads, given]))
    np.testing.assert_allclose(np.vstack(system.solve(loads, given)), exact, atol=1e-12 * np.abs(exact).max())
    seen = rng.normal(size=(4, N))
    of_seen = seen @ np.linalg.inv(whole)[:N, :N] @ seen.T
    np.testing.assert_allclose(system.compliance(csr_array(seen)), of_seen, atol=1e-12 * np.abs(of_seen).max())


@pytest.mark.parametrize("size", [0.0, 5e-324, 1e-310, 1e-290])
def test_loads_may_be_as_small_as_numbers_are(size: float) -> None:
    """Springs that give way leave such loads behind where nothing acts on the rock."""
    u, m = dense_system(definite(42), rows({0: 1.0})).solve(np.full(N, size))
    assert np.abs(u).max() <= 100.0 * size
    assert np.isfinite(m).all()


def test_a_free_body_stays_where_it_is_if_nothing_pushes_it() -> None:
    """Springs between pairs of unknowns: what stretches them is found, where they lie is not arbitrary."""
    disconnected = csc_array(np.kron(np.eye(N // 2), [[1.0, -1.0], [-1.0, 1.0]]))
    loads = np.tile([1.0, -1.0], N // 2)
    u, _ = dense_system(disconnected, csr_array((0, N))).solve(loads)
    np.testing.assert_allclose(disconnected @ u, loads, atol=1e-9)
    assert np.abs(u).max() < 2.0


@pytest.mark.parametrize(
    ("value", "words"), [(0.0, "1 of 30 unknowns have no stiffness"), (np.nan, "not finite")], ids=["zero", "nan"]
)
def test_unknowns_without_stiffness_and_entries_that_are_no_numbers_are_refused(value: float, words: str) -> None:
    matrix = np.eye(N)
    matrix[3, 3] = value
    with pytest.raises(SolveError, match=words):
        Factorization(symmetric(matrix), csr_array((0, N)), one_front(N // 2))


@pytest.mark.parametrize("n", [1, 2, 9])
def test_a_symmetric_matrix_by_its_lower_blocks_can_what_the_dense_one_can(n: int) -> None:
    """Of a random matrix of n functions, some of which have no block with themselves."""
    rng = np.random.default_rng(61)
    dense = rng.normal(size=(2 * n, 2 * n)) * (rng.uniform(size=(2 * n, 2 * n)) < 0.2)
    dense += dense.T
    found = symmetric(dense)
    vectors = rng.normal(size=(2 * n, 3))
    for some in (vectors, vectors[:, 0]):
        np.testing.assert_allclose(found @ some, dense @ some, atol=1e-14)
        np.testing.assert_allclose(found.sizes(some), np.abs(dense) @ np.abs(some), atol=1e-14)
    assert whole(found).nnz == np.count_nonzero(dense)
    np.testing.assert_array_equal(found.diagonal(), dense.diagonal())
    assert found.largest() == np.abs(dense).max()
    assert np.isnan(replace(found, block=np.full_like(found.block, np.nan)).largest())
    for row in range(n):
        columns = found.column[found.start[row] : found.start[row + 1]]
        assert (np.diff(columns) > 0).all()
        assert columns[-1] == row
    places, values = np.array([0, 2 * n - 1, 2 * n - 1]), np.array([1.0, 2.0, 4.0])
    more = found.with_diagonal(places, values)
    np.testing.assert_array_equal(whole(found).toarray(), dense)
    np.add.at(dense, (places, places), values)
    np.testing.assert_array_equal(whole(more).toarray(), dense)
