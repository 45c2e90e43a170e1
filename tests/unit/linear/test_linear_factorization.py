"""The multifrontal factorization against dense and sparse solutions; hopeless matrices."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse import block_array, block_diag, csc_array, csr_array
from scipy.sparse.linalg import splu

from crackgrow.linear import ConstrainedSystem
from crackgrow.linear.factorization import Factorization
from tests.symmetric_matrices import one_front, symmetric
from tests.unit.linear.lattices import Floats, boxes_at, lattice, net

pytestmark = pytest.mark.physics


def none(n: int) -> csr_array:
    """No constraints."""
    return csr_array((0, n))


def solved(factorization: Factorization, loads: Floats) -> Floats:
    return factorization.solve(loads.reshape(len(loads), -1), np.zeros((0, loads.size // len(loads))))[0]


@pytest.mark.parametrize("n", [1, 2, 5, 12, 25])
@pytest.mark.parametrize("placed", [True, False])
def test_solutions_are_those_of_superlu(n: int, placed: bool) -> None:
    """Of one load, of many, and of many each of which acts in one place."""
    matrix, nodes = lattice(n, n)
    boxes = boxes_at(nodes) if placed else one_front(len(nodes))
    factorization = Factorization(symmetric(matrix), none(len(nodes) * 2), boxes)
    loads = np.random.default_rng(1).normal(size=(2 * n * n, 7))
    loads[:, 5:] = np.eye(len(loads), 2, -n)
    expected = splu(matrix).solve(loads)
    np.testing.assert_allclose(solved(factorization, loads), expected, atol=1e-12 * np.abs(expected).max())
    one = solved(factorization, loads[:, 0])[:, 0]
    np.testing.assert_allclose(one, expected[:, 0], atol=1e-12 * np.abs(expected).max())


def constrained(n: int, seed: int) -> tuple[ConstrainedSystem, csc_array, csr_array]:
    """A system held by single unknowns, averages across the lattice and repetitions of both."""
    matrix, nodes = lattice(n, seed)
    rng = np.random.default_rng(seed + 1)
    rows = np.zeros((12, matrix.shape[0]))
    for row in rows[:5]:
        row[rng.integers(len(row))] = 1.0
    for row in rows[5:9]:
        row[rng.integers(len(row), size=10)] = rng.uniform(0.0, 0.1, 10)
    rows[9:] = rows[[0, 5, 5]]
    constraints = csr_array(rows)
    return ConstrainedSystem(symmetric(matrix), constraints, boxes_at(nodes)), matrix, constraints


@pytest.mark.parametrize("k", [1, 3])
@pytest.mark.parametrize("n", [5, 12, 20])
def test_constraints_hold_also_where_they_repeat_each_other(n: int, k: int) -> None:
    system, matrix, constraints = constrained(n, 18)
    scale = np.sqrt(matrix.diagonal())
    loads = scale[:, None] * np.random.default_rng(20).normal(size=(len(scale), k))
    given = constraints @ np.random.default_rng(21).normal(size=(len(scale), k))
    u, m = system.solve(loads, given)
    some = constraints[:9] + 0.0  # the others repeat these
    bordered = csc_array(block_array([[matrix, some.T], [some, None]]))
    expected = splu(bordered).solve(np.concatenate([loads, given[:9]]))[: len(loads)]
    size = np.abs(u).max()
    np.testing.assert_allclose(u, expected, atol=1e-10 * size)
    np.testing.assert_allclose(constraints @ u, given, atol=1e-13 * size)
    assert np.abs(matrix @ u + constraints.T @ m - loads).max() < 1e-11 * (abs(matrix) @ np.abs(u)).max()


@pytest.mark.parametrize("n", [5, 20])
def test_compliance_is_that_of_solutions(n: int) -> None:
    """With constraints that reach far and repeat each other; rows that act nowhere, twice, or in parts."""
    system, matrix, _ = constrained(n, 18)
    rng = np.random.default_rng(41)
    rows = np.zeros((22, matrix.shape[0]))
    for row in rows[:20]:
        row[rng.integers(len(row), size=6)] = rng.normal(size=6)
    rows[20] = rows[3]
    rows *= np.sqrt(matrix.diagonal())
    found = system.compliance(csr_array(rows))
    expected = rows @ system.solve(rows.T.copy())[0]
    np.testing.assert_array_equal(found, found.T)
    np.testing.assert_allclose(found, expected, atol=1e-13 * np.abs(expected).max())
    parts = csr_array((np.full(2, 0.5), [4, 4], [0, 2]), shape=(1, matrix.shape[0]))
    whole = csr_array(([1.0], [4], [0, 1]), shape=(1, matrix.shape[0]))
    np.testing.assert_array_equal(system.compliance(parts), system.compliance(whole))


def test_separate_pieces_are_solved_and_condensed_each_by_itself() -> None:
    """Their fronts have nothing later that they are coupled to."""
    (one, nodes), (other, _) = lattice(9, 1), lattice(9, 2)
    matrix = csc_array(block_diag([one, other], format="csc"))
    boxes = boxes_at(np.concatenate([nodes, nodes + 100]))
    system = ConstrainedSystem(symmetric(matrix), none(matrix.shape[0]), boxes)
    dense, rng = matrix.toarray(), np.random.default_rng(3)
    loads = rng.normal(size=len(dense))
    np.testing.assert_allclose(dense @ system.solve(loads)[0], loads, atol=1e-10)
    rows = csr_array(rng.normal(size=(12, len(dense))) * (rng.uniform(size=(12, len(dense))) < 0.1))
    expected = rows @ np.linalg.solve(dense, rows.toarray().T)
    np.testing.assert_allclose(system.compliance(rows), expected, atol=1e-10 * np.abs(expected).max())


def test_a_body_within_one_part_is_held_by_bonds_to_the_rest() -> None:
    """Springs in a corner that only averages tie to a body beyond it; that of them which reaches far, too."""
    n = 16
    matrix, nodes = net(n, 5, ground=1e-3)
    inner = ((nodes[:, 0] < 4) & (nodes[:, 1] < 4)).repeat(2)
    dense = matrix.toarray()
    dense[np.ix_(inner, ~inner)] = dense[np.ix_(~inner, inner)] = 0.0
    own = np.flatnonzero(inner)
    corner = dense[np.ix_(own, own)]
    np.fill_diagonal(corner, 0.0)
    np.fill_diagonal(corner, -corner.sum(axis=1))
    dense[np.ix_(own, own)] = corner
    bonds = np.zeros((3, 2 * n * n))
    bonds[0, [own[3], own[5]]], bonds[0, np.flatnonzero(~inner)[:2]] = 0.5, -0.5
    bonds[1, own[-2:]], bonds[1, [-4, -1]] = 0.5, -0.5
    bonds[2, own[0]] = 1.0
    for rows in (bonds, bonds[:2], bonds[1:2]):
        system = ConstrainedSystem(symmetric(dense), csr_array(rows), boxes_at(nodes))
        whole = np.block([[dense, rows.T], [rows, np.zeros((len(rows), len(rows)))]])
        loads = np.random.default_rng(7).normal(size=len(dense))
        expected = np.linalg.solve(whole, np.append(loads, np.zeros(len(rows))))
        u, m = system.solve(loads)
        np.testing.assert_allclose(np.append(u, m), expected, atol=1e-8 * np.abs(expected).max())


@pytest.mark.parametrize("small", [1e-6, 1e-10, 1e-13])
def test_nearly_singular_matrix_leaves_a_small_residual(small: float) -> None:
    matrix, nodes = net(20, 25, small)
    loads = matrix @ np.random.default_rng(26).normal(size=matrix.shape[0])
    u, _ = ConstrainedSystem(symmetric(matrix), none(len(loads)), boxes_at(nodes)).solve(loads)
    np.testing.assert_allclose(matrix @ u, loads, atol=1e-12 * (abs(matrix) @ np.abs(u)).max())


@pytest.mark.parametrize("seed", [0, 1])
def test_unknowns_that_depend_on_each_other_stay_small(seed: int) -> None:
    """As functions on a sliver of rock do: the matrix is semidefinite, and by round-off indefinite."""
    matrix, nodes = lattice(12, 31)
    n, rng = len(nodes), np.random.default_rng(seed)
    twins = rng.choice(n, 30, replace=False)
    spread = np.kron(np.hstack([np.eye(n), np.eye(n)[:, twins] * rng.uniform(0.5, 2.0, 30)]), np.eye(2))
    semidefinite = csc_array(spread.T @ matrix @ spread)
    x = rng.normal(size=len(spread.T))
    loads = semidefinite @ x
    system = ConstrainedSystem(symmetric(semidefinite), none(len(x)), boxes_at(np.vstack([nodes, nodes[twins]])))
    u, _ = system.solve(loads)
    assert np.abs(u).max() < 2.0 * np.abs(x).max()
    np.testing.assert_allclose(spread @ u, spread @ x, rtol=0.0, atol=1e-8 * np.abs(x).max())
    assert u @ (semidefinite @ u) == pytest.approx(x @ loads, rel=1e-12)
