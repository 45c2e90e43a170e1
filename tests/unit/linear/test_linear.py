"""The direct solver: exact, repeated and contradicting constraints, singular and hopeless matrices, sizes of fronts."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse import block_array, block_diag, csc_array, csr_array, diags_array
from scipy.sparse.linalg import splu

from crackgrow.arrays import Floats, Ints
from crackgrow.errors import SolveError
from crackgrow.linear import ConstrainedSystem
from crackgrow.linear.factorization import Factorization
from crackgrow.linear.fronts import fronts_of
from tests.conftest import dense_system, one_front, symmetric

N = 30
NO_TIES = (np.zeros(1, dtype=np.int64), np.zeros(0, dtype=np.int64))


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


REACH = 2


def boxes_at(nodes: Ints, reach: int = REACH) -> tuple[Ints, Ints]:
    """Boxes round nodes (n, 2), which overlap where nodes are at most `reach` apart along both axes."""
    return 2 * nodes - reach, 2 * nodes + reach + 1


def lattice(n: int, seed: int, reach: int = REACH) -> tuple[csc_array, Ints]:
    """A random positive definite matrix of two unknowns per node of an n x n lattice, and its nodes (n n, 2)."""
    rng = np.random.default_rng(seed)
    nodes = np.stack(np.meshgrid(np.arange(n), np.arange(n), indexing="ij"), axis=2).reshape(-1, 2)
    places = np.repeat(nodes, 2, axis=0)
    near = np.abs(places[:, None] - places).max(axis=2) <= reach
    dense = np.where(np.triu(near, 1), rng.uniform(-1.0, 1.0, near.shape), 0.0)
    dense += dense.T
    np.fill_diagonal(dense, np.abs(dense).sum(axis=1) + rng.uniform(0.01, 1.0, len(dense)))
    scale = 10.0 ** rng.uniform(-2.0, 2.0, len(dense))
    return csc_array(dense * np.outer(scale, scale)), nodes


def solved(factorization: Factorization, loads: Floats) -> Floats:
    return factorization.solve(loads.reshape(len(loads), -1), np.zeros((0, loads.size // len(loads))))[0]


@pytest.mark.parametrize("n", [1, 2, 5, 12, 25])
@pytest.mark.parametrize("placed", [True, False])
def test_solutions_are_those_of_superlu(n: int, placed: bool) -> None:
    """Of one load, of many, and of many each of which acts in one place."""
    matrix, nodes = lattice(n, n)
    boxes = boxes_at(nodes) if placed else one_front(len(nodes))
    factorization = Factorization(symmetric(matrix), csr_array((0, 2 * len(nodes))), boxes)
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


@pytest.mark.parametrize("off", [1e-5, 1e-3])
def test_a_factorization_that_is_off_changes_no_solution(off: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """Every solve checks its residual and refines."""
    (system, matrix, constraints), rng = constrained(12, 18), np.random.default_rng(22)
    loads, given = rng.normal(size=(matrix.shape[0], 3)), constraints @ rng.normal(size=(matrix.shape[0], 3))
    expected, exact = system.solve(loads, given), Factorization.solve

    def rough(self: Factorization, *of: Floats) -> tuple[Floats, ...]:
        return tuple(x * (1.0 + off * rng.choice([-1.0, 1.0], (len(x), 1))) for x in exact(self, *of))

    monkeypatch.setattr(Factorization, "solve", rough)
    for found, known in zip(system.solve(loads, given), expected, strict=True):
        np.testing.assert_allclose(found, known, atol=1e-9 * np.abs(known).max())


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


@pytest.mark.parametrize("n", [5, 20])
def test_ties_hold_two_lattices_together(n: int) -> None:
    """Rigid and soft ties across a crack, one far away, of which one lattice has the only support."""
    matrix, nodes = lattice(n, 12)
    both, size = csc_array(block_diag([matrix, matrix])), len(nodes)
    rng = np.random.default_rng(3)
    ties = np.zeros((2 * n + 1, 4 * size))
    for k, row in enumerate(ties):
        near = 2 * np.clip(n * (k // 2) + np.arange(3), 0, size - 1) + k % 2
        row[near], row[2 * size + near] = rng.uniform(0.5, 1.0, 3), -rng.uniform(0.5, 1.0, 3)
    ties[-1, 2 * size - 1] = 1.0
    softness = np.where(np.arange(2 * n + 1) % 3 == 2, 0.1, 0.0)
    held = ConstrainedSystem(
        symmetric(both), csr_array(([1.0], [0], [0, 1]), (1, 4 * size)), boxes_at(np.tile(nodes, (2, 1)))
    )
    system = held.tied(csr_array(ties), softness)
    loads, given = rng.normal(size=4 * size), rng.normal(size=2 * n + 2)
    u, m = system.solve(loads, given)
    constraints, soft = np.vstack([held.constraints.toarray(), ties]), np.append(0.0, softness)
    bordered = np.block([[both.toarray(), constraints.T], [constraints, -np.diag(soft)]])
    known = np.linalg.solve(bordered, np.append(loads, given))
    np.testing.assert_allclose(np.append(u, m), known, atol=1e-10 * np.abs(known).max())
    rows = csr_array(np.eye(len(known))[4 * size + 1 :])  # of the multipliers of ties
    expected = np.linalg.inv(bordered)[4 * size + 1 :, 4 * size + 1 :]
    np.testing.assert_allclose(system.compliance(rows), expected, atol=1e-10 * np.abs(expected).max())


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
    system = ConstrainedSystem(
        symmetric(semidefinite), csr_array((0, len(x))), boxes_at(np.vstack([nodes, nodes[twins]]))
    )
    u, _ = system.solve(loads)
    assert np.abs(u).max() < 2.0 * np.abs(x).max()
    np.testing.assert_allclose(spread @ u, spread @ x, rtol=0.0, atol=1e-8 * np.abs(x).max())
    assert u @ (semidefinite @ u) == pytest.approx(x @ loads, rel=1e-12)


@pytest.mark.physics
def test_separators_of_a_lattice_are_as_wide_as_the_couplings_reach() -> None:
    """40 x 40 nodes that reach 2 nodes far: two columns of nodes separate, 160 unknowns; L has few entries."""
    matrix, nodes = lattice(40, 17)
    fronts = fronts_of(symmetric(matrix), csr_array((0, 3200)), NO_TIES, boxes_at(nodes))
    own, border = np.diff(fronts.starts), np.diff(fronts.border_start)
    assert own[-2:].tolist() == [160, 0]  # the last one is for what is in several pieces from the beginning
    assert np.sum(own * (own + border)) < 0.15 * matrix.shape[0] ** 2


def test_couplings_beyond_the_boxes_are_refused() -> None:
    matrix, nodes = lattice(30, 7)
    wrong = np.random.default_rng(9).permutation(nodes)
    with pytest.raises(ValueError, match="further apart than couplings reach"):
        fronts_of(symmetric(matrix), csr_array((0, 1800)), NO_TIES, boxes_at(wrong))
